// Based on: Assarsson, Möller, "Optimized View Frustum Culling Algorithms for Bounding Boxes", JGT 2000: a box is
// outside a plane where dot(n, centre) + dot(|n|, half extent) < 0. Ours: float with a slack for its rounding.
#include "engine/visibility/cull_boxes.h"

#include <algorithm>
#include <cmath>

#include "engine/core/check.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "engine/visibility/cull_boxes.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace ff::visibility::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

/// Sums of at most nine rounded products and terms: each costs at most half an ulp of the sum of magnitudes, 2^-24 of
/// it. 1e-6 is almost twice the nine.
constexpr float kRelativeSlack = 1e-6f;

void cull(const float (*normals)[3], const float* offset, const BoxArray& boxes, std::size_t begin, std::size_t count,
          std::uint32_t* out) {
    const hn::ScalableTag<float> d;
    const hn::RebindToUnsigned<decltype(d)> du;
    const auto zero = hn::Zero(d);
    const float offset_size = std::abs(offset[0]) + std::abs(offset[1]) + std::abs(offset[2]);
    for (std::size_t i = 0; i < count; i += hn::Lanes(d)) {
        const auto local_x = hn::LoadU(d, &boxes.center_x[begin + i]);
        const auto local_y = hn::LoadU(d, &boxes.center_y[begin + i]);
        const auto local_z = hn::LoadU(d, &boxes.center_z[begin + i]);
        const auto half_x = hn::LoadU(d, &boxes.half_x[begin + i]);
        const auto half_y = hn::LoadU(d, &boxes.half_y[begin + i]);
        const auto half_z = hn::LoadU(d, &boxes.half_z[begin + i]);
        const auto x = hn::Add(local_x, hn::Set(d, offset[0]));
        const auto y = hn::Add(local_y, hn::Set(d, offset[1]));
        const auto z = hn::Add(local_z, hn::Set(d, offset[2]));
        const auto local_size = hn::Add(hn::Add(hn::Abs(local_x), hn::Abs(local_y)), hn::Abs(local_z));
        const auto half_size = hn::Add(hn::Add(half_x, half_y), half_z);
        const auto slack =
            hn::Mul(hn::Set(d, kRelativeSlack), hn::Add(hn::Add(local_size, half_size), hn::Set(d, offset_size)));
        const auto empty = hn::Lt(half_x, zero);
        auto outside = empty;
        auto inside = hn::Not(empty);
        for (int p = 0; p < Frustum::kPlanes; ++p) {
            const float* n = normals[p];
            auto distance = hn::Mul(hn::Set(d, n[0]), x);
            distance = hn::MulAdd(hn::Set(d, n[1]), y, distance);
            distance = hn::MulAdd(hn::Set(d, n[2]), z, distance);
            auto reach = hn::Mul(hn::Set(d, std::abs(n[0])), half_x);
            reach = hn::MulAdd(hn::Set(d, std::abs(n[1])), half_y, reach);
            reach = hn::MulAdd(hn::Set(d, std::abs(n[2])), half_z, reach);
            reach = hn::Add(reach, slack);
            outside = hn::Or(outside, hn::Lt(hn::Add(distance, reach), zero));
            inside = hn::And(inside, hn::Ge(distance, reach));
        }
        auto overlap = hn::IfThenElse(hn::RebindMask(du, inside), hn::Set(du, std::uint32_t(Overlap::inside)),
                                      hn::Set(du, std::uint32_t(Overlap::intersects)));
        overlap = hn::IfThenElseZero(hn::Not(hn::RebindMask(du, outside)), overlap);
        hn::StoreU(overlap, du, out + i);
    }
}

}  // namespace ff::visibility::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace ff::visibility {
HWY_EXPORT(cull);

void BoxArray::add(const DBox3& box, const WorldPos& origin) {
    const DVec3 center = box.center() - origin, half = 0.5 * box.extent();
    const auto put = [&](int axis, std::vector<float>& centers, std::vector<float>& halves) {
        const auto rounded = box.is_empty() ? 0.0f : float(center[axis]);
        centers.push_back(rounded);
        // What rounding moved the centre by, the half extent gives back; and one ulp for its own rounding.
        const double needed = half[axis] + std::abs(center[axis] - double(rounded));
        halves.push_back(box.is_empty() ? -1.0f : std::nextafter(float(needed), INFINITY));
    };
    put(0, center_x, half_x);
    put(1, center_y, half_y);
    put(2, center_z, half_z);
    ++count;
}

void BoxArray::finish() {
    for (auto* centers : {&center_x, &center_y, &center_z}) centers->resize(count + kCullPadding, 0.0f);
    for (auto* halves : {&half_x, &half_y, &half_z}) halves->resize(count + kCullPadding, -1.0f);
}

void cull_boxes(const Frustum& frustum, const BoxArray& boxes, const WorldPos& origin, std::size_t begin,
                std::size_t count, std::span<Overlap> out) {
    FF_CHECK(begin + count <= boxes.count && out.size() >= count + kCullPadding - 1,
             "{} boxes at {} of {}, room for {}", count, begin, boxes.count, out.size());
    float normals[Frustum::kPlanes][3];
    for (int p = 0; p < Frustum::kPlanes; ++p)
        for (int axis = 0; axis < 3; ++axis) normals[p][axis] = float(frustum.normals[p][axis]);
    const DVec3 offset = origin - frustum.position;
    const float rounded[3] = {float(offset.x), float(offset.y), float(offset.z)};
    HWY_DYNAMIC_DISPATCH(cull)(normals, rounded, boxes, begin, count, reinterpret_cast<std::uint32_t*>(out.data()));
}

}  // namespace ff::visibility
#endif
