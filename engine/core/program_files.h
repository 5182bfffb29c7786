#pragma once
// What comes with a program lies beside it, wherever that was installed or unpacked:
//
//   PREFIX/bin/PROGRAM            PREFIX/share/...

#include <filesystem>

#include "engine/core/result.h"

namespace ff {

/// The running program's own file. Errors: the system does not say (no /proc).
Result<std::filesystem::path> program_path();

/// PREFIX/share of the running program. Errors: as program_path(); whether the folder is there is not looked at.
Result<std::filesystem::path> shared_files();

}  // namespace ff
