// leaf_shift() of leaf_sway.h for vectors. Compiled once per SIMD target; include after <hwy/highway.h>.
#if defined(FF_LEAF_SWAY_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef FF_LEAF_SWAY_INL_H_
#undef FF_LEAF_SWAY_INL_H_
#else
#define FF_LEAF_SWAY_INL_H_
#endif

#include <hwy/highway.h>

#include "engine/math/leaf_sway.h"

HWY_BEFORE_NAMESPACE();
namespace ff::HWY_NAMESPACE {

/// Adds the shift to texture coordinates.
/// @param d         tag of the vectors' lanes
/// @param uv_per_m  of each lane's triangle; lanes with 0 do not move
/// @param x,y,z     places hit relative to the eye, in the sway's axes
template <class D, class V = hwy::HWY_NAMESPACE::Vec<D>>
HWY_INLINE void add_leaf_shift(D d, const LeafSway& sway, V uv_per_m, V x, V y, V z, V& u, V& v) {
    namespace hn = hwy::HWY_NAMESPACE;
    const auto set = [&](float value) HWY_ATTR { return hn::Set(d, value); };
    const V distance = hn::Sqrt(hn::MulAdd(x, x, hn::MulAdd(y, y, hn::Mul(z, z))));
    const V ahead = hn::NegMulAdd(distance, set(1.0f / sway.within_m), set(1.0f));
    const V fade = hn::Max(hn::Min(hn::Mul(ahead, set(1.0f / kLeafSwayFade)), set(1.0f)), set(0.0f));
    if (hn::AllTrue(d, hn::Eq(fade, set(0.0f)))) return;
    const auto wave = [&](const LeafSway::Train& train) HWY_ATTR {
        const Vec3& k = train.turns_per_m;
        const V turns = hn::MulAdd(set(k.x), x, hn::MulAdd(set(k.y), y, hn::MulAdd(set(k.z), z, set(train.turns))));
        const V t = hn::Sub(turns, hn::Floor(hn::Add(turns, set(0.5f))));
        return hn::Mul(hn::Mul(set(8.0f), t), hn::NegMulAdd(set(2.0f), hn::Abs(t), set(1.0f)));
    };
    const auto window = [&](V c) HWY_ATTR {
        const V f = hn::Sub(c, hn::Floor(c));
        return hn::Mul(hn::Mul(set(4.0f), f), hn::Sub(set(1.0f), f));
    };
    const V gust = hn::MulAdd(set(kGustSwing), wave(sway.gust), set(kGustMiddle));
    const V size = hn::Min(hn::Mul(set(sway.amplitude_m), uv_per_m), set(kMostLeafShift));
    const V shown = hn::Mul(hn::Mul(fade, hn::Mul(gust, size)), hn::Mul(window(u), window(v)));
    u = hn::MulAdd(shown, wave(sway.along_u), u);
    v = hn::MulAdd(shown, wave(sway.along_v), v);
}

}  // namespace ff::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
