#pragma once

#include <filesystem>
#include <string>

namespace ff::test {

struct ProcessResult {
    int exit_code = -1;  ///< 128 + signal where one ended it
    std::string out, err;
};

/// Runs a shell command and waits for it.
[[nodiscard]] ProcessResult run(const std::string& command);

/// Runs the tool with these arguments; no display, a cache of its own.
[[nodiscard]] ProcessResult run_ff(const std::string& arguments);

/// An empty folder of this test process, removed at its end.
[[nodiscard]] const std::filesystem::path& scratch();

[[nodiscard]] std::string read_file(const std::filesystem::path& path);
void write_file(const std::filesystem::path& path, const std::string& bytes);

/// PSNR of two image files of the same size, dB over 8-bit sRGB; 99 where equal.
[[nodiscard]] double psnr_db(const std::filesystem::path& a, const std::filesystem::path& b);

/// The hamlet, cooked once per test process.
[[nodiscard]] const std::filesystem::path& hamlet_pack();

}  // namespace ff::test
