# Every library, found once. Runtime first; the cooker's and the tests' own only where those are built.
# tools/setup names the Debian packages.

include(FarfieldRuntimeDependencies)
find_package(FlatBuffers REQUIRED)

if(FF_TOOLS)
  find_package(CLI11 CONFIG REQUIRED)
endif()
if(FF_COOK OR FF_TOOLS)
  find_package(draco CONFIG REQUIRED)
  find_package(meshoptimizer CONFIG REQUIRED)
  find_package(GDAL CONFIG REQUIRED)
  pkg_check_modules(OpenImageIO REQUIRED IMPORTED_TARGET GLOBAL OpenImageIO)
  pkg_check_modules(sndfile REQUIRED IMPORTED_TARGET GLOBAL sndfile)
endif()
if(FF_TESTS)
  find_package(GTest CONFIG REQUIRED)
  find_package(benchmark CONFIG REQUIRED)
endif()
