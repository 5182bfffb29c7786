// Per-target SIMD: what a ray sees that leaves the world.

#if defined(FF_SHADING_SIMD_SKY_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef FF_SHADING_SIMD_SKY_INL_H_
#undef FF_SHADING_SIMD_SKY_INL_H_
#else
#define FF_SHADING_SIMD_SKY_INL_H_
#endif

#include "engine/shading/simd_color-inl.h"

HWY_BEFORE_NAMESPACE();
namespace ff::shading::HWY_NAMESPACE {

/// The gradient without sun at a unit direction's height.
HWY_INLINE Rgb sky_gradient(const ShadingUniforms& uniforms, VF y) {
    const VF up = hn::Max(y, hn::Zero(df));
    const VF rise = hn::Mul(up, hn::Sub(splat(2.0f), up));
    const VF down = hn::Min(hn::Mul(hn::Max(hn::Neg(y), hn::Zero(df)), splat(kHazeRate)), splat(1.0f));
    const VF sink = hn::Mul(down, hn::Sub(splat(2.0f), down));
    const Rgb horizon = splat(uniforms.horizon);
    return mix(mix(horizon, splat(uniforms.zenith), rise), splat(uniforms.haze), sink);
}

/// Gradient, glow and disc of the sun. x, y, z: unit direction.
HWY_INLINE Rgb gradient_sky(const ShadingUniforms& uniforms, VF x, VF y, VF z) {
    const VF toward = hn::MulAdd(x, splat(uniforms.to_sun.x),
                                 hn::MulAdd(y, splat(uniforms.to_sun.y), hn::Mul(z, splat(uniforms.to_sun.z))));
    const VF cosine = hn::Max(toward, hn::Zero(df));
    const VF wide = square_times<3>(cosine);  // cos^8
    VF sun = hn::Mul(wide, splat(kSunGlowWide));
    if (!hn::AllFalse(df, hn::Gt(cosine, splat(0.9f)))) {  // else cos^128 < 2e-6
        const VF disc =
            clamp01(hn::Mul(hn::Sub(cosine, splat(kSunDiscEdge)), splat(1.0f / (kSunDiscFull - kSunDiscEdge))));
        sun = hn::MulAdd(square_times<4>(wide), splat(kSunGlowNarrow), sun);  // cos^128
        sun = hn::MulAdd(hn::Mul(disc, disc), splat(kSunDisc), sun);
    }
    // Haze hides the sun below the horizon.
    sun = hn::Mul(sun, clamp01(hn::MulAdd(y, splat(kHazeRate), splat(1.0f))));
    return multiply_add(sun, splat(uniforms.sun_radiance), sky_gradient(uniforms, y));
}

/// atan(a) for a in [0, 1], error below 1e-5. Based on: Abramowitz and Stegun, 4.4.47.
HWY_INLINE VF atan_unit(VF a) {
    const VF square = hn::Mul(a, a);
    VF sum = hn::MulAdd(square, splat(0.0208351f), splat(-0.0851330f));
    sum = hn::MulAdd(square, sum, splat(0.1801410f));
    sum = hn::MulAdd(square, sum, splat(-0.3302995f));
    sum = hn::MulAdd(square, sum, splat(0.9998660f));
    return hn::Mul(a, sum);
}
HWY_INLINE VF atan2_of(VF y, VF x) {
    const VF ax = hn::Abs(x), ay = hn::Abs(y);
    const VF high = hn::Max(hn::Max(ax, ay), splat(1e-30f));
    VF angle = atan_unit(hn::Div(hn::Min(ax, ay), high));
    angle = hn::IfThenElse(hn::Gt(ay, ax), hn::Sub(splat(1.57079633f), angle), angle);
    angle = hn::IfThenElse(hn::Lt(x, hn::Zero(df)), hn::Sub(splat(3.14159265f), angle), angle);
    return hn::CopySign(angle, y);
}

/// Half floats in the low 16 bits of each lane; sign ignored, infinity becomes 65536.
HWY_INLINE VF float_from_half(VU half) {
    const VU bits = hn::ShiftLeft<13>(hn::And(half, hn::Set(du, 0x7FFFu)));
    return hn::Mul(hn::BitCast(df, bits), splat(0x1p112f));
}

/// Bilinear sample of the equirectangular panorama, linear RGB.
HWY_INLINE Rgb panorama_sky(const scene::Environment& environment, VF x, VF y, VF z) {
    const auto width = std::int32_t(environment.panorama_width), height = std::int32_t(environment.panorama_height);
    // Azimuth from north (-z) to the east (+x); polar angle from the zenith, by atan2 as asin is coarse there.
    const VF azimuth = atan2_of(x, hn::Neg(z));
    const VF polar = atan2_of(hn::Sqrt(hn::MulAdd(x, x, hn::Mul(z, z))), y);
    const VF column = hn::MulAdd(azimuth, splat(0.159154943f * float(width)), splat(-0.5f));
    const VF row = hn::MulAdd(polar, splat(0.318309886f * float(height)), splat(-0.5f));
    const VF column0 = hn::Floor(column), row0 = hn::Floor(row);
    const VF s = hn::Sub(column, column0), t = hn::Sub(row, row0);
    // Columns wrap (azimuth is in [-pi, pi], so one turn is enough), rows end at the poles.
    const auto wrapped = [&](VI i) HWY_ATTR {
        i = hn::Add(i, hn::IfThenElseZero(hn::Lt(i, hn::Zero(di)), hn::Set(di, width)));
        return hn::Min(hn::Max(i, hn::Zero(di)), hn::Set(di, width - 1));
    };
    const auto clamped = [&](VI j) HWY_ATTR { return hn::Min(hn::Max(j, hn::Zero(di)), hn::Set(di, height - 1)); };
    const VI i0 = wrapped(hn::ConvertTo(di, column0));
    const VI i_next = hn::Add(i0, hn::Set(di, 1));
    const VI i1 = hn::IfThenElseZero(hn::Lt(i_next, hn::Set(di, width)), i_next);
    const VI j = hn::ConvertTo(di, row0);
    const VI j0 = clamped(j), j1 = clamped(hn::Add(j, hn::Set(di, 1)));
    // The span is RGBA16F, 8 bytes a texel: two 32-bit words each.
    const auto* words = reinterpret_cast<const std::uint32_t*>(environment.panorama.data());
    const auto fetch = [&](VI column_index, VI row_index) HWY_ATTR {
        const VI word = hn::ShiftLeft<1>(hn::Add(hn::Mul(row_index, hn::Set(di, width)), column_index));
        const VU rg = hn::GatherIndex(du, words, word);
        const VU ba = hn::GatherIndex(du, words + 1, word);
        return Rgb{float_from_half(rg), float_from_half(hn::ShiftRight<16>(rg)), float_from_half(ba)};
    };
    return mix(mix(fetch(i0, j0), fetch(i1, j0), s), mix(fetch(i0, j1), fetch(i1, j1), s), t);
}

/// x, y, z: unit direction, world axes.
HWY_INLINE Rgb sky_color(const ShadingUniforms& uniforms, const scene::Environment& environment, VF x, VF y, VF z) {
    if (uniforms.panorama_size.x > 0.0f) return panorama_sky(environment, x, y, z);
    return gradient_sky(uniforms, x, y, z);
}

}  // namespace ff::shading::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
