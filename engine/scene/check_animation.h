#pragma once
// What must hold of a world's animated models so that what plays them can step nowhere outside: every joint, key and
// weight in range, every number finite, parents before children.

#include <optional>

#include "engine/scene/animation.h"
#include "engine/scene/check_world.h"

namespace ff::scene {

inline constexpr std::size_t kMostJoints = 1u << 16;

/// The first broken promise of `set`; element counts models, then instances behind them.
/// Beside ranges and finiteness: meshes of skins are of no other part, each has weights for all its vertices that sum
/// to 1 within 1e-3, and names of clips are unique within a model.
[[nodiscard]] std::optional<WorldProblem> find_animation_problem(const AnimationSet& set, std::span<const Mesh> meshes);

}  // namespace ff::scene
