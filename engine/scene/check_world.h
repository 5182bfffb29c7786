#pragma once
// What must hold of a world's arrays so that nothing that reads them can step outside: every id in range, every
// hierarchy a tree, every number finite. load_world refuses packs by it, write_world refuses to write them.

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "engine/scene/static_scene.h"
#include "engine/scene/world.h"

namespace ff::scene {

/// Casters may keep a stack of 16 entries per level of a hierarchy.
inline constexpr int kMaxBvhDepth = 64;
/// Metres from a mesh's origin.
inline constexpr float kMaxMeshCoordinate = 1e8f;
inline constexpr std::uint32_t kMaxInstances = 1u << 30;

/// The first broken promise: which array, which element of it, what was found and what was expected.
struct WorldProblem {
    std::string_view array;  ///< a field of StaticScene or WorldInfo
    std::uint64_t element = 0;
    std::string what;
};

/// Looks at everything but mesh_leaves. Parallel; of several problems it always names the same one.
///
/// Beside ranges and finiteness: meshes follow each other in vertices, triangles, nodes and leaves without gap or
/// overlap; textures likewise in texels; instances are sorted by cell, and cells follow each other. In a hierarchy a
/// child's id is greater than its parent's, each node and leaf but the root hangs in exactly one place, and no path is
/// longer than kMaxBvhDepth.
[[nodiscard]] std::optional<WorldProblem> find_world_problem(const StaticScene& scene, const WorldInfo& info,
                                                             std::uint64_t leaf_count);

}  // namespace ff::scene
