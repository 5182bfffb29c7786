#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <vector>

#include "engine/core/jobs.h"
#include "engine/core/log.h"
#include "engine/core/program_files.h"
#include "tools/ff/commands.h"
#include "tools/ff/run_program.h"

namespace ff::tool {
namespace {

namespace fs = std::filesystem;

bool is_package(const fs::path& path) {
    const std::string name = path.filename().string();
    return name.ends_with(".deb") || name.ends_with(".tar.gz");
}

/// The engine that was installed with this ff, so that it is found wherever that was.
Result<std::string> engine_hint() {
    FF_ASSIGN(const fs::path program, program_path());
    return "-DCMAKE_PREFIX_PATH=" + program.parent_path().parent_path().string();
}

/// Into the output folder, each whole or not at all.
Status hand_over(const fs::path& made, const fs::path& output) {
    std::vector<fs::path> packages;
    for (const fs::directory_entry& entry : fs::directory_iterator(made))
        if (entry.is_regular_file() && is_package(entry.path())) packages.push_back(entry.path());
    if (packages.empty())
        return bad_input("the game's CMakeLists.txt makes no packages; expected farfield_package_game() at its end");
    std::sort(packages.begin(), packages.end());
    fs::create_directories(output);
    for (const fs::path& package : packages) {
        const fs::path target = output / package.filename();
        const fs::path part = target.string() + ".part";
        fs::copy_file(package, part, fs::copy_options::overwrite_existing);
        fs::rename(part, target);
        log_info("{}: {:.1f} MB", target.string(), double(fs::file_size(target)) * 1e-6);
    }
    return {};
}

Status build_and_pack(const PackageOptions& options) {
    const fs::path build = options.game / "build" / "package";
    const fs::path made = build / "packages";
    FF_ASSIGN(const std::string hint, engine_hint());
    std::vector<std::string> configure = {
        "cmake", "-S", options.game.string(), "-B", build.string(), "-DCMAKE_BUILD_TYPE=Release", hint};
    // A build folder keeps the generator that it began with.
    if (!fs::exists(build / "CMakeCache.txt") && std::system("command -v ninja >/dev/null 2>&1") == 0)
        configure.insert(configure.end(), {"-G", "Ninja"});
    FF_TRY(run_program(configure));
    const int jobs = options.jobs > 0 ? options.jobs : worker_count();
    FF_TRY(run_program({"cmake", "--build", build.string(), "--parallel", std::to_string(jobs)}));
    fs::remove_all(made);
    FF_TRY(run_program({"cpack", "--config", (build / "CPackConfig.cmake").string(), "-B", made.string()}));
    return hand_over(made, options.output);
}

}  // namespace

Status run_package(const PackageOptions& options) {
    if (!fs::exists(options.game / "CMakeLists.txt"))
        return bad_input(fmt::format("{}: has no CMakeLists.txt; expected the folder of a game, as `ff new` makes it",
                                     options.game.string()));
    try {
        return build_and_pack(options);
    } catch (const fs::filesystem_error& error) {
        return failure(error.what());
    }
}

}  // namespace ff::tool
