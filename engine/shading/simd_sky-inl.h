// Per-target SIMD: what a ray sees that leaves the world.

#if defined(FF_SHADING_SIMD_SKY_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef FF_SHADING_SIMD_SKY_INL_H_
#undef FF_SHADING_SIMD_SKY_INL_H_
#else
#define FF_SHADING_SIMD_SKY_INL_H_
#endif

#include "engine/shading/simd_color-inl.h"
#include "engine/shading/simd_quads-inl.h"

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

/// Phase functions and the part of a unit direction towards the sun's azimuth, as scene::SkyTable's light needs them.
struct TowardSun {
    VF cosine, level, rayleigh, mie;

    HWY_INLINE TowardSun(const ShadingUniforms& uniforms, VF x, VF y, VF z) {
        cosine = hn::MulAdd(x, splat(uniforms.to_sun.x),
                            hn::MulAdd(y, splat(uniforms.to_sun.y), hn::Mul(z, splat(uniforms.to_sun.z))));
        level = hn::MulAdd(x, splat(uniforms.sunward.x), hn::Mul(z, splat(uniforms.sunward.z)));
        rayleigh = hn::MulAdd(cosine, cosine, splat(1.0f));
        const VF root = hn::Sqrt(hn::NegMulAdd(cosine, splat(kHazeTwice), splat(kHazeSquare)));
        mie = hn::Div(splat(1.0f), hn::Mul(hn::Mul(root, root), root));
    }
    /// Of a row of scene::SkyTable, which is four vectors.
    HWY_INLINE Rgb light(const Quad& rayleigh0, const Quad& rayleigh_sunward, const Quad& mie0,
                         const Quad& mie_sunward) const {
        const Rgb haze = multiply(mie, multiply_add(level, rgb_of(mie_sunward), rgb_of(mie0)));
        const VF growth = hn::MulAdd(level, mie_sunward.d, splat(1.0f));
        const Rgb again = multiply_add(growth, {rayleigh0.d, rayleigh_sunward.d, mie0.d}, haze);
        return multiply_add(rayleigh, multiply_add(level, rgb_of(rayleigh_sunward), rgb_of(rayleigh0)), again);
    }
    static HWY_INLINE Rgb rgb_of(const Quad& q) { return {q.a, q.b, q.c}; }
};

/// How bright the air's light shows: what is dark as it is, what is very bright saturates.
HWY_INLINE Rgb shown_air(const Rgb& light) {
    const auto shown = [](VF x) HWY_ATTR {
        return hn::Sub(splat(1.0f), exp_negative(hn::MulAdd(hn::Mul(x, x), splat(0.5f), x)));
    };
    return {shown(light.r), shown(light.g), shown(light.b)};
}

/// The sky of an atmosphere without the sun's disc. y: of the unit direction that `toward` is of.
HWY_INLINE Rgb atmosphere_light(const ShadingUniforms& uniforms, const TowardSun& toward, VF y) {
    constexpr int kRows = scene::SkyTable::kRows;
    constexpr int kRowFloats = sizeof(scene::SkyTable::Row) / sizeof(float);
    const VF at = hn::Mul(hn::Sqrt(clamp01(y)), splat(float(kRows - 1)));
    const VF below = hn::Min(hn::Floor(at), splat(float(kRows - 2)));
    const VF t = hn::Sub(at, below);
    alignas(64) std::int32_t offset[16];
    hn::Store(hn::Mul(hn::ConvertTo(di, below), hn::Set(di, kRowFloats)), di, offset);
    const float* rows = &uniforms.sky_rows[0].rayleigh.x;
    const auto mixed = [&](int place) HWY_ATTR {
        const Quad a = load_quad(rows + place, offset), b = load_quad(rows + place + kRowFloats, offset);
        const auto mix_one = [&](VF from, VF to) HWY_ATTR { return hn::MulAdd(hn::Sub(to, from), t, from); };
        return Quad{mix_one(a.a, b.a), mix_one(a.b, b.b), mix_one(a.c, b.c), mix_one(a.d, b.d)};
    };
    Rgb sky = toward.light(mixed(0), mixed(4), mixed(8), mixed(12));
    sky = shown_air(multiply_add(splat(1.0f), splat(uniforms.night), sky));
    const VF down = hn::Min(hn::Mul(hn::Max(hn::Neg(y), hn::Zero(df)), splat(kHazeRate)), splat(1.0f));
    return mix(sky, splat(uniforms.haze), hn::Mul(down, hn::Sub(splat(2.0f), down)));
}

/// The sky of an atmosphere. x, y, z: unit direction.
HWY_INLINE Rgb atmosphere_sky(const ShadingUniforms& uniforms, VF x, VF y, VF z) {
    const TowardSun toward(uniforms, x, y, z);
    const Rgb sky = atmosphere_light(uniforms, toward, y);
    if (hn::AllFalse(df, hn::Gt(toward.cosine, splat(kSunDiscEdge)))) return sky;
    const VF disc =
        clamp01(hn::Mul(hn::Sub(toward.cosine, splat(kSunDiscEdge)), splat(1.0f / (kSunDiscFull - kSunDiscEdge))));
    const VF sun =
        hn::Mul(hn::Mul(hn::Mul(disc, disc), splat(kSunDisc)), clamp01(hn::MulAdd(y, splat(kHazeRate), splat(1.0f))));
    return multiply_add(sun, splat(uniforms.sun_radiance), sky);
}

