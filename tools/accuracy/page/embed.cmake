# Writes the parts of the lab's page as constants of a C++ file.
set(text "#include \"tools/accuracy/page_assets.h\"\n\nnamespace ff::accuracy {\n\n")
foreach(part HTML STYLE SCRIPT CHART)
  file(READ ${${part}} content)
  string(TOLOWER ${part} name)
  # GCC takes literals of any length; the delimiter occurs in none of them.
  string(APPEND text "const std::string_view kPage_${name} = R\"_embed_(${content})_embed_\";\n\n")
endforeach()
string(APPEND text "}  // namespace ff::accuracy\n")
file(WRITE ${OUT} "${text}")
