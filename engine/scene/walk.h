#pragma once
// Walkthroughs: recorded camera paths, as files and in packs.

#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "engine/core/result.h"
#include "engine/math/camera.h"

namespace ff::scene {

/// Where the viewer is in one frame. Degrees, as in the file, so that reading and writing lose no bit; see Camera for
/// the meaning of the angles.
struct WalkFrame {
    WorldPos position{0.0};  ///< metres
    double yaw_deg = 0.0;
    double pitch_deg = 0.0;  ///< [-90, 90]
    double roll_deg = 0.0;

    friend bool operator==(const WalkFrame&, const WalkFrame&) = default;
};

struct Walk {
    std::string name;
    double fov_deg = 60.0;  ///< vertical, [1, 170]
    double rate_hz = 30.0;  ///< frames per second, (0, 10000]
    std::vector<WalkFrame> frames;

    /// @param frame  < frames.size()
    [[nodiscard]] Camera camera(std::size_t frame) const;

    friend bool operator==(const Walk&, const Walk&) = default;
};

inline constexpr std::size_t kMaxWalkFrames = 1'000'000;
/// Nothing in a world is farther from its origin, metres: a light year is a mistake, and floats stay finite.
inline constexpr double kMaxWorldCoordinate = 1e9;

/// What is wrong with a walk's numbers, as `PLACE: found; expected ...`; empty where nothing is. Walks from files and
/// packs have passed it.
[[nodiscard]] std::string find_walk_problem(const Walk& walk);

/// Reads the text of a `*.walk.json` (formats.md).
/// @param file  names the text in messages
/// @param name  becomes the walk's name: a walk file has none of its own
/// Errors: bad_input `FILE:LINE: PLACE: found; expected ...`; an unknown key names the nearest known one.
Result<Walk> parse_walk(std::string_view text, const std::string& file, std::string name);

/// The same from a file; its name is the file's, without `.walk.json`.
Result<Walk> load_walk(const std::filesystem::path& path);

/// The text that parse_walk reads back to an equal walk.
[[nodiscard]] std::string walk_to_json(const Walk& walk);

}  // namespace ff::scene
