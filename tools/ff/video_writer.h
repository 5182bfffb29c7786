#pragma once

#include <cstdio>
#include <filesystem>
#include <string>

#include "engine/core/result.h"
#include "engine/shading/shading_pass.h"

namespace ff::tool {

/// Writes an image as PNG, EXR, JPEG ..., by the name's ending; whole or not at all.
Status write_image(const std::filesystem::path& path, const shading::Image& image);

/// Frames into a video file through ffmpeg, at the walk's rate.
class VideoWriter {
  public:
    static Result<VideoWriter> open(const std::filesystem::path& path, int width, int height, double rate_hz);
    VideoWriter(VideoWriter&& other) noexcept;
    VideoWriter& operator=(VideoWriter&&) = delete;
    ~VideoWriter();
    Status add(const shading::Image& image);
    Status close();

  private:
    explicit VideoWriter(std::FILE* pipe) : pipe_(pipe) {}
    std::FILE* pipe_ = nullptr;
};

}  // namespace ff::tool
