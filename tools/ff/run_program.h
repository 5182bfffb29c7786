#pragma once

#include <string>
#include <vector>

#include "engine/core/result.h"

namespace ff::tool {

/// Runs a program that is looked for in PATH and waits for it; its output goes where ours goes, on stderr, for stdout
/// belongs to results. Errors: it cannot be started, or did not end with 0.
/// @param command  the program, then its arguments; no shell reads them
Status run_program(const std::vector<std::string>& command);

}  // namespace ff::tool
