// Whoever fills a band goes through all old rows that reach it, in the old image's order: no two workers write to one
// pixel, and the number of workers changes nothing.

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "engine/farfield/reproject_splat.cpp"
#include <hwy/foreach_target.h>  // must come before highway.h
#include <hwy/highway.h>

#include <algorithm>
#include <bit>

#include "engine/farfield/lane_bits-inl.h"
#include "engine/farfield/reproject_splat.h"

HWY_BEFORE_NAMESPACE();
namespace ff::farfield::reprojection {
namespace HWY_NAMESPACE {
namespace {
namespace hn = hwy::HWY_NAMESPACE;
using farfield::HWY_NAMESPACE::lane_bits;

using I = hn::CappedTag<std::int32_t, 16>;
using F = hn::RebindToFloat<I>;
using U = hn::RebindToUnsigned<I>;
constexpr I si;
constexpr F f;
constexpr U ui;
constexpr int kLanes = int(hn::MaxLanes(si));

// A register of old points.
struct Points {
    hn::Vec<U> instance, triangle;
    hn::Vec<F> depth;
};

// Plain pointers into a band: what registers are stored to might be anything, for all that a compiler knows.
struct Pixels {
    std::uint32_t *instance, *triangle;
    float* depth;
};

// Whatever comes to an empty pixel stays, as do instances before sky, and sky after sky does no harm.
HWY_INLINE hn::Mask<I> is_free(hn::Vec<U> instance) {
    static_assert(AuxiliaryBand::kAbrupt >= 1u << 31, "and names of instances are less");
    return hn::Lt(hn::BitCast(si, instance), hn::Zero(si));
}

// Those of `lanes` land side by side: lane i in the pixel `at` + i.
HWY_INLINE void land(const Points& points, hn::Mask<I> lanes, const Pixels& to, std::ptrdiff_t at) {
    const auto old_instance = hn::LoadU(ui, to.instance + at), old_triangle = hn::LoadU(ui, to.triangle + at);
    const auto old_depth = hn::LoadU(f, to.depth + at);
    const auto nearer = hn::RebindMask(si, hn::Lt(points.depth, old_depth));
    const auto wins = hn::And(lanes, hn::Or(is_free(old_instance), nearer));
    const auto wins_u = hn::RebindMask(ui, wins);
    hn::StoreU(hn::IfThenElse(wins_u, points.instance, old_instance), ui, to.instance + at);
    hn::StoreU(hn::IfThenElse(wins_u, points.triangle, old_triangle), ui, to.triangle + at);
    hn::StoreU(hn::IfThenElse(hn::RebindMask(f, wins), points.depth, old_depth), f, to.depth + at);
}

// A whole register lands side by side, as points of a surface mostly do.
HWY_INLINE void land_all(const Points& points, const Pixels& to, std::ptrdiff_t at) {
    const auto all_free = is_free(hn::LoadU(ui, to.instance + at));
    if (HWY_UNLIKELY(!hn::AllTrue(si, all_free))) {
        land(points, hn::MaskFromVec(hn::Set(si, -1)), to, at);
        return;
    }
    hn::StoreU(points.instance, ui, to.instance + at);
    hn::StoreU(points.triangle, ui, to.triangle + at);
    hn::StoreU(points.depth, f, to.depth + at);
}

}  // namespace

void FillBand(const VisibilityBuffer& last, const ReprojectedPoints& points, int tile_y, AuxiliaryBand& band) {
    band.first_row = tile_y * kTileSize - 1;
    const std::int32_t begin = (band.first_row + 1) * band.stride, size = AuxiliaryBand::kRows * band.stride;
    std::fill(band.instance.begin(), band.instance.end(), AuxiliaryBand::kEmpty);
    const Pixels pixels{band.instance.data(), band.triangle.data(), band.depth.data()};
    const auto first_place = hn::Set(ui, std::uint32_t(begin)), last_place = hn::Set(ui, std::uint32_t(size - 1));
    const auto abrupt_bit = hn::Set(ui, std::uint32_t(ReprojectedPoints::kAbruptBit));
    const auto depth_per_x = hn::Set(f, points.depth_per_x), depth_step = hn::Set(f, points.depth_step);
    const auto lane_numbers = hn::Iota(si, 0);
    const int width = last.width;
    const std::ptrdiff_t ahead = last.stride;  // asked for in time, if only by addresses
    for (int y = 0; y < last.height; ++y) {
        if (points.last_target[std::size_t(y)] < begin || points.first_target[std::size_t(y)] >= begin + size) continue;
        const std::size_t first = last.index(0, y);
        const std::int32_t* const targets = points.target.data() + first;
        const std::uint32_t *const instances = last.instance.data() + first, *const triangles =
                                                                                 last.triangle.data() + first;
        const float* const depths = last.depth.data() + first;
        const auto depth_of_row = hn::Set(f, float(y) * points.depth_per_y + points.depth_constant);
        for (int x = 0; x < width; x += kLanes) {
            __builtin_prefetch(targets + x + ahead);
            __builtin_prefetch(instances + x + ahead);
            __builtin_prefetch(triangles + x + ahead);
            __builtin_prefetch(depths + x + ahead);
            const auto target = hn::LoadU(si, targets + x);
            const auto place = hn::Sub(hn::AndNot(abrupt_bit, hn::BitCast(ui, target)), first_place);
            const auto mine = hn::RebindMask(si, hn::Eq(hn::Min(place, last_place), place));  // kOutside is beyond all
            std::uint32_t left = lane_bits(si, mine);
            if (left == 0) continue;
            const auto per_depth = hn::MulAdd(hn::Iota(f, float(x)), depth_per_x, depth_of_row);
            const Points old{hn::LoadU(ui, instances + x), hn::LoadU(ui, triangles + x),
                             hn::MulSub(per_depth, hn::LoadU(f, depths + x), depth_step)};
            while (left != 0) {
                const int lane = std::countr_zero(left);
                const std::int32_t leader = targets[x + lane];
                if ((leader & ReprojectedPoints::kAbruptBit) != 0) {
                    std::uint32_t& to = pixels.instance[(leader ^ ReprojectedPoints::kAbruptBit) - begin];
                    if (to == AuxiliaryBand::kEmpty) to = AuxiliaryBand::kAbrupt;
                    left &= left - 1;
                    continue;
                }
                // Lanes that follow without a gap.
                const auto row = hn::Add(lane_numbers, hn::Set(si, leader - lane));
                const std::uint32_t same = lane_bits(si, hn::And(mine, hn::Eq(target, row))) >> lane;
                const int count = std::countr_one(same);
                const std::ptrdiff_t at = leader - lane - begin;
                if (count == kLanes) {
                    land_all(old, pixels, at);
                    break;
                }
                const auto lanes = hn::And(hn::Gt(lane_numbers, hn::Set(si, lane - 1)),
                                           hn::Lt(lane_numbers, hn::Set(si, lane + count)));
                land(old, lanes, pixels, at);
                left &= ~(((1u << count) - 1u) << lane);
            }
        }
    }
}

}  // namespace HWY_NAMESPACE
}  // namespace ff::farfield::reprojection
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace ff::farfield::reprojection {
HWY_EXPORT(FillBand);

void AuxiliaryBand::resize(const AuxiliaryLayout& layout) {
    if (stride == layout.stride) return;
    stride = layout.stride;
    const std::size_t count = std::size_t(kRows) * std::size_t(stride);
    instance.assign(count, kEmpty);
    triangle.assign(count, 0);
    depth.assign(count, 0.0f);
}

void fill_band(const VisibilityBuffer& last, const ReprojectedPoints& points, int tile_y, AuxiliaryBand& band) {
    HWY_DYNAMIC_DISPATCH(FillBand)(last, points, tile_y, band);
}

}  // namespace ff::farfield::reprojection
#endif
