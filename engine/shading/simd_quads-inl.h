// Per-target SIMD: four rows of the records of as many triangles as a vector has lanes, by 4 x 4 transposes.

#if defined(FF_SHADING_SIMD_QUADS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef FF_SHADING_SIMD_QUADS_INL_H_
#undef FF_SHADING_SIMD_QUADS_INL_H_
#else
#define FF_SHADING_SIMD_QUADS_INL_H_
#endif

#include "engine/shading/simd_color-inl.h"
#include "engine/shading/tile_records.h"

HWY_BEFORE_NAMESPACE();
namespace ff::shading::HWY_NAMESPACE {

/// Four rows, a triangle a lane.
struct Quad {
    VF a, b, c, d;
};

/// Rows to columns in each 128-bit block; its own inverse.
HWY_INLINE Quad transposed(const Quad& q) {
    const hn::Repartition<double, DF> pairs;
    const auto low_ab = hn::BitCast(pairs, hn::InterleaveLower(df, q.a, q.b));
    const auto low_cd = hn::BitCast(pairs, hn::InterleaveLower(df, q.c, q.d));
    const auto high_ab = hn::BitCast(pairs, hn::InterleaveUpper(df, q.a, q.b));
    const auto high_cd = hn::BitCast(pairs, hn::InterleaveUpper(df, q.c, q.d));
    return {hn::BitCast(df, hn::InterleaveLower(pairs, low_ab, low_cd)),
            hn::BitCast(df, hn::InterleaveUpper(pairs, low_ab, low_cd)),
            hn::BitCast(df, hn::InterleaveLower(pairs, high_ab, high_cd)),
            hn::BitCast(df, hn::InterleaveUpper(pairs, high_ab, high_cd))};
}

/// Blocks of four floats from base + offset[0], base + offset[4], ..., lowest first.
template <class D>
HWY_INLINE hn::Vec<D> load_blocks(D d, const float* base, const std::int32_t* offset) {
    if constexpr (hn::MaxLanes(D()) <= 4) {
        return hn::Load(d, base + offset[0]);
    } else {
        const hn::Half<D> half;
        return hn::Combine(d, load_blocks(half, base, offset + hn::MaxLanes(half)), load_blocks(half, base, offset));
    }
}
HWY_INLINE Quad load_quad(const float* base, const std::int32_t* offset) {
    return transposed({load_blocks(df, base, offset), load_blocks(df, base, offset + 1),
                       load_blocks(df, base, offset + 2), load_blocks(df, base, offset + 3)});
}

/// Blocks of four floats to records 0, 4, ...
template <class D>
HWY_INLINE void store_blocks(D d, hn::Vec<D> blocks, float* record) {
    if constexpr (hn::MaxLanes(D()) <= 4) {
        hn::Store(blocks, d, record);
    } else {
        const hn::Half<D> half;
        store_blocks(half, hn::LowerHalf(half, blocks), record);
        store_blocks(half, hn::UpperHalf(half, blocks), record + hn::MaxLanes(half) * kRecordFloats);
    }
}
/// Writes the quad at `row` of a vector's records, which follow each other from `record` on.
HWY_INLINE void store_quad(float* record, int row, const Quad& rows) {
    const Quad lanes = transposed(rows);
    store_blocks(df, lanes.a, record + row);
    store_blocks(df, lanes.b, record + row + kRecordFloats);
    store_blocks(df, lanes.c, record + row + 2 * kRecordFloats);
    store_blocks(df, lanes.d, record + row + 3 * kRecordFloats);
}
/// A value at three corners as its value at corner 0 and its changes; `last` fills the quad.
HWY_INLINE void store_corners(float* record, int row, VF at0, VF at1, VF at2, VF last) {
    store_quad(record, row, {at0, hn::Sub(at1, at0), hn::Sub(at2, at0), last});
}

}  // namespace ff::shading::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
