# What the engine itself links; the installed package finds the same for its users.

find_package(PkgConfig REQUIRED)
find_package(Threads REQUIRED)
find_package(TBB CONFIG REQUIRED)
find_package(fmt CONFIG REQUIRED)
find_package(glm CONFIG REQUIRED)
find_package(embree 3 CONFIG REQUIRED)
find_package(glfw3 3.3 CONFIG REQUIRED)
find_package(zstd CONFIG REQUIRED)
find_package(Bullet MODULE REQUIRED) # its own config names a library that Debian does not ship
find_package(nlohmann_json CONFIG REQUIRED)
find_package(tomlplusplus CONFIG REQUIRED)
pkg_check_modules(xxhash REQUIRED IMPORTED_TARGET GLOBAL libxxhash)
pkg_check_modules(hwy REQUIRED IMPORTED_TARGET GLOBAL libhwy)
pkg_check_modules(epoxy REQUIRED IMPORTED_TARGET GLOBAL epoxy)
pkg_check_modules(egl REQUIRED IMPORTED_TARGET GLOBAL egl)
pkg_check_modules(openal REQUIRED IMPORTED_TARGET GLOBAL openal)
pkg_check_modules(imgui REQUIRED IMPORTED_TARGET GLOBAL imgui)
