#pragma once
// The casters that cases are run against, and whole images of them.

#include <memory>
#include <vector>

#include "engine/farfield/ray_caster.h"
#include "engine/farfield/visibility_buffer.h"
#include "engine/math/camera.h"
#include "engine/scene/scene_data.h"

namespace ff::hardcases {

enum class Subject { beam, embree, embree_fast, grid };

[[nodiscard]] std::unique_ptr<farfield::RayCaster> make_caster(Subject subject, const scene::StaticScene& scene);

/// Every pixel of a view, tile by tile.
[[nodiscard]] std::vector<farfield::TileRequest> all_tiles(const PinholeView& view);

/// A finished scene of one mesh, once, grey and opaque.
[[nodiscard]] scene::SceneData scene_of(scene::MeshSource mesh, const WorldPos& position,
                                        const Mat3& world_from_mesh = Mat3(1.0f));

}  // namespace ff::hardcases
