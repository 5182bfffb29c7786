#pragma once
// What the effects of a scene do along a walk, and what each adds to its frames.

#include <array>
#include <cstdint>
#include <vector>

#include "engine/effects/registry.h"
#include "engine/shading/shading_pass.h"
#include "tools/ff/session.h"

namespace ff::tool {

/// One effect over the frames of a walk.
struct EffectSum {
    effects::Decision decision;                ///< the most active one, the first of its kind
    std::array<std::uint64_t, 3> frames_in{};  ///< by effects::State
    effects::Work work;                        ///< of all frames
    std::uint64_t steady_allocations = 0;      ///< of frames after the first few in which it was active
};
struct EffectWalk {
    std::uint64_t frames = 0;
    double median_ms = 0.0, p99_ms = 0.0, max_ms = 0.0;  ///< of all frames but the first
    std::uint64_t changes = 0;           ///< frames, not the first, in which an effect came, went or fell idle
    double change_p99_ms = 0.0;          ///< of these and the two after each
    std::uint64_t most_allocations = 0;  ///< in one frame, after the first few, that no effect came in
    std::array<EffectSum, effects::kEffectCount> of;
};

/// Draws the first frames of the session's walk, each once. Errors: what the renderer refuses.
Result<EffectWalk> walk_effects(Session& session, const ImageSize& size, std::size_t frames);

/// What an effect changes.
struct EffectDifference {
    effects::EffectId id;
    bool is_called = true;      ///< by the scene; else it was made to rain or to snow
    effects::Work own_with;     ///< what frames spent on it that had it
    effects::Work own_without;  ///< and those without: nothing
    double rays_per_frame = 0.0;
    double ms_with = 0.0, ms_without = 0.0;  ///< medians over the frames of their minima over the laps
    double ms_added = 0.0;                   ///< the median frame's difference
    double psnr_db = 99.0;                   ///< of the frame that it changes most; 99: none changes
    std::size_t frame = 0;                   ///< that frame
    shading::Image with, without;            ///< its pictures
};

/// Draws the same frames with everything and without each effect that is not off, one after the other, `laps` times.
/// @param any_weather  where none falls, rain and snow are compared, too, by frames that they are put into
[[nodiscard]] std::vector<EffectDifference> compare_effects(Session& session, const ImageSize& size, std::size_t frames,
                                                            int laps, const EffectWalk& walk, bool any_weather = false);

}  // namespace ff::tool
