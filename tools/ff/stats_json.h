#pragma once

#include <nlohmann/json_fwd.hpp>

#include "engine/frame/stats.h"

namespace ff::tool {

/// One frame's statistics as they stand in stats.json.
[[nodiscard]] nlohmann::json to_json(const frame::FrameStats& stats);

}  // namespace ff::tool
