#include "engine/core/program_files.h"

#include <system_error>

namespace ff {

Result<std::filesystem::path> program_path() {
    std::error_code error;
    std::filesystem::path path = std::filesystem::read_symlink("/proc/self/exe", error);
    if (error) return failure("/proc/self/exe: cannot be read: " + error.message() + "; is /proc mounted?");
    return path;
}

Result<std::filesystem::path> shared_files() {
    FF_ASSIGN(const std::filesystem::path program, program_path());
    return program.parent_path().parent_path() / "share";
}

}  // namespace ff
