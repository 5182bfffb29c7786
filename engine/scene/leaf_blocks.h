#pragma once
// Leaves of the meshes' hierarchies are not stored in packs: they hold a mesh's triangles in its own order, so their
// triangle counts say everything. Making them costs less than reading them (tests/bench/bench_pack).

#include <cstdint>
#include <optional>
#include <span>

#include "engine/scene/check_world.h"
#include "engine/scene/static_scene.h"

namespace ff::scene {

/// Fills `leaves` from the other arrays, the same bytes that prepare_mesh gave them.
/// @param scene        passed find_world_problem; its mesh_leaves are not read
/// @param leaf_sizes   triangles of each leaf
/// @param leaves       same length
/// @return what is wrong with the sizes: not 1..16, not the mesh's triangles in all, or more than 32 vertices.
[[nodiscard]] std::optional<WorldProblem> make_leaf_blocks(const StaticScene& scene,
                                                           std::span<const std::uint8_t> leaf_sizes,
                                                           std::span<BvhLeaf> leaves);

/// Whether scene.mesh_leaves are what make_leaf_blocks makes; names the first that is not.
[[nodiscard]] std::optional<WorldProblem> compare_leaf_blocks(const StaticScene& scene,
                                                              std::span<const std::uint8_t> leaf_sizes);

}  // namespace ff::scene
