#pragma once
// The command line as other programs want it: made from the very options that are read, so it cannot say anything else.

#include <string>

namespace CLI {
class App;
}

namespace ff::tool {

/// A manual page, section 1, as roff.
[[nodiscard]] std::string manual_page(const CLI::App& app);
/// Completion of commands, options, their values where there are few, and files.
[[nodiscard]] std::string bash_completion(const CLI::App& app);
[[nodiscard]] std::string zsh_completion(const CLI::App& app);

}  // namespace ff::tool
