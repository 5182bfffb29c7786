#pragma once
// One page that shows every effect: its picture with and without it, and what it costs where it is called for and where
// it is not.

#include <filesystem>
#include <span>
#include <string>

#include "engine/core/result.h"
#include "tools/ff/effect_walk.h"

namespace ff::tool {

struct TablePlace {
    std::string scene, walk;
};

/// Writes the page as Markdown. Pictures are named as `ff stats --pictures` names them, in the page's folder.
/// @param laps  of the comparison
Status write_effect_table(const std::filesystem::path& page, const TablePlace& place, int laps, const EffectWalk& walk,
                          std::span<const EffectDifference> differences);

}  // namespace ff::tool
