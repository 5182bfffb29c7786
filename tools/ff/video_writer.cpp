#include "tools/ff/video_writer.h"

#include <fmt/format.h>

#include <csignal>
#include <cstdlib>
#include <utility>

namespace ff::tool {

Result<VideoWriter> VideoWriter::open(const std::filesystem::path& path, int width, int height, double rate_hz) {
    if (std::system("command -v ffmpeg >/dev/null 2>&1") != 0)
        return failure("--video needs ffmpeg, which is not installed (apt-get install ffmpeg)");
    std::signal(SIGPIPE, SIG_IGN);  // ffmpeg's failure is reported by add(), not by a signal
    std::string quoted = path.string();
    for (std::size_t i = 0; (i = quoted.find('\'', i)) != std::string::npos; i += 4) quoted.replace(i, 1, "'\\''");
    const std::string command = fmt::format(
        "ffmpeg -loglevel error -y -f rawvideo -pix_fmt rgba -s {}x{} -r {} -i - -c:v libx264 -pix_fmt yuv420p "
        "-crf 20 -preset veryfast -vf 'pad=ceil(iw/2)*2:ceil(ih/2)*2' '{}'",
        width, height, rate_hz, quoted);
    std::FILE* pipe = ::popen(command.c_str(), "w");
    if (pipe == nullptr) return failure("cannot start ffmpeg");
    return VideoWriter(pipe);
}

VideoWriter::VideoWriter(VideoWriter&& other) noexcept : pipe_(std::exchange(other.pipe_, nullptr)) {}

VideoWriter::~VideoWriter() {
    if (pipe_ != nullptr) ::pclose(pipe_);
}

Status VideoWriter::add(const shading::Image& image) {
    for (int y = 0; y < image.height; ++y) {
        const auto width = static_cast<std::size_t>(image.width);
        if (std::fwrite(image.pixels.data() + std::size_t(y) * std::size_t(image.stride), 4, width, pipe_) != width)
            return failure("ffmpeg takes no more frames; it says why above");
    }
    return {};
}

Status VideoWriter::close() {
    const int code = ::pclose(std::exchange(pipe_, nullptr));
    if (code != 0) return failure(fmt::format("ffmpeg ended with code {}", code));
    return {};
}

}  // namespace ff::tool
