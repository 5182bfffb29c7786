# What a game built on Farfield needs of CMake: cooking its world, installing it, packing it. Part of find_package(Farfield).
#
#   farfield_add_game(lighthouse SOURCES main.cpp SCENE scene.toml CONTENT models textures)
#   farfield_install_game(lighthouse TITLE "Lighthouse" SUMMARY "Light it before the ships come" ICON icon.svg LICENCE LICENSE)
#   farfield_package_game(lighthouse CONTACT "Me <me@example.org>")
#
# A program PREFIX/bin/NAME finds its world as PREFIX/share/NAME/world.ffpack, in the build folder as where it is installed.

include(GNUInstallDirs)
set(FARFIELD_GAME_MODULE_DIR ${CMAKE_CURRENT_LIST_DIR})
# Debian's packages whose code is compiled into a game rather than loaded by it: headers and static libraries.
set(FARFIELD_COMPILED_IN libglm-dev libimgui-dev libflatbuffers-dev nlohmann-json3-dev libxxhash-dev libepoxy-dev)

# farfield_add_game(NAME SOURCES file... SCENE scene.toml [CONTENT folder...])
# The program, and its world, which is cooked anew when the scene or a file in the folders changed.
function(farfield_add_game name)
  cmake_parse_arguments(ARG "" "SCENE" "SOURCES;CONTENT" ${ARGN})
  if(NOT FARFIELD_FF)
    message(FATAL_ERROR "`ff`, which cooks ${ARG_SCENE}, was found neither beside the engine nor in PATH: install farfield-tools, or set FARFIELD_FF")
  endif()
  add_executable(${name} ${ARG_SOURCES})
  target_compile_features(${name} PRIVATE cxx_std_20)
  # As the engine's own: recordings replay bit for bit only where no compiler fuses a multiplication with an addition.
  target_compile_options(${name} PRIVATE -ffp-contract=off -fmacro-prefix-map=${CMAKE_SOURCE_DIR}/=)
  target_link_libraries(${name} PRIVATE Farfield::host Farfield::physics)
  set_target_properties(${name} PROPERTIES RUNTIME_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/bin)

  set(content ${ARG_SCENE})
  foreach(folder ${ARG_CONTENT})
    file(GLOB_RECURSE files CONFIGURE_DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/${folder}/*)
    list(APPEND content ${files})
  endforeach()
  set(pack ${CMAKE_BINARY_DIR}/share/${name}/world.ffpack)
  add_custom_command(OUTPUT ${pack}
    COMMAND ${CMAKE_COMMAND} -E make_directory ${CMAKE_BINARY_DIR}/share/${name}
    COMMAND ${FARFIELD_FF} cook ${CMAKE_CURRENT_SOURCE_DIR}/${ARG_SCENE} -o ${pack} --cache ${CMAKE_BINARY_DIR}/cook-cache
    DEPENDS ${content} COMMENT "Cooking ${ARG_SCENE}" VERBATIM)
  add_custom_target(${name}_world ALL DEPENDS ${pack})
  set_target_properties(${name} PROPERTIES FARFIELD_WORLD ${pack})
endfunction()

# farfield_install_game(NAME TITLE text SUMMARY text ICON file.svg LICENCE file... [COMPONENT name] [WORLD pack]
#                       [COMPILED_IN package...])
# The program, its world, an entry of the desktop's menu with an icon, and the licences of everything that is in it.
#   LICENCE      the game's own; they head the file
#   WORLD        instead of that which farfield_add_game cooks
#   COMPILED_IN  further Debian packages whose headers or static libraries are compiled in
function(farfield_install_game name)
  cmake_parse_arguments(ARG "" "TITLE;SUMMARY;ICON;COMPONENT;WORLD" "LICENCE;COMPILED_IN" ${ARGN})
  if(NOT ARG_COMPONENT)
    set(ARG_COMPONENT Unspecified)
  endif()
  if(NOT ARG_WORLD)
    get_target_property(ARG_WORLD ${name} FARFIELD_WORLD)
  endif()
  cmake_path(GET ARG_ICON EXTENSION icon_extension)
  if(NOT icon_extension STREQUAL ".svg")
    message(FATAL_ERROR "farfield_install_game(${name}): the icon is '${ARG_ICON}'; expected an .svg file")
  endif()
  set(NAME ${name})
  set(TITLE ${ARG_TITLE})
  set(SUMMARY ${ARG_SUMMARY})
  set(entry ${CMAKE_CURRENT_BINARY_DIR}/${name}.desktop)
  configure_file(${FARFIELD_GAME_MODULE_DIR}/game.desktop.in ${entry} @ONLY)

  install(TARGETS ${name} RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT ${ARG_COMPONENT})
  install(FILES ${ARG_WORLD} DESTINATION ${CMAKE_INSTALL_DATADIR}/${name} RENAME world.ffpack COMPONENT ${ARG_COMPONENT})
  install(FILES ${entry} DESTINATION ${CMAKE_INSTALL_DATADIR}/applications COMPONENT ${ARG_COMPONENT})
  install(FILES ${ARG_ICON} DESTINATION ${CMAKE_INSTALL_DATADIR}/icons/hicolor/scalable/apps RENAME ${name}.svg
          COMPONENT ${ARG_COMPONENT})
  farfield_install_licences(${name} PROGRAMS $<TARGET_FILE:${name}> OWN ${ARG_LICENCE}
                            COMPILED_IN ${FARFIELD_COMPILED_IN} ${ARG_COMPILED_IN} COMPONENT ${ARG_COMPONENT})
endfunction()

# farfield_install_licences(PACKAGE PROGRAMS file... OWN file... COMPILED_IN package... COMPONENT name)
# PREFIX/share/doc/PACKAGE/copyright: our own licences, and those of all that the programs link, collected when they are installed.
function(farfield_install_licences package)
  cmake_parse_arguments(ARG "" "COMPONENT" "PROGRAMS;OWN;COMPILED_IN" ${ARGN})
  list(TRANSFORM ARG_OWN PREPEND "${CMAKE_CURRENT_SOURCE_DIR}/" REGEX "^[^/]")
  install(CODE "
    set(FF_PACKAGE \"${package}\")
    set(FF_PROGRAMS \"${ARG_PROGRAMS}\")
    set(FF_OWN \"${ARG_OWN}\")
    set(FF_COMPILED_IN \"${ARG_COMPILED_IN}\")
    set(FF_OUTPUT \"\$ENV{DESTDIR}\${CMAKE_INSTALL_PREFIX}/${CMAKE_INSTALL_DATADIR}/doc/${package}/copyright\")
    include(\"${FARFIELD_GAME_MODULE_DIR}/FarfieldLicences.cmake\")"
    COMPONENT ${ARG_COMPONENT})
endfunction()

# farfield_package_game(NAME CONTACT "Somebody <mail>" [SUMMARY text])
# Makes `cpack`, the target `package` and `ff package` write a .deb and a .tar.gz. Call it last.
macro(farfield_package_game name)
  cmake_parse_arguments(FF_PACKAGE "" "CONTACT;SUMMARY" "" ${ARGN})
  set(CPACK_PACKAGE_NAME ${name})
  set(CPACK_PACKAGE_CONTACT "${FF_PACKAGE_CONTACT}")
  set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "${FF_PACKAGE_SUMMARY}")
  set(CPACK_DEBIAN_PACKAGE_SECTION games)
  include(${FARFIELD_GAME_MODULE_DIR}/FarfieldPackages.cmake)
  set(CPACK_DEBIAN_PACKAGE_DEPENDS "${FARFIELD_LOADED_AT_RUN_TIME}")
  include(CPack)
endmacro()
