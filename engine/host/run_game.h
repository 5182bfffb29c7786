#pragma once
// The main() of a game: command line, where its world lies, exit codes.

#include "engine/host/game.h"

namespace ff::host {

/// Runs a game as its command line says (--help lists it); without arguments, in a window. Its world is
/// PREFIX/share/PROGRAM/world.ffpack where the program is PREFIX/bin/PROGRAM, or what --pack names.
/// @return the process's exit code: 0; 1 failure, 2 usage, 3 bad input, 4 a replay that parts from what was recorded
int run_game(const GameInfo& info, int argc, const char* const* argv);

}  // namespace ff::host
