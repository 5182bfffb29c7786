// Per-target SIMD: bilinear samples of mip-mapped RGBA8 textures, one texture for all lanes or one per lane.

#if defined(FF_SHADING_SIMD_TEXTURE_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef FF_SHADING_SIMD_TEXTURE_INL_H_
#undef FF_SHADING_SIMD_TEXTURE_INL_H_
#else
#define FF_SHADING_SIMD_TEXTURE_INL_H_
#endif

#include "engine/shading/simd_color-inl.h"
#include "engine/shading/texture_info.h"

HWY_BEFORE_NAMESPACE();
namespace ff::shading::HWY_NAMESPACE {

/// One coordinate's two neighbouring texel columns (or rows) and the weight of the second.
struct Taps {
    VI first, second;
    VU weight;  ///< 0..255, of 256
};

/// @param coordinate  in texture widths; any value, NaN included, gives texels inside
/// @param info  shifted so that the wrap bits of this coordinate are kWrapClamp and kWrapMirror
HWY_INLINE Taps taps_along(VF coordinate, VI log2_size, VI info, bool all_repeat) {
    const VI size = hn::Shl(hn::Set(di, 1), log2_size);
    const VI last = hn::Sub(size, hn::Set(di, 1));
    // Within one period before it becomes an integer: uv of a 30 km ground plane must not overflow.
    VF within = hn::Sub(coordinate, hn::Floor(coordinate));
    auto repeats = hn::FirstN(di, hn::Lanes(di));
    if (!all_repeat) {
        const auto clamps = hn::TestBit(info, hn::Set(di, kWrapClamp));
        const auto mirrors = hn::TestBit(info, hn::Set(di, kWrapMirror));
        repeats = hn::Not(hn::Or(clamps, mirrors));
        // Triangle wave 0..1..0 of period 2.
        const VF half = hn::Mul(coordinate, splat(0.5f));
        const VF phase = hn::Sub(half, hn::Floor(hn::Add(half, splat(0.5f))));
        within = hn::IfThenElse(hn::RebindMask(df, mirrors), hn::Abs(hn::Add(phase, phase)), within);
        within = hn::IfThenElse(hn::RebindMask(df, clamps), clamp01(coordinate), within);
    }
    // Texel centres lie at halves; 8 bits of fraction. 3 * 2^22 rounds to an integer as kMagic does, negative ones too.
    const VF scale = hn::BitCast(df, hn::ShiftLeft<23>(hn::Add(log2_size, hn::Set(di, 127 + 8))));
    const VF rounded = hn::MulAdd(within, scale, splat(1.5f * kMagic - 128.0f));
    const VI fixed = hn::Sub(hn::BitCast(di, rounded), hn::BitCast(di, splat(1.5f * kMagic)));
    const VI texel = hn::ShiftRight<8>(fixed);
    Taps taps;
    taps.weight = hn::BitCast(du, hn::And(fixed, hn::Set(di, 255)));
    const VI next = hn::Add(texel, hn::Set(di, 1));
    taps.first = hn::And(texel, last);
    taps.second = hn::And(next, last);
    if (!all_repeat) {
        const VI zero = hn::Zero(di);
        taps.first = hn::IfThenElse(repeats, taps.first, hn::Min(hn::Max(texel, zero), last));
        taps.second = hn::IfThenElse(repeats, taps.second, hn::Min(hn::Max(next, zero), last));
    }
    return taps;
}

/// texels[index] and texels[index + 1] of every lane. Zen 3 gathers a vector of 8 in 10 cycles; eight 64-bit loads and
/// shuffles bring both vectors in 6.
HWY_INLINE void load_pairs(const std::uint32_t* texels, VI index, VU& first, VU& second) {
#if HWY_TARGET == HWY_AVX2
    alignas(32) std::uint32_t at[8];
    hn::Store(hn::BitCast(du, index), du, at);
    const auto load = [&](int lane) HWY_ATTR {
        const __m128i low = _mm_loadl_epi64(reinterpret_cast<const __m128i*>(texels + at[lane]));
        const auto* high = reinterpret_cast<const __m64*>(texels + at[lane + 1]);
        return _mm_loadh_pi(_mm_castsi128_ps(low), high);
    };
    const __m256 p0145 = _mm256_set_m128(load(4), load(0)), p2367 = _mm256_set_m128(load(6), load(2));
    first = VU{_mm256_castps_si256(_mm256_shuffle_ps(p0145, p2367, 0x88))};
    second = VU{_mm256_castps_si256(_mm256_shuffle_ps(p0145, p2367, 0xDD))};
#else
    first = hn::GatherIndex(du, texels, index);
    second = hn::GatherIndex(du, texels + 1, index);
#endif
}

/// A bilinear sample inside the mip level that the footprint asks for. Filtered as encoded, like an RGBA8 texture in
/// GL.
/// @param texels     base[i] is texel base_index[lane] + i of the scene
/// @param footprint  texture areas (uv^2) that a pixel covers, >= 0
/// @return encoded RGB in [0, 1]
HWY_INLINE Rgb sample_texture(const std::uint32_t* texels, VI base_index, VI info, VF u, VF v, VF footprint,
                              bool all_repeat) {
    const VI log2_width = hn::And(info, hn::Set(di, 15));
    const VI log2_height = hn::And(hn::ShiftRight<4>(info), hn::Set(di, 15));
    const VI log2_area = hn::Add(log2_width, log2_height);
    const VI zero = hn::Zero(di), one = hn::Set(di, 1);

    // level = round(log2(footprint in texels) / 2) = floor(log2(2 * footprint) / 2): an exponent and a shift.
    const VI exponent = hn::Sub(hn::ShiftRight<23>(hn::BitCast(di, footprint)), hn::Set(di, 126));
    const VI wanted = hn::ShiftRight<1>(hn::Add(exponent, log2_area));
    const VI long_side = hn::Max(log2_width, log2_height), short_side = hn::Min(log2_width, log2_height);
    const VI level = hn::Min(hn::Max(wanted, zero), long_side);
    const VI level_width = hn::Max(hn::Sub(log2_width, level), zero);
    const VI level_height = hn::Max(hn::Sub(log2_height, level), zero);

    // Texels before the level: areas fall by 4 until the short side is 1 (a geometric series, exact in integers:
    // 0xAAAAAAAB is 1/3 modulo 2^32), by 2 from there on.
    const VI shrinks = hn::Min(level, short_side);
    const VI fours = hn::Sub(hn::Shl(one, log2_area), hn::Shl(one, hn::Sub(hn::Sub(log2_area, shrinks), shrinks)));
    VI before = hn::Mul(hn::ShiftLeft<2>(fours), hn::Set(di, static_cast<std::int32_t>(0xAAAAAAABu)));
    const auto is_line = hn::Gt(level, short_side);
    if (!hn::AllFalse(di, is_line)) {
        const VI twos = hn::Sub(hn::Shl(hn::Set(di, 2), hn::Sub(long_side, short_side)),
                                hn::Shl(hn::Set(di, 2), hn::Sub(long_side, hn::Max(level, short_side))));
        before = hn::Add(before, hn::IfThenElseZero(is_line, twos));
    }

    const Taps x = taps_along(u, level_width, info, all_repeat);
    const Taps y = taps_along(v, level_height, hn::ShiftRight<kWrapBits>(info), all_repeat);
    const VI start = hn::Add(base_index, before);
    const VI row0 = hn::Add(start, hn::Shl(y.first, level_width));
    const VI row1 = hn::Add(start, hn::Shl(y.second, level_width));

    VU t00, t01, t10, t11;
    if (hn::AllTrue(di, hn::Eq(hn::Add(x.first, one), x.second))) {
        load_pairs(texels, hn::Add(row0, x.first), t00, t01);
        load_pairs(texels, hn::Add(row1, x.first), t10, t11);
    } else {
        t00 = hn::GatherIndex(du, texels, hn::Add(row0, x.first));
        t01 = hn::GatherIndex(du, texels, hn::Add(row0, x.second));
        t10 = hn::GatherIndex(du, texels, hn::Add(row1, x.first));
        t11 = hn::GatherIndex(du, texels, hn::Add(row1, x.second));
    }

    // Two channels at a time in 16 bits: along the row exactly (t * 256), between rows by the high halves.
    const hn::Repartition<std::uint16_t, DU> d16;
    const VU even = hn::Set(du, 0x00FF00FFu);
    const auto twice = [&](VU w) HWY_ATTR { return hn::BitCast(d16, hn::Or(w, hn::ShiftLeft<16>(w))); };
    const auto wx1 = twice(x.weight);
    const auto wx0 = hn::Sub(hn::Set(d16, 256), wx1);
    const auto wy1 = hn::ShiftLeft<8>(twice(y.weight));
    const auto wy0 = hn::Not(wy1);
    const auto blend = [&](VU a00, VU a01, VU a10, VU a11) HWY_ATTR {
        const auto top = hn::Add(hn::Mul(hn::BitCast(d16, a00), wx0), hn::Mul(hn::BitCast(d16, a01), wx1));
        const auto bottom = hn::Add(hn::Mul(hn::BitCast(d16, a10), wx0), hn::Mul(hn::BitCast(d16, a11), wx1));
        return hn::BitCast(du, hn::Add(hn::MulHigh(top, wy0), hn::MulHigh(bottom, wy1)));
    };
    const VU rb = blend(hn::And(t00, even), hn::And(t01, even), hn::And(t10, even), hn::And(t11, even));
    const VU ga = blend(hn::And(hn::ShiftRight<8>(t00), even), hn::And(hn::ShiftRight<8>(t01), even),
                        hn::And(hn::ShiftRight<8>(t10), even), hn::And(hn::ShiftRight<8>(t11), even));
    const VU low = hn::Set(du, 0xFFFFu);
    const VF unit = splat(1.0f / 65278.0f);  // 255 * 256 less what the two high halves drop
    return {hn::Mul(hn::ConvertTo(df, hn::BitCast(di, hn::And(rb, low))), unit),
            hn::Mul(hn::ConvertTo(df, hn::BitCast(di, hn::And(ga, low))), unit),
            hn::Mul(hn::ConvertTo(df, hn::BitCast(di, hn::ShiftRight<16>(rb))), unit)};
}

}  // namespace ff::shading::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
