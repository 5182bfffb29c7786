#pragma once
// A budget: limits that a walkthrough must keep, as a TOML file that people write and `ff budget --write` makes.
//
//   format = 1
//   calibration_ms = 0.91      # optional: budget::Calibration where the limits were measured
//   [time]                     # of frames, ms
//   median_ms = 9.8
//   p99_ms = 13.0
//   worst_ms = 15.0
//   [passes.cast]              # mean of a frame
//   ms = 4.1
//   [effects.sun_shadows]
//   ms = 1.2
//   [work]                     # no frame may take more; not scaled
//   rays = 290000

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "engine/core/result.h"

namespace ff::budget {

enum class LimitKind : std::uint8_t { time, pass, effect, work };

inline constexpr std::array<std::string_view, 3> kTimeKeys{"median_ms", "p99_ms", "worst_ms"};
inline constexpr std::array<std::string_view, 8> kWorkKeys{
    "rays",          ///< cast for pixels and panorama texels, towards the sun, and by effects
    "triangles",     ///< sent to OpenGL
    "points",        ///< of the last frame, reprojected
    "texels",        ///< of the panorama, shown
    "pixels",        ///< and texels, shaded
    "layers",        ///< transparent, blended
    "allocations",   ///< on the heap, the fewest of all laps
    "upload_bytes",  ///< to OpenGL
};

struct Limit {
    LimitKind kind = LimitKind::time;
    std::string key;     ///< of kTimeKeys or kWorkKeys, or a pass's or an effect's name
    double value = 0.0;  ///< milliseconds; of work: a count or bytes
    int line = 0;        ///< of the file; 0: not from one

    /// As the file has it: "time.median_ms", "passes.cast.ms", "work.rays".
    [[nodiscard]] std::string name() const;
};

struct Budget {
    /// What the calibration took where the times were measured; nothing: they are limits on every machine as they
    /// stand.
    std::optional<double> calibration_ms;
    std::vector<Limit> limits;  ///< as the file orders them
};

/// The names that a budget may limit.
struct Names {
    std::span<const std::string_view> passes, effects;
};

/// @param file  names the text in messages
/// Errors: bad_input `FILE:LINE: found; expected ...`; an unknown key is answered with the known ones.
Result<Budget> parse_budget(std::string_view text, const std::string& file, const Names& names);

/// Text that parse_budget reads back to an equal budget, limits by kind. @param comment  a line for people, or empty
[[nodiscard]] std::string to_text(const Budget& budget, std::string_view comment);

}  // namespace ff::budget
