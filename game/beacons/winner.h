#pragma once

#include "game/beacons/state.h"

namespace ff::beacons {

/// Runs to one beacon after the other, round what is in the way, and lights it; now and then looks through the
/// spyglass.
[[nodiscard]] std::unique_ptr<host::AutoPlayer> make_winner(State& state);

}  // namespace ff::beacons
