#pragma once

#include "engine/host/game.h"

namespace ff::host {

/// Does anything: walks, turns, presses, now this, now that; the same for a seed. For finding what breaks.
[[nodiscard]] std::unique_ptr<AutoPlayer> make_random_player(const GameInfo& info, std::uint64_t seed);

}  // namespace ff::host
