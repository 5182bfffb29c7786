#pragma once

#include "engine/core/result.h"
#include "tools/ff/commands.h"

namespace ff::tool {

/// Opens a window and plays the walk; the player takes over with the first key or mouse press (WASD, mouse, gamepad),
/// R records a walk, P plays on, F1 shows the overlay, F2 cycles the debug views, Escape ends.
Status walk_in_window(const WalkOptions& options);

}  // namespace ff::tool
