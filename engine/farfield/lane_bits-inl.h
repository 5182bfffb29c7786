// Masks of lanes as words. Compiled once per SIMD target; include after <hwy/highway.h>.
#if defined(FF_LANE_BITS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef FF_LANE_BITS_INL_H_
#undef FF_LANE_BITS_INL_H_
#else
#define FF_LANE_BITS_INL_H_
#endif

#include <hwy/highway.h>

#include <cstdint>

HWY_BEFORE_NAMESPACE();
namespace ff::farfield {
namespace HWY_NAMESPACE {

/// Bit i: lane i. Up to 16 lanes.
template <class D>
HWY_INLINE std::uint32_t lane_bits(D d, hwy::HWY_NAMESPACE::Mask<D> mask) {
    std::uint8_t bytes[8] = {};
    hwy::HWY_NAMESPACE::StoreMaskBits(d, mask, bytes);
    return hwy::HWY_NAMESPACE::MaxLanes(d) > 8 ? std::uint32_t(bytes[0] | bytes[1] << 8) : std::uint32_t(bytes[0]);
}

}  // namespace HWY_NAMESPACE
}  // namespace ff::farfield
HWY_AFTER_NAMESPACE();

#endif
