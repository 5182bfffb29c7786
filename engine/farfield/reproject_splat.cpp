// Whoever fills some rows of the new image goes through all old rows that reach them, in the old image's order: no two
// workers write to one pixel, and the number of workers changes nothing.

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "engine/farfield/reproject_splat.cpp"
#include <hwy/foreach_target.h>  // must come before highway.h
#include <hwy/highway.h>

#include <algorithm>
#include <bit>
#include <limits>

#include "engine/farfield/lane_bits-inl.h"
#include "engine/farfield/reproject_splat.h"

HWY_BEFORE_NAMESPACE();
namespace ff::farfield::reprojection {
namespace HWY_NAMESPACE {
namespace {
namespace hn = hwy::HWY_NAMESPACE;

using I = hn::CappedTag<std::int32_t, 16>;
using F = hn::RebindToFloat<I>;
using U = hn::RebindToUnsigned<I>;
constexpr I si;
constexpr F f;
constexpr U ui;
constexpr int kLanes = int(hn::MaxLanes(si));

HWY_INLINE void land(const VisibilityBuffer& last, std::size_t source, std::int32_t target, float depth,
                     AuxiliaryImage& auxiliary) {
    if ((target & ReprojectedPoints::kAbruptBit) != 0) {
        const auto at = std::size_t(target ^ ReprojectedPoints::kAbruptBit);
        if (auxiliary.instance[at] == AuxiliaryImage::kEmpty) auxiliary.instance[at] = AuxiliaryImage::kAbrupt;
        return;
    }
    const auto at = std::size_t(target);
    const std::uint32_t old = auxiliary.instance[at];
    const bool is_first = old == AuxiliaryImage::kEmpty || old == AuxiliaryImage::kAbrupt;
    if (!is_first && !(depth < auxiliary.depth[at])) return;
    auxiliary.depth[at] = depth;
    auxiliary.instance[at] = last.instance[source];
    auxiliary.triangle[at] = last.triangle[source];
}

// A register of points that land side by side, as those of a surface mostly do.
HWY_INLINE void land_side_by_side(const VisibilityBuffer& last, std::size_t source, std::int32_t target,
                                  hn::Vec<F> depth, AuxiliaryImage& auxiliary) {
    const auto at = std::size_t(target);
    const auto old_instance = hn::LoadU(ui, auxiliary.instance.data() + at);
    const auto old_depth = hn::LoadU(f, auxiliary.depth.data() + at);
    // Only sky, empty and abrupt pixels have such names; sky lies at infinity, which is not nearer than anything.
    const auto is_first = hn::Or(hn::Eq(old_instance, hn::Set(ui, AuxiliaryImage::kEmpty)),
                                 hn::Eq(old_instance, hn::Set(ui, AuxiliaryImage::kAbrupt)));
    const auto wins = hn::Or(hn::RebindMask(f, is_first), hn::Lt(depth, old_depth));
    const auto wins_u = hn::RebindMask(ui, wins);
    const auto instance = hn::LoadU(ui, last.instance.data() + source);
    const auto triangle = hn::LoadU(ui, last.triangle.data() + source);
    const auto old_triangle = hn::LoadU(ui, auxiliary.triangle.data() + at);
    hn::StoreU(hn::IfThenElse(wins, depth, old_depth), f, auxiliary.depth.data() + at);
    hn::StoreU(hn::IfThenElse(wins_u, instance, old_instance), ui, auxiliary.instance.data() + at);
    hn::StoreU(hn::IfThenElse(wins_u, triangle, old_triangle), ui, auxiliary.triangle.data() + at);
}

}  // namespace

void FillRows(const VisibilityBuffer& last, const ReprojectedPoints& points, int first_row, int last_row,
              AuxiliaryImage& auxiliary) {
    const std::int32_t begin = first_row * auxiliary.stride, end = last_row * auxiliary.stride;
    std::fill(auxiliary.instance.begin() + begin, auxiliary.instance.begin() + end, AuxiliaryImage::kEmpty);
    for (int y = 0; y < last.height; ++y) {
        if (points.last_target[std::size_t(y)] < begin || points.first_target[std::size_t(y)] >= end) continue;
        const std::size_t first = last.index(0, y);
        for (int x = 0; x < last.width; x += kLanes) {
            const std::size_t source = first + std::size_t(x);
            const auto target = hn::LoadU(si, points.target.data() + source);
            const auto place = hn::AndNot(hn::Set(si, ReprojectedPoints::kAbruptBit), target);
            const auto in_image = hn::Lt(hn::Iota(si, x), hn::Set(si, last.width));
            const auto mine = hn::And(
                in_image, hn::And(hn::Gt(target, hn::Set(si, ReprojectedPoints::kOutside)),
                                  hn::And(hn::Gt(place, hn::Set(si, begin - 1)), hn::Lt(place, hn::Set(si, end)))));
            const std::int32_t leader = points.target[source];
            const auto row = hn::Add(hn::Set(si, leader), hn::Iota(si, 0));
            if (hn::AllTrue(si, hn::And(mine, hn::Eq(target, row))) && (leader & ReprojectedPoints::kAbruptBit) == 0) {
                land_side_by_side(last, source, leader, hn::LoadU(f, points.depth.data() + source), auxiliary);
                continue;
            }
            for (std::uint32_t bits = farfield::HWY_NAMESPACE::lane_bits(si, mine); bits != 0; bits &= bits - 1) {
                const std::size_t at = source + std::size_t(std::countr_zero(bits));
                land(last, at, points.target[at], points.depth[at], auxiliary);
            }
        }
    }
}

}  // namespace HWY_NAMESPACE
}  // namespace ff::farfield::reprojection
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace ff::farfield::reprojection {
HWY_EXPORT(FillRows);

void fill_rows(const VisibilityBuffer& last, const ReprojectedPoints& points, int first_row, int last_row,
               AuxiliaryImage& auxiliary) {
    HWY_DYNAMIC_DISPATCH(FillRows)(last, points, first_row, last_row, auxiliary);
}

}  // namespace ff::farfield::reprojection
#endif
