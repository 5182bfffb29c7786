#include "engine/farfield/reproject_cast.h"

#include "engine/farfield/tile_regroup.h"

namespace ff::farfield {
namespace {
// Where one walk for all of a tile's pixels and packets of them break even, between 24 and 64 on streets and in woods.
constexpr std::uint64_t kManyPixels = 40;
}  // namespace

CastCost cast_left_over(RayCaster& few, RayCaster& much, const PinholeView& view, std::span<const TileRequest> left,
                        std::vector<TileRequest>& scratch_few, std::vector<TileRequest>& scratch_much,
                        VisibilityBuffer& out) {
    if (&few == &much) return much.cast_tiles(view, left, out);
    scratch_few.clear();
    scratch_much.clear();
    for (const TileRequest& tile : left) {
        const bool is_much = count_pixels(std::span(&tile, 1), view.width, view.height) >= kManyPixels;
        (is_much ? scratch_much : scratch_few).push_back(tile);
    }
    const CastCost a = few.cast_tiles(view, scratch_few, out), b = much.cast_tiles(view, scratch_much, out);
    return {a.rays + b.rays, a.nodes + b.nodes, a.triangles + b.triangles};
}

}  // namespace ff::farfield
