# What every target of Farfield shares: language level, warnings, floating-point rules, ccache and mold where present.

set(CMAKE_CXX_STANDARD 20)
set(CMAKE_CXX_STANDARD_REQUIRED ON)
set(CMAKE_CXX_EXTENSIONS OFF)
set(CMAKE_POSITION_INDEPENDENT_CODE ON)
set(CMAKE_EXPORT_COMPILE_COMMANDS ON)
set(CMAKE_RUNTIME_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}/bin)

find_program(FF_CCACHE ccache)
if(FF_CCACHE)
  # Without this ccache stores nothing that was compiled with a precompiled header.
  set(CMAKE_CXX_COMPILER_LAUNCHER ${CMAKE_COMMAND} -E env CCACHE_SLOPPINESS=pch_defines,time_macros ${FF_CCACHE})
endif()
find_program(FF_MOLD mold)
if(FF_MOLD)
  add_link_options(-fuse-ld=mold)
endif()

# Baseline of the binaries. Hot kernels choose AVX2 or AVX-512 at run time through Highway. That would take a baseline
# without AES for one of SSSE3 alone, and compile every kernel for that as well.
set(FF_MARCH x86-64-v2)
add_compile_definitions(HWY_DISABLE_PCLMUL_AES)
# What runs only where it was built, as tests under sanitizers do, compiles its kernels once, for that machine.
option(FF_OWN_MACHINE "Compile for this machine alone" OFF)
if(FF_OWN_MACHINE AND EXISTS /proc/cpuinfo)
  file(READ /proc/cpuinfo cpuinfo)
  add_compile_definitions(HWY_COMPILE_ONLY_STATIC)
  if(cpuinfo MATCHES " avx512vl" AND cpuinfo MATCHES " avx512bw" AND cpuinfo MATCHES " avx512dq" AND cpuinfo MATCHES " avx512cd")
    set(FF_MARCH x86-64-v4)
  elseif(cpuinfo MATCHES " avx2" AND cpuinfo MATCHES " fma" AND cpuinfo MATCHES " bmi2")
    set(FF_MARCH x86-64-v3)
  endif()
endif()
add_compile_options(-march=${FF_MARCH} -ffp-contract=off)
# Messages name files as they lie in the sources; where those lay when this was built is nobody's business.
add_compile_options(-fmacro-prefix-map=${PROJECT_SOURCE_DIR}/=)

set(FF_WARNINGS -Wall -Wextra -Wpedantic -Wshadow -Wconversion -Wno-sign-conversion -Wnon-virtual-dtor
                -Woverloaded-virtual -Wno-missing-field-initializers -Werror)

# Half of what the compiler does for a file is to read headers of the standard library and of others': those that are
# used everywhere are read once. What a file needs it includes nevertheless; preset dev, which builds without, sees to that.
set(FF_COMMON_HEADERS <algorithm> <array> <cmath> <cstdint> <filesystem> <functional> <limits> <memory> <optional>
                      <random> <span> <string> <string_view> <vector> <fmt/format.h> <glm/glm.hpp>)

# ff_share_precompiled(TARGET FROM): those of FROM, which is compiled with the same options.
function(ff_share_precompiled target from)
  if(FF_PCH)
    target_precompile_headers(${target} REUSE_FROM ${from})
  endif()
endfunction()

# ff_module(NAME DEPS target... [PRIVATE_DEPS target...])
# The library of engine/NAME: every .cpp of the folder, alias Farfield::NAME.
function(ff_module name)
  cmake_parse_arguments(ARG "" "" "DEPS;PRIVATE_DEPS" ${ARGN})
  file(GLOB sources CONFIGURE_DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/*.cpp)
  set(target ff_${name})
  if(sources)
    add_library(${target} STATIC ${sources})
    target_include_directories(${target} PUBLIC $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}>
                                                $<INSTALL_INTERFACE:include/farfield>)
    target_link_libraries(${target} PUBLIC ${ARG_DEPS} PRIVATE ${ARG_PRIVATE_DEPS})
    target_compile_options(${target} PRIVATE ${FF_WARNINGS})
    ff_share_precompiled(${target} ff_engine_headers)
  else()
    add_library(${target} INTERFACE)
    target_include_directories(${target} INTERFACE $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}>
                                                   $<INSTALL_INTERFACE:include/farfield>)
    target_link_libraries(${target} INTERFACE ${ARG_DEPS})
  endif()
  set_target_properties(${target} PROPERTIES EXPORT_NAME ${name})
  add_library(Farfield::${name} ALIAS ${target})
  set_property(GLOBAL APPEND PROPERTY FF_INSTALLED_MODULES ${target})
endfunction()

# For what is not hot: it compiles in three quarters of the time, under the sanitizers in two thirds.
set(FF_COLD_OPTIONS $<$<CONFIG:Release>:-O1> $<$<CONFIG:Debug>:-O0>)
# What tests test is optimised, tests need not be.
set(FF_TEST_OPTIONS -O0)

# ff_test(NAME SOURCES file... DEPS target... [TIMEOUT seconds] [LABELS label...] [HOT])
# A GoogleTest executable; every TEST in it becomes one CTest test. HOT: its oracle searches, and is optimised, too.
function(ff_test name)
  cmake_parse_arguments(ARG "HOT" "TIMEOUT" "SOURCES;DEPS;LABELS" ${ARGN})
  if(NOT ARG_TIMEOUT)
    set(ARG_TIMEOUT 120)
  endif()
  add_executable(${name} ${ARG_SOURCES})
  target_link_libraries(${name} PRIVATE ${ARG_DEPS} GTest::gtest_main)
  if(ARG_HOT)
    target_compile_options(${name} PRIVATE ${FF_WARNINGS} -O1)
  else()
    target_compile_options(${name} PRIVATE ${FF_WARNINGS} ${FF_TEST_OPTIONS})
    ff_share_precompiled(${name} ff_test_headers)
  endif()
  gtest_discover_tests(${name} DISCOVERY_MODE PRE_TEST PROPERTIES TIMEOUT ${ARG_TIMEOUT} LABELS "${ARG_LABELS}")
endfunction()

# ff_bench(NAME SOURCES file... DEPS target...): a Google Benchmark program; CTest never times it.
function(ff_bench name)
  cmake_parse_arguments(ARG "" "" "SOURCES;DEPS" ${ARGN})
  add_executable(${name} ${ARG_SOURCES})
  target_link_libraries(${name} PRIVATE ${ARG_DEPS} benchmark::benchmark_main)
  target_compile_options(${name} PRIVATE ${FF_WARNINGS})
endfunction()
