# Writes the parts of a page as a constant of a C++ file.
set(text "#include \"tools/${NAME}/page_assets.h\"\n\nnamespace ff::${NAME} {\n\nconst page::PageParts kPage{\n")
set(HTML ${FOLDER}/page.html)
set(STYLE ${FOLDER}/page.css)
set(CHART ${CHART})
set(SCRIPT ${FOLDER}/page.js)
foreach(part HTML STYLE CHART SCRIPT)
  file(READ ${${part}} content)
  string(TOLOWER ${part} name)
  # GCC takes literals of any length; the delimiter occurs in none of them.
  string(APPEND text ".${name} = R\"_embed_(${content})_embed_\",\n")
endforeach()
string(APPEND text "};\n\n}  // namespace ff::${NAME}\n")
file(WRITE ${OUT} "${text}")
