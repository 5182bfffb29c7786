#pragma once

#include <cstdio>
#include <filesystem>
#include <string>

#include "engine/core/result.h"
#include "engine/shading/shading_pass.h"

namespace ff::tool {

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
