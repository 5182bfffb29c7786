#pragma once
// From an error that is allowed to the fastest settings that keep it: the other direction of the lab's trade.

#include <filesystem>
#include <limits>
#include <string>

#include "engine/core/result.h"
#include "engine/frame/settings.h"

namespace ff::accuracy {

/// Errors that may be made, each against exact frames of one sample a pixel.
struct Limits {
    double max_displacement_px = std::numeric_limits<double>::infinity();
    double min_psnr_db = 0.0;  ///< in the worst frame
};

/// Where a pack's table is kept: beside it, its name ending in .accuracy.json.
[[nodiscard]] std::filesystem::path table_path(const std::filesystem::path& pack);

/// Turns the knobs of `settings` to the fastest ones of a pack's table that keep the limits, exact ones where none
/// does.
/// @param pack_hash  of the pack as it is now
/// @param walk       that will be walked
/// @return what was chosen, and why, for people
/// Errors: there is no table, it is damaged, or it is another pack's.
Result<std::string> choose_settings(const std::filesystem::path& pack, std::uint64_t pack_hash, const std::string& walk,
                                    const Limits& limits, frame::FrameSettings& settings);

}  // namespace ff::accuracy
