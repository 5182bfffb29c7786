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

// Those of `lanes` land side by side, as points of a surface mostly do: lane i in the pixel `at` + i.
HWY_INLINE void land(const Points& points, hn::Mask<U> lanes, std::size_t at, AuxiliaryBand& band) {
    const auto old_instance = hn::LoadU(ui, band.instance.data() + at);
    const auto old_depth = hn::LoadU(f, band.depth.data() + at);
    // Whatever comes to an empty pixel stays, as do instances before sky, and sky after sky does no harm.
    const auto is_free = hn::Gt(old_instance, hn::Set(ui, AuxiliaryBand::kAbrupt - 1));
    const auto wins = hn::And(lanes, hn::Or(is_free, hn::RebindMask(ui, hn::Lt(points.depth, old_depth))));
    const auto old_triangle = hn::LoadU(ui, band.triangle.data() + at);
    hn::StoreU(hn::IfThenElse(wins, points.instance, old_instance), ui, band.instance.data() + at);
    hn::StoreU(hn::IfThenElse(wins, points.triangle, old_triangle), ui, band.triangle.data() + at);
    hn::StoreU(hn::IfThenElse(hn::RebindMask(f, wins), points.depth, old_depth), f, band.depth.data() + at);
}

HWY_INLINE void land_abrupt(std::size_t at, AuxiliaryBand& band) {
    if (band.instance[at] == AuxiliaryBand::kEmpty) band.instance[at] = AuxiliaryBand::kAbrupt;
}

}  // namespace

void FillBand(const VisibilityBuffer& last, const ReprojectedPoints& points, int tile_y, AuxiliaryBand& band) {
    band.first_row = tile_y * kTileSize - 1;
    const std::int32_t begin = (band.first_row + 1) * band.stride, end = begin + AuxiliaryBand::kRows * band.stride;
    std::fill(band.instance.begin(), band.instance.end(), AuxiliaryBand::kEmpty);
    const auto before_begin = hn::Set(si, begin - 1), at_end = hn::Set(si, end);
    const auto abrupt_bit = hn::Set(si, ReprojectedPoints::kAbruptBit);
    for (int y = 0; y < last.height; ++y) {
        if (points.last_target[std::size_t(y)] < begin || points.first_target[std::size_t(y)] >= end) continue;
        const std::size_t first = last.index(0, y);
        const auto depth_of_row = hn::Set(f, float(y) * points.depth_per_y + points.depth_constant);
        for (int x = 0; x < last.width; x += kLanes) {
            const std::size_t source = first + std::size_t(x);
            const auto target = hn::LoadU(si, points.target.data() + source);
            const auto place = hn::AndNot(abrupt_bit, target);  // kOutside is less than any
            const auto mine = hn::And(hn::Gt(target, hn::Set(si, ReprojectedPoints::kOutside)),
                                      hn::And(hn::Gt(place, before_begin), hn::Lt(place, at_end)));
            std::uint32_t left = lane_bits(si, mine);
            if (left == 0) continue;
            const auto per_depth = hn::MulAdd(hn::Iota(f, float(x)), hn::Set(f, points.depth_per_x), depth_of_row);
            const Points old{
                hn::LoadU(ui, last.instance.data() + source), hn::LoadU(ui, last.triangle.data() + source),
                hn::MulSub(per_depth, hn::LoadU(f, last.depth.data() + source), hn::Set(f, points.depth_step))};
            while (left != 0) {
                const int lane = std::countr_zero(left);
                const std::int32_t leader = points.target[source + std::size_t(lane)];
                if ((leader & ReprojectedPoints::kAbruptBit) != 0) {
                    land_abrupt(std::size_t((leader ^ ReprojectedPoints::kAbruptBit) - begin), band);
                    left &= left - 1;
                    continue;
                }
                // Lanes that follow without a gap.
                const auto row = hn::Iota(si, leader - lane);
                const std::uint32_t same = lane_bits(si, hn::And(mine, hn::Eq(target, row))) >> lane;
                const int count = std::countr_one(same);
                const auto lanes = hn::And(hn::Gt(hn::Iota(si, 0), hn::Set(si, lane - 1)),
                                           hn::Lt(hn::Iota(si, 0), hn::Set(si, lane + count)));
                land(old, hn::RebindMask(ui, lanes), std::size_t(leader - lane - begin), band);
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
