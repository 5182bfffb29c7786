#pragma once
// Options that several subcommands share.

#include <CLI/CLI.hpp>

#include "tools/ff/commands.h"

namespace ff::tool {

/// A number in [low, high]; not-a-number is none.
[[nodiscard]] CLI::Validator number_in(double low, double high);

/// --size, --threads
void add_size_and_threads(CLI::App& app, ImageSize& size, int& threads);

/// What is drawn, how large and by how many threads.
void add_scene_options(CLI::App& app, ViewOptions& view);

/// The same, and everything that a user may choose about frames.
/// @param with_mode  --mode, too: for subcommands that draw one
void add_view_options(CLI::App& app, ViewOptions& view, bool with_mode);

}  // namespace ff::tool
