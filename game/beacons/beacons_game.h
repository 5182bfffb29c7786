#pragma once
// The sample game: find the beacons on the heights around the town through a spyglass, reach them, and light them
// before the day ends.

#include "engine/host/game.h"

namespace ff::beacons {

/// How the host starts it.
[[nodiscard]] const host::GameInfo& game_info();

}  // namespace ff::beacons
