#pragma once
// Every frame of a walk in figures, as columns of JSON: what ff report draws, and what bench, budget and replay write
// for it.
//
//   "frames": {"count", "ms": [..], "position_m": [[x, y, z], ..], "yaw_deg": [..],
//              "pass_ms": {"cast": [..], ..}, "effect_ms": {..}, "effect_state": {NAME: [0 off, 1 idle, 2 active]},
//              "pixels": {"near", "sky", "panorama", "verified", "cast_hit", "cast_miss": [..]},
//              "work": {"rays": [..], ..}, "plan": {"resolution", "near_m", "ray_budget": [..]}}
//
// Columns that are zero from end to end are left out; null stands for what has no bound.

#include <nlohmann/json_fwd.hpp>
#include <span>
#include <string>
#include <vector>

#include "engine/frame/stats.h"
#include "engine/math/camera.h"
#include "engine/shading/shading_pass.h"
#include "tools/report/frame_work.h"

namespace ff::report {

/// Slow frames that are shown are at least so far apart: neighbours look alike.
inline constexpr std::size_t kFramesApart = 10;

class FrameSeries {
  public:
    explicit FrameSeries(std::size_t frames) { rows_.reserve(frames); }

    /// @param ms  of the whole frame
    void add(const Camera& camera, double ms, const FrameWork& work, const frame::FrameStats& stats);
    [[nodiscard]] std::size_t size() const { return rows_.size(); }
    /// Times of frames, of passes and of effects instead of those that were added: what several laps gave.
    void set_ms(std::size_t frame, double ms) { rows_[frame].ms = ms; }
    void set_pass_ms(std::size_t frame, std::size_t pass, double ms) { rows_[frame].stats.pass_ms[pass] = ms; }
    void set_effect_ms(std::size_t frame, std::size_t effect, double ms) {
        rows_[frame].stats.effect_work[effect].ms = ms;
    }
    /// The slowest frames, slowest first, kFramesApart; warm-up frames are left out.
    [[nodiscard]] std::vector<std::size_t> worst_frames(std::size_t count, std::size_t warm_up) const;
    [[nodiscard]] double ms(std::size_t frame) const { return rows_[frame].ms; }
    [[nodiscard]] nlohmann::json to_json() const;

  private:
    struct Row {
        Camera camera;
        double ms;
        FrameWork work;
        frame::FrameStats stats;
    };
    std::vector<Row> rows_;
};

/// A frame as it was planned and drawn.
struct FramePicture {
    std::size_t frame = 0;
    double ms = 0.0;
    std::string plan;  ///< frame::to_text
    shading::Image image;
};

/// "pictures": [{"frame", "ms", "plan", "url"}]. Errors: page::picture_url's.
Result<nlohmann::json> to_json(std::span<const FramePicture> pictures);

}  // namespace ff::report
