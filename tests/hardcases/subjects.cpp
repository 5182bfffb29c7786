#include "tests/hardcases/subjects.h"

#include <algorithm>
#include <utility>

#include "engine/farfield/embree_caster.h"
#include "tests/support/worlds.h"

namespace ff::hardcases {

std::unique_ptr<farfield::RayCaster> make_caster(Subject subject, const scene::StaticScene& scene) {
    switch (subject) {
        case Subject::beam:
            return farfield::make_beam_caster(scene);
        case Subject::embree:
            return farfield::make_embree_caster(scene);
        case Subject::embree_fast:
            return farfield::make_embree_caster(scene, {.robust = false});
        case Subject::grid:
            break;
    }
    return farfield::make_grid_caster(scene);
}

std::vector<farfield::TileRequest> all_tiles(const PinholeView& view) {
    std::vector<farfield::TileRequest> tiles;
    for (int y = 0; y < view.height; y += farfield::kTileSize)
        for (int x = 0; x < view.width; x += farfield::kTileSize) {
            farfield::TileRequest tile{.x = std::uint16_t(x), .y = std::uint16_t(y)};
            std::fill(std::begin(tile.rows), std::end(tile.rows), std::uint16_t(0xFFFF));
            tiles.push_back(tile);
        }
    return tiles;
}

scene::SceneData scene_of(scene::MeshSource mesh, const WorldPos& position, const Mat3& world_from_mesh) {
    scene::SceneData data;
    data.materials.push_back(test::plain_material());
    const std::uint32_t id = data.add_mesh(scene::prepare_mesh(std::move(mesh), data.materials));
    data.add_instance(id, position, world_from_mesh, 0);
    data.finish(16);
    return data;
}

}  // namespace ff::hardcases
