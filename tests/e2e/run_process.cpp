#include "tests/e2e/run_process.h"

#include <OpenImageIO/imagebuf.h>
#include <OpenImageIO/imagebufalgo.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cmath>
#include <cstdlib>
#include <fstream>
#include <iterator>

namespace ff::test {

ProcessResult run(const std::string& command) {
    const auto out = scratch() / "stdout.txt";
    const auto err = scratch() / "stderr.txt";
    const int status =
        std::system(("( " + command + " ) >" + out.string() + " 2>" + err.string() + " </dev/null").c_str());
    ProcessResult result;
    result.exit_code = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
    result.out = read_file(out);
    result.err = read_file(err);
    return result;
}

ProcessResult run_ff(const std::string& arguments) {
    return run("env -u DISPLAY -u WAYLAND_DISPLAY XDG_CACHE_HOME=" + (scratch() / "cache").string() +
               " " FF_BINARY " " + arguments);
}

const std::filesystem::path& scratch() {
    struct Folder {
        std::filesystem::path path =
            std::filesystem::temp_directory_path() / ("farfield-e2e-" + std::to_string(::getpid()));
        Folder() { std::filesystem::create_directories(path); }
        ~Folder() {
            std::error_code ignored;
            std::filesystem::remove_all(path, ignored);
        }
    };
    static const Folder folder;
    return folder.path;
}

std::string read_file(const std::filesystem::path& path) {
    std::ifstream in(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
}

void write_file(const std::filesystem::path& path, const std::string& bytes) {
    std::ofstream(path, std::ios::binary) << bytes;
}

double psnr_db(const std::filesystem::path& a, const std::filesystem::path& b) {
    const OIIO::ImageBuf image_a(a.string()), image_b(b.string());
    const auto result = OIIO::ImageBufAlgo::compare(image_a, image_b, 1.0f, 1.0f);
    return result.PSNR > 99.0 || std::isnan(result.PSNR) ? 99.0 : result.PSNR;
}

const std::filesystem::path& hamlet_pack() {
    static const std::filesystem::path pack = [] {
        const auto path = scratch() / "hamlet.ffpack";
        const ProcessResult cooked =
            run_ff("cook " FF_SOURCE_DIR "/tests/content/hamlet/hamlet.toml -o " + path.string());
        EXPECT_EQ(cooked.exit_code, 0) << cooked.err;
        return path;
    }();
    return pack;
}

}  // namespace ff::test
