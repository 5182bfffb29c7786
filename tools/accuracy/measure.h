#pragma once
// Draws the scheduled frames with given settings: how long they take and how wrong they are.

#include <string>
#include <utility>
#include <vector>

#include "tools/accuracy/planes.h"
#include "tools/accuracy/reference.h"

namespace ff::accuracy {

/// Knobs that were turned, by name; the others stand at their defaults.
using KnobSettings = std::vector<std::pair<std::string, double>>;

struct Errors {
    double psnr_db = 0.0;            ///< mean of the frames', against 16 samples a pixel; 99 where equal
    double psnr_exact_db_min = 0.0;  ///< worst frame's, against every pixel cast once; 99 where equal
    double ssim = 0.0;               ///< mean
    double flip_mean = 0.0;          ///< mean, [0, 1]
    double wrong_pixels_pct = 0.0;   ///< pixels that show another primitive than the exact frame, mean
    double displacement_px = 0.0;    ///< see VisibilityError; the worst frame's
    double flicker = 0.0;            ///< see flicker(); mean
};

struct Times {
    double median_ms = 0.0, p99_ms = 0.0;
    double exact_median_ms = 0.0;  ///< of exact frames, drawn in turn with these
};

/// The frame where a setting looks worst, by FLIP.
struct WorstFrame {
    std::size_t index = 0;  ///< in the schedule
    double flip = -1.0;
    shading::Image image;
    Plane flip_map;
};

/// One point: settings, what they cost and what they give.
struct Point {
    KnobSettings settings;
    bool is_exact = false;  ///< the knobs stand where exact frames have them
    Times times;
    Errors errors;
    WorstFrame worst;
    [[nodiscard]] double time_ratio() const { return times.median_ms / times.exact_median_ms; }
};

/// What is measured, on what, against what; borrowed.
struct Bench {
    const LabScene& scene;
    std::span<const ScheduledFrame> frames;
    std::span<const ReferenceFrame> reference;
    frame::FrameSettings exact;  ///< what knobs are turned from
    int laps = 3;
};

/// Measures each of the settings, all in turn with exact frames, segment by segment of the schedule.
/// @param title  of the progress bar
/// Errors: no such knob, or a value that it does not have.
Result<std::vector<Point>> measure(const Bench& bench, std::span<const KnobSettings> settings,
                                   const std::string& title);

}  // namespace ff::accuracy
