#pragma once
// What ff bench measures of each mode, and how it is summed up.

#include <cstdint>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "engine/farfield/visibility_difference.h"
#include "engine/frame/renderer.h"
#include "engine/shading/image_difference.h"
#include "tools/report/frame_work.h"

namespace ff::tool {

/// Differences of a walk's frames from a reference.
struct ErrorSum {
    double psnr_sum = 0, psnr_min = 99.0, wrong_color_sum = 0;
    std::uint64_t wrong_primitives = 0, pixels = 0;
    int worst_frame = 0;

    void add(int frame, const shading::Image& image, const shading::Image& reference) {
        constexpr int kWrongLevels = 16;  // of 255
        const auto [psnr, wrong] = shading::compare_images(image, reference, kWrongLevels);
        psnr_sum += psnr;
        if (psnr < psnr_min) worst_frame = frame;
        psnr_min = std::min(psnr_min, psnr);
        wrong_color_sum += 100.0 * wrong;
    }
    /// For modes that know every pixel's primitive.
    void add_primitives(const farfield::VisibilityBuffer& answers, const farfield::VisibilityBuffer& truth) {
        wrong_primitives += farfield::count_wrong_pixels(answers, truth);
        pixels += std::uint64_t(truth.width) * std::uint64_t(truth.height);
    }
    [[nodiscard]] nlohmann::json report(double frames) const;
};

/// Times of a walk's frames, [frame][lap]. A frame's time is the median over the laps, so that another process's burst
/// in one lap is not ours.
struct Times {
    std::vector<std::vector<double>> laps;

    void resize(std::size_t frames, int lap_count) {
        laps.resize(frames);
        for (auto& frame : laps) frame.reserve(std::size_t(lap_count));
    }
    [[nodiscard]] std::vector<double> medians() const;
    [[nodiscard]] double median() const;
    /// {"median", "mean", "p99", "max"} over the frames
    [[nodiscard]] nlohmann::json report() const;
};

/// Everything measured of one mode.
struct ModeRun {
    std::string name;
    frame::FrameSettings settings;
    std::unique_ptr<frame::Renderer> renderer;
    Times frame_ms, visibility_ms, shading_ms;
    std::vector<frame::FrameStats> stats;  ///< [frame], of the first lap: work is the same in all
    std::vector<report::FrameWork> work;   ///< likewise
    std::vector<double> pass_ms = std::vector<double>(frame::kPassCount, 0.0);
    std::uint64_t steady_allocations = 0, steady_frames = 0;
    ErrorSum error;       ///< against mode raycast with the same shading
    ErrorSum full_error;  ///< against mode raycast with full shading: what a prelit far field costs as well
};

/// One mode's part of the report.
/// @param frames  of the walk
[[nodiscard]] nlohmann::json report_of(const ModeRun& run, std::size_t frames, int laps);

/// Times of modes over others' that the issues ask for, where both were run: frames, and "visibility A/B".
[[nodiscard]] nlohmann::json ratios_of(const std::vector<ModeRun>& runs);

}  // namespace ff::tool
