// Sun rays of a group through one 16-wide hierarchy, the points that each subtree may hide as a word. Compiled once per
// SIMD target; include after <hwy/highway.h>.
#if defined(FF_SUN_WALK_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef FF_SUN_WALK_INL_H_
#undef FF_SUN_WALK_INL_H_
#else
#define FF_SUN_WALK_INL_H_
#endif

#include <hwy/highway.h>

#include <bit>
#include <cstdint>

#include "engine/farfield/sun_space-inl.h"

HWY_BEFORE_NAMESPACE();
namespace ff::farfield::beam {
namespace HWY_NAMESPACE {
namespace {

constexpr int kSunStackEntries = 2048;  // 15 per level of a tree; the builder keeps trees below 132 levels
constexpr int kFewPoints = 6;           // that are asked one by one which boxes they lie in

struct SunEntry {
    std::uint64_t points;
    std::uint32_t child;
};

// Boxes that the bounds of all points meet, and those of them in which the bounds lie.
struct MetBoxes {
    std::uint32_t met = 0, around = 0;
};

HWY_INLINE MetBoxes boxes_around_all(const BvhNode& node, const SunSpace& space, const GroupPoints& p,
                                     const Slabs& slabs, BoxSlabs& boxes) {
    MetBoxes out;
    for (int i = 0; i < 16; i += kLanes) {
        const float* lanes = node.low_x + i;
        const VF far = far_value(space, lanes);
        hn::Store(far, f, boxes.far + i);
        // An empty lane gives infinities of the wrong sign or, where an axis has a zero, not-a-number.
        MF met = hn::Ge(far, hn::Set(f, p.least_d)), around = hn::Ge(far, hn::Set(f, p.most_d));
        for (int k = 0; k < 3; ++k) {
            const VF low = box_value(space.low[k], lanes), high = box_value(space.high[k], lanes);
            const VF least = hn::Set(f, slabs.least[k]), most = hn::Set(f, slabs.most[k]);
            hn::Store(low, f, boxes.low[k] + i);
            hn::Store(high, f, boxes.high[k] + i);
            met = hn::And(met, hn::And(hn::Le(low, most), hn::Ge(high, least)));
            around = hn::And(around, hn::And(hn::Le(low, least), hn::Ge(high, most)));
        }
        out.met |= bits_of(met) << i;
        out.around |= bits_of(around) << i;
    }
    return out;
}

// Those of eight points that lie in a box.
HWY_INLINE std::uint32_t eight_in_box(const VP (&low)[3], const VP (&high)[3], VP far, const GroupPoints& p,
                                      const Slabs& slabs, int first) {
    std::uint32_t bits = 0;
    for (int i = 0; i < 8; i += kPointLanes) {
        MP in = hn::Le(hn::Load(pf, p.group.d + first + i), far);
        for (int k = 0; k < 3; ++k) {
            const VP at = hn::Load(pf, slabs.at[k] + first + i);
            in = hn::And(in, hn::And(hn::Ge(at, low[k]), hn::Le(at, high[k])));
        }
        bits |= point_bits(in) << i;
    }
    return bits;
}

// Those of the points that lie in a box: eights that are within or without it need not be asked one by one.
HWY_INLINE std::uint64_t points_in_box(const BoxSlabs& boxes, int lane, const GroupPoints& p, const Slabs& slabs,
                                       std::uint64_t points) {
    const VP far = hn::Set(pf, boxes.far[lane]);
    VP low[3], high[3];
    for (int k = 0; k < 3; ++k) {
        low[k] = hn::Set(pf, boxes.low[k][lane]);
        high[k] = hn::Set(pf, boxes.high[k][lane]);
    }
    std::uint32_t met = 0, within = 0;
    for (int i = 0; i < kEights; i += kPointLanes) {
        MP meets = hn::Le(hn::Load(pf, p.d.least + i), far), lies = hn::Le(hn::Load(pf, p.d.most + i), far);
        for (int k = 0; k < 3; ++k) {
            const VP least = hn::Load(pf, slabs.eights[k].least + i), most = hn::Load(pf, slabs.eights[k].most + i);
            meets = hn::And(meets, hn::And(hn::Le(low[k], most), hn::Ge(high[k], least)));
            lies = hn::And(lies, hn::And(hn::Le(low[k], least), hn::Ge(high[k], most)));
        }
        met |= point_bits(meets) << i;
        within |= point_bits(lies) << i;
    }
    std::uint64_t in_box = points_of_eights(within);
    for (std::uint32_t rest = met & ~within & eights_of_points(points); rest != 0; rest &= rest - 1) {
        const int first = std::countr_zero(rest) * 8;
        in_box |= std::uint64_t(eight_in_box(low, high, far, p, slabs, first)) << first;
    }
    return in_box & points;
}

// Boxes that one point lies in.
HWY_INLINE std::uint32_t boxes_around_one(const BoxSlabs& boxes, const GroupPoints& p, const Slabs& slabs, int point) {
    std::uint32_t bits = 0;
    for (int i = 0; i < 16; i += kLanes) {
        MF in = hn::Ge(hn::Load(f, boxes.far + i), hn::Set(f, p.group.d[point]));
        for (int k = 0; k < 3; ++k) {
            const VF at = hn::Set(f, slabs.at[k][point]);
            in = hn::And(
                in, hn::And(hn::Le(hn::Load(f, boxes.low[k] + i), at), hn::Ge(hn::Load(f, boxes.high[k] + i), at)));
        }
        bits |= bits_of(in) << i;
    }
    return bits;
}

HWY_INLINE void find_box_slabs(const BvhNode& node, const SunSpace& space, BoxSlabs& boxes) {
    for (int i = 0; i < 16; i += kLanes) {
        const float* lanes = node.low_x + i;
        hn::Store(far_value(space, lanes), f, boxes.far + i);
        for (int k = 0; k < 3; ++k) {
            hn::Store(box_value(space.low[k], lanes), f, boxes.low[k] + i);
            hn::Store(box_value(space.high[k], lanes), f, boxes.high[k] + i);
        }
    }
}

template <class T>
HWY_INLINE void prefetch_all(const T* object) {
    const char* at = reinterpret_cast<const char*>(object);
    for (std::size_t byte = 0; byte < sizeof(T); byte += 64) __builtin_prefetch(at + byte);
}

// Walks a hierarchy; `on_leaf(leaf id, points)` takes from `left` what it hides.
// @param all  points that may be hidden; those of them that are not in `left` any more are passed by
template <class Prefetch, class OnLeaf>
HWY_INLINE void walk_sunwards(const BvhNode* nodes, const SunSpace& space, const GroupPoints& p, const Slabs& slabs,
                              std::uint64_t all, const std::uint64_t& left, std::uint64_t& visited,
                              Prefetch&& prefetch_child, OnLeaf&& on_leaf) {
    SunEntry stack[kSunStackEntries];
    int top = 0;
    stack[top++] = {all, 0};
    while (top > 0) {
        const SunEntry entry = stack[--top];
        const std::uint64_t points = entry.points & left;
        if (points == 0) continue;
        if (entry.child & kBvhLeafBit) {
            on_leaf(entry.child & ~kBvhLeafBit, points);
            continue;
        }
        const BvhNode& node = nodes[entry.child];
        ++visited;
        if (top + scene::kBvhWidth > kSunStackEntries) continue;  // no tree of ours is that deep
        BoxSlabs boxes;
        std::uint64_t of_box[16];
        std::uint32_t met = 0;
        if (std::popcount(points) <= kFewPoints) {
            find_box_slabs(node, space, boxes);
            for (std::uint64_t rest = points; rest != 0; rest &= rest - 1) {
                const int point = std::countr_zero(rest);
                const std::uint32_t bits = boxes_around_one(boxes, p, slabs, point);
                for (std::uint32_t lanes = bits; lanes != 0; lanes &= lanes - 1) {
                    const int lane = std::countr_zero(lanes);
                    of_box[lane] = (met >> lane & 1u ? of_box[lane] : 0) | std::uint64_t(1) << point;
                }
                met |= bits;
            }
        } else {
            const MetBoxes found = boxes_around_all(node, space, p, slabs, boxes);
            for (std::uint32_t lanes = found.met; lanes != 0; lanes &= lanes - 1) {
                const int lane = std::countr_zero(lanes);
                of_box[lane] = found.around >> lane & 1u ? points : points_in_box(boxes, lane, p, slabs, points);
                if (of_box[lane] != 0) met |= 1u << lane;
            }
        }
        // What hides most is asked first.
        const int bottom = top;
        for (; met != 0; met &= met - 1) {
            const int lane = std::countr_zero(met);
            const SunEntry child{of_box[lane], node.child[lane]};
            prefetch_child(child.child);
            const int count = std::popcount(child.points);
            int at = top++;
            for (; at > bottom && std::popcount(stack[at - 1].points) > count; --at) stack[at] = stack[at - 1];
            stack[at] = child;
        }
    }
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace ff::farfield::beam
HWY_AFTER_NAMESPACE();

#endif
