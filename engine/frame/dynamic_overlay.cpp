#include "engine/frame/dynamic_overlay.h"

namespace ff::frame {

DynamicOverlay::DynamicOverlay(const scene::StaticScene& scene)
    : scene_(scene),
      first_id_(std::uint32_t(scene.instances.size())),
      caster_(farfield::make_live_beam_caster(scene_)),
      behind_(scene_) {}

farfield::CastCost DynamicOverlay::draw(const PinholeView& view, std::span<const scene::Instance> dynamic,
                                        std::span<const farfield::TileRequest> all_tiles,
                                        farfield::VisibilityBuffer& visibility, farfield::PixelMask& covered,
                                        const farfield::DepthPlane* behind) {
    if (dynamic.empty()) return {};
    const std::span<const farfield::TileRequest> tiles = tiles_.find(view, dynamic, all_tiles);
    if (tiles.empty()) return {};
    if (visibility_.width != visibility.width || visibility_.height != visibility.height)
        visibility_.resize(visibility.width, visibility.height);
    scene_.instances = dynamic;
    scene_.instance_nodes = tree_.build(dynamic, scene_.origin);
    farfield::CastCost cost;
    if (behind != nullptr) {
        const farfield::MirrorRequest request{view, *behind, tiles};
        cost = behind_.cast({&request, 1}, visibility_);
    } else {
        cost = caster_->cast_tiles(view, tiles, visibility_);
    }

    for (const farfield::TileRequest& tile : tiles)
        for (int row = 0; row < farfield::kTileSize; ++row) {
            const std::size_t first = visibility.index(tile.x, tile.y + row);
            for (unsigned i = 0; i < unsigned(farfield::kTileSize); ++i) {
                if (((tile.rows[row] >> i) & 1u) == 0) continue;
                if (!(visibility_.depth[first + i] < visibility.depth[first + i])) continue;
                visibility.depth[first + i] = visibility_.depth[first + i];
                visibility.instance[first + i] = first_id_ + visibility_.instance[first + i];
                visibility.triangle[first + i] = visibility_.triangle[first + i];
                covered.set(tile.x + int(i), tile.y + row);
            }
        }
    return cost;
}

}  // namespace ff::frame
