# ff_flatbuffers(TARGET file.fbs): compiles a schema into <build>/generated/<folder of the schema>/<name>_generated.h,
# seen by TARGET's own sources alone: what is in a file is no part of a module's interface.
function(ff_flatbuffers target schema)
  cmake_path(GET schema STEM name)
  file(RELATIVE_PATH folder ${PROJECT_SOURCE_DIR} ${CMAKE_CURRENT_SOURCE_DIR})
  set(out_dir ${PROJECT_BINARY_DIR}/generated/${folder})
  set(header ${out_dir}/${name}_generated.h)
  add_custom_command(
    OUTPUT ${header}
    COMMAND flatbuffers::flatc --cpp --scoped-enums --warnings-as-errors -o ${out_dir}
            ${CMAKE_CURRENT_SOURCE_DIR}/${schema}
    DEPENDS ${schema} VERBATIM)
  target_sources(${target} PRIVATE ${header})
  target_include_directories(${target} SYSTEM PRIVATE ${PROJECT_BINARY_DIR}/generated)
  target_link_libraries(${target} PRIVATE $<BUILD_INTERFACE:flatbuffers::flatbuffers>)
endfunction()