/// Mean of exp(-x) from 0 to x: density along a ray that climbs x scale heights, over that where it starts.
HWY_INLINE VF mean_density(VF x) {
    const VF high = hn::Min(hn::Abs(x), splat(kMaxAirHeights));
    const VF thinned = exp_negative(high);
    // Too small for the quotient: the first terms of its series.
    const VF series = hn::MulAdd(high, hn::MulAdd(high, splat(1.0f / 6.0f), splat(-0.5f)), splat(1.0f));
    const VF rising = hn::IfThenElse(hn::Lt(high, splat(0.05f)), series,
                                     hn::Div(hn::Sub(splat(1.0f), thinned), hn::Max(high, splat(0.05f))));
    return hn::IfThenElse(hn::Lt(x, hn::Zero(df)), hn::Div(rising, thinned), rising);
}

/// A surface's colour behind the atmosphere. x, y, z: unit direction.
HWY_INLINE Rgb behind_air(const ShadingUniforms& uniforms, const Rgb& color, VF distance_m, VF x, VF y, VF z) {
    const TowardSun toward(uniforms, x, y, z);
    const auto& row = uniforms.sky_rows[0];
    const auto everywhere = [](const Vec4& v) HWY_ATTR { return Quad{splat(v.x), splat(v.y), splat(v.z), splat(v.w)}; };
    Rgb air = toward.light(everywhere(row.rayleigh), everywhere(row.rayleigh_sunward), everywhere(row.mie),
                           everywhere(row.mie_sunward));
    air = shown_air(multiply_add(splat(1.0f), splat(uniforms.night), air));
    const VF climb = hn::Mul(distance_m, y);
    const VF haze = hn::Mul(distance_m, mean_density(hn::Mul(climb, splat(1.0f / kMieHeightM))));
    const VF rayleigh = hn::Mul(distance_m, mean_density(hn::Mul(climb, splat(1.0f / kRayleighHeightM))));
    const auto clear = [&](float rayleigh_per_m, float haze_per_m) HWY_ATTR {
        return exp_negative(hn::MulAdd(rayleigh, splat(rayleigh_per_m), hn::Mul(haze, splat(haze_per_m))));
    };
    const VF r = clear(uniforms.air.x, uniforms.haze_air.x), g = clear(uniforms.air.y, uniforms.haze_air.y),
             b = clear(uniforms.air.z, uniforms.haze_air.z);
    return {hn::MulAdd(hn::Sub(color.r, air.r), r, air.r), hn::MulAdd(hn::Sub(color.g, air.g), g, air.g),
            hn::MulAdd(hn::Sub(color.b, air.b), b, air.b)};
}

/// Lanes whose colours air changes too little to be seen (NearAir). d: unit directions.
HWY_INLINE MF needs_no_air(const ShadingUniforms& uniforms, const NearAir& near, const Rgb& color, VF distance_m, VF x,
                           VF y, VF z) {
    const VF high = hn::Max(hn::Max(color.r, color.g), color.b), low = hn::Min(hn::Min(color.r, color.g), color.b);
    VF bright = splat(near.bright);
    if (near.ahead > 0.0f)
        bright =
            hn::Min(hn::MulAdd(TowardSun(uniforms, x, y, z).mie, splat(near.ahead), bright), splat(near.brightest));
    VF contrast = hn::Max(hn::Sub(bright, low), hn::Sub(high, splat(near.darkest)));
    contrast = hn::Max(contrast, splat(kLeastAirContrast));
    const VF shown = hn::Max(hn::NegMulAdd(hn::Sub(high, low), splat(near.spread), low), hn::Zero(df));
    const VF enough = hn::Mul(splat(near.clear_m), hn::Max(hn::Sqrt(shown), splat(near.root)));
    return hn::And(hn::Lt(distance_m, splat(near.reach_m)), hn::Lt(hn::Mul(distance_m, contrast), enough));
}

/// What a mirror shows of the sky, without sun and panorama. x, y, z: unit direction.
HWY_INLINE Rgb mirrored_sky(const ShadingUniforms& uniforms, VF x, VF y, VF z) {
    if (uniforms.panorama_size.z > 0.0f) return atmosphere_light(uniforms, TowardSun(uniforms, x, y, z), y);
    return sky_gradient(uniforms, y);
}

/// x, y, z: unit direction, world axes.
HWY_INLINE Rgb sky_color(const ShadingUniforms& uniforms, const scene::Environment& environment, VF x, VF y, VF z) {
    if (uniforms.panorama_size.x > 0.0f) return panorama_sky(environment, x, y, z);
    if (uniforms.panorama_size.z > 0.0f) return atmosphere_sky(uniforms, x, y, z);
    return gradient_sky(uniforms, x, y, z);
}

}  // namespace ff::shading::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
