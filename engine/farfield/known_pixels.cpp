#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "engine/farfield/known_pixels.cpp"
#include <hwy/foreach_target.h>  // must come before highway.h
#include <hwy/highway.h>

#include <array>
#include <bit>

#include "engine/core/check.h"
#include "engine/core/jobs.h"
#include "engine/farfield/cast_cost_sum.h"
#include "engine/farfield/known_pixels.h"
#include "engine/farfield/lane_bits-inl.h"
#include "engine/farfield/tile_regroup.h"

HWY_BEFORE_NAMESPACE();
namespace ff::farfield::known {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

// The pixels of a tile that see something, and their primitives.
TileRequest Collect(const PinholeView& view, const TileRequest& tile, const VisibilityBuffer& visibility,
                    PrimitiveSet& primitives) {
    using U = hn::CappedTag<std::uint32_t, 16>;
    constexpr U ui;
    constexpr int kLanes = int(hn::MaxLanes(ui));
    const auto bits_of = [](hn::Mask<U> mask) { return farfield::HWY_NAMESPACE::lane_bits(U(), mask); };
    TileRequest hits{tile.x, tile.y, {}};
    std::uint32_t above = 0;
    for (int j = 0; j < kTileSize; ++j) {
        const std::uint32_t asked = row_inside(tile, j, view.width, view.height);
        const std::size_t first = visibility.index(tile.x, tile.y + j);
        const std::uint32_t *const instance = visibility.instance.data() + first, *const triangle =
                                                                                      visibility.triangle.data() +
                                                                                      first;
        std::uint32_t seen = 0, as_left = 0, as_above = 0;
        for (int i = 0; i < kTileSize && asked != 0; i += kLanes) {
            const auto here = hn::LoadU(ui, instance + i), own = hn::LoadU(ui, triangle + i);
            seen |= bits_of(hn::Ne(here, hn::Set(ui, kSkyInstance))) << i;
            const auto same = [&](std::ptrdiff_t offset) {
                return bits_of(hn::And(hn::Eq(here, hn::LoadU(ui, instance + i - offset)),
                                       hn::Eq(own, hn::LoadU(ui, triangle + i - offset))))
                       << i;
            };
            if (first != 0) as_left |= same(1);
            if (j > 0) as_above |= same(visibility.stride);
        }
        seen &= asked;
        hits.rows[j] = std::uint16_t(seen);
        // What a neighbour of the tile shows is in the set already.
        for (std::uint32_t left = seen & ~(as_left & seen << 1) & ~(as_above & above); left != 0; left &= left - 1) {
            const int i = std::countr_zero(left);
            primitives.add(instance[i], triangle[i]);
        }
        above = seen;
    }
    return hits;
}

}  // namespace HWY_NAMESPACE
}  // namespace ff::farfield::known
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace ff::farfield {
namespace known {
HWY_EXPORT(Collect);

TileRequest collect(const PinholeView& view, const TileRequest& tile, const VisibilityBuffer& visibility,
                    PrimitiveSet& primitives) {
    return HWY_DYNAMIC_DISPATCH(Collect)(view, tile, visibility, primitives);
}

}  // namespace known

namespace {

constexpr std::size_t kTilesPerTask = 8;
constexpr std::size_t kTilesTogether = 4;  // whose primitives are fetched at once

/// Scratch; only what is used of it is ever touched.
struct Task {
    PrimitiveSet primitives;
    std::array<PrimitiveId, kTilesTogether * PrimitiveSet::kCapacity> ids;
    std::array<KnownTriangle, kTilesTogether * PrimitiveSet::kCapacity> triangles;
    std::array<TileRequest, kTilesTogether> hits;
    std::array<std::size_t, kTilesTogether + 1> first{};
};

}  // namespace

CastCost cast_known_pixels(const scene::StaticScene& scene, const PinholeView& view, std::span<const TileRequest> tiles,
                           VisibilityBuffer& visibility) {
    FF_CHECK(visibility.width >= view.width && visibility.height >= view.height,
             "a buffer of {}x{} for a view of {}x{}", visibility.width, visibility.height, view.width, view.height);
    const beam::BeamView beam_view(view);
    CastCostSum sum;
    parallel_ranges(tiles.size(), kTilesPerTask, [&](std::size_t begin, std::size_t end) {
        Task task;
        CastCost cost;
        for (std::size_t first = begin; first < end; first += kTilesTogether) {
            const std::size_t count = std::min(kTilesTogether, end - first);
            for (std::size_t t = 0; t < count; ++t) {
                task.primitives.start(std::span(task.ids).subspan(task.first[t]));
                task.hits[t] = known::collect(view, tiles[first + t], visibility, task.primitives);
                task.first[t + 1] = task.first[t] + task.primitives.ids().size();
            }
            fetch_triangles(scene, std::span(task.ids).first(task.first[count]), task.triangles);
            for (std::size_t t = 0; t < count; ++t) {
                const std::size_t known = task.first[t + 1] - task.first[t];
                if (known == 0) continue;
                TileRequest missed;
                cast_known_tile(scene, beam_view, task.hits[t], std::span(task.triangles).subspan(task.first[t], known),
                                visibility, missed);
                cost.rays += count_pixels(std::span(&task.hits[t], 1), view.width, view.height) -
                             count_pixels(std::span(&missed, 1), view.width, view.height);
                cost.triangles += known;
            }
        }
        sum.add(cost);
    });
    return sum.total();
}

}  // namespace ff::farfield
#endif
