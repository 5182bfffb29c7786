#include "engine/farfield/reproject_cast.h"

#include <algorithm>
#include <array>

#include "engine/farfield/beam_caster.h"
#include "engine/farfield/tile_regroup.h"

namespace ff::farfield {
namespace {
// Of a beam's square: where one walk for all of its pixels and packets of them break even, flat between 24 and 64 on
// streets and in woods.
constexpr int kManyPixels = 40;
constexpr int kMostSquares = 65536 / beam::kBeamSize;  // in a row: a request names its pixel by 16 bits

int square_row(const TileRequest& tile) {
    return tile.y / beam::kBeamSize;
}
}  // namespace

CastCost cast_left_over(RayCaster& few, RayCaster& much, const PinholeView& view, std::span<const TileRequest> left,
                        std::vector<TileRequest>& scratch_few, std::vector<TileRequest>& scratch_much,
                        bool shift_origin, VisibilityBuffer& out) {
    const auto cast = [&](RayCaster& caster, std::span<const TileRequest> tiles) {
        return shift_origin ? caster.cast_tiles_beyond(view, tiles, out) : caster.cast_tiles(view, tiles, out);
    };
    if (&few == &much) return cast(much, left);
    scratch_few.clear();
    scratch_much.clear();
    std::array<int, kMostSquares> asked;
    for (std::size_t begin = 0, end = 0; begin < left.size(); begin = end) {
        // A row of squares: the tiles of an image come row by row.
        asked.fill(0);
        for (; end < left.size() && square_row(left[end]) == square_row(left[begin]); ++end)
            asked[left[end].x / beam::kBeamSize] += int(count_pixels(left.subspan(end, 1), view.width, view.height));
        for (const TileRequest& tile : left.subspan(begin, end - begin))
            (asked[tile.x / beam::kBeamSize] >= kManyPixels ? scratch_much : scratch_few).push_back(tile);
    }
    const CastCost a = cast(few, scratch_few), b = cast(much, scratch_much);
    return {a.rays + b.rays, a.nodes + b.nodes, a.triangles + b.triangles};
}

}  // namespace ff::farfield
