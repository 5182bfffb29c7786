// The deferred shading of tiles: collect the triangles of a tile, set each up once, then shade its pixels a vector at a
// time. The model is in README.md; shade_reference.cpp is the same in plain scalar code.

#define HWY_DISABLED_TARGETS HWY_AVX3_DL  // nothing here that AVX-512 proper lacks; a fifth of the build time
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "engine/shading/shading_kernel.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>
//
#include <algorithm>
#include <array>
#include <bit>

#include "engine/math/leaf_sway-inl.h"
#include "engine/shading/lamp_light.h"
#include "engine/shading/shading_kernel.h"
#include "engine/shading/simd_color-inl.h"
#include "engine/shading/simd_reflection-inl.h"
#include "engine/shading/simd_sky-inl.h"
#include "engine/shading/simd_texture-inl.h"
#include "engine/shading/tile_collect-inl.h"
#include "engine/shading/tile_setup-inl.h"

HWY_BEFORE_NAMESPACE();
namespace ff::shading::HWY_NAMESPACE {

/// The records of a vector's pixels: one for all lanes, or one per lane.
template <bool kOneTriangle>
struct Records {
    const float* base;           ///< the record of lane 0; else of offset 0
    const std::int32_t* offset;  ///< per lane, from base

    HWY_INLINE Quad quad(int row) const {
        if constexpr (kOneTriangle) {
            const float* at = base + row;
            return {splat(at[0]), splat(at[1]), splat(at[2]), splat(at[3])};
        }
        return load_quad(base + row, offset);
    }
    /// Union of the lanes' kRowInfo.
    HWY_INLINE std::int32_t info_bits() const {
        const auto of = [&](std::int32_t at) { return std::bit_cast<std::int32_t>(base[at + kRowInfo]); };
        if constexpr (kOneTriangle) return of(0);
        std::int32_t bits = 0;
        for (std::size_t lane = 0; lane < hn::Lanes(df); ++lane) bits |= of(offset[lane]);
        return bits;
    }
};

/// a * u + b * v + c
HWY_INLINE VF affine(const Quad& q, VF u, VF v) {
    return hn::MulAdd(q.a, u, hn::MulAdd(q.b, v, q.c));
}
HWY_INLINE VF interpolated(const Quad& q, VF b1, VF b2) {
    return hn::MulAdd(q.b, b1, hn::MulAdd(q.c, b2, q.a));
}

HWY_INLINE MF has_bit(VI info, std::int32_t bit) {
    return hn::RebindMask(df, hn::TestBit(info, hn::Set(di, bit)));
}

/// Rays of a vector of pixels: direction (u, v, -1) in camera space.
struct Rays {
    VF u, v;
    VF length_squared;  ///< 1 + u^2 + v^2

    /// In world axes; as long as makes them reach a depth of 1.
    HWY_INLINE V3 directions(const PinholeView& view) const {
        return transform(broadcast(view.world_from_camera[0]), broadcast(view.world_from_camera[1]),
                         broadcast(view.world_from_camera[2]), {u, v, splat(-1.0f)});
    }
    /// Unit directions in world axes.
    HWY_INLINE V3 unit_directions(const PinholeView& view) const {
        return scale(hn::Div(splat(1.0f), hn::Sqrt(length_squared)), directions(view));
    }
};

/// A texture per lane, also where the scene has more texels than an int can count: then one texture after the other.
template <bool kOneTriangle>
HWY_INLINE Rgb sample_lanes(const scene::StaticScene& scene, VI texture, VI info, VF u, VF v, VF footprint,
                            bool all_repeat) {
    const std::uint32_t* texels = scene.texels.data();
    if (texel_indices_fit(scene)) [[likely]]
        return sample_texture(texels, texture, info, u, v, footprint, all_repeat);
    Rgb out = {hn::Zero(df), hn::Zero(df), hn::Zero(df)};
    auto left = hn::TestBit(info, hn::Set(di, kLaneTextured));
    while (!hn::AllFalse(di, left)) {
        const std::int32_t id = hn::ExtractLane(texture, std::size_t(hn::FindFirstTrue(di, left)));
        const auto here = hn::And(left, hn::Eq(texture, hn::Set(di, id)));
        const Rgb sample = sample_texture(texels + scene.textures[std::size_t(id)].first_texel, hn::Zero(di), info, u,
                                          v, footprint, all_repeat);
        out = select(hn::RebindMask(df, here), sample, out);
        left = hn::And(left, hn::Not(here));
    }
    return out;
}

struct Surface {
    V3 normal;  ///< unit, faces the viewer
    V3 to_eye;  ///< unit
    Rgb color;  ///< linear
    VF metallic, roughness;
    Rgb sun;              ///< radiance that arrives
    Rgb lamps;            ///< light of lamps on a white surface
    MF has_waves;         ///< what a wave would mirror below the horizon are waves that mirror the sky
    Reflected reflected;  ///< of the world
};

/// Light that leaves a metallic-roughness surface. Sun: GGX, Smith height-correlated, Schlick. Sky: the mirrored
/// direction's gradient with Karis' fit of the split sum.
/// Based on: Walter et al., "Microfacet Models for Refraction", EGSR 2007; Heitz, JCGT 2014; Karis, "Physically Based
/// Shading on Mobile", 2014; glTF 2.0 appendix B.
HWY_INLINE Rgb specular_surface(const ShadingUniforms& uniforms, const Surface& s) {
    const VF one = splat(1.0f), tiny = splat(1e-4f);
    const V3 sun = broadcast(Vec3(uniforms.to_sun));
    const VF sun_cosine = dot(s.normal, sun);
    const VF n_l = hn::Max(sun_cosine, hn::Zero(df));
    const VF n_v = hn::Max(dot(s.normal, s.to_eye), tiny);
    const V3 half = normalized({hn::Add(sun.x, s.to_eye.x), hn::Add(sun.y, s.to_eye.y), hn::Add(sun.z, s.to_eye.z)});
    const VF n_h = clamp01(dot(s.normal, half)), v_h = clamp01(dot(s.to_eye, half));
    const VF rough = hn::Min(hn::Max(s.roughness, splat(kMinRoughness)), one);
    const VF metallic = clamp01(s.metallic);

    const VF alpha = hn::Mul(rough, rough), alpha2 = hn::Mul(alpha, alpha);
    const VF base = hn::MulAdd(hn::Mul(n_h, n_h), hn::Sub(alpha2, one), one);
    const VF keep = hn::Sub(one, alpha2);
    const VF smith = hn::MulAdd(n_l, hn::Sqrt(hn::MulAdd(hn::Mul(n_v, n_v), keep, alpha2)),
                                hn::Mul(n_v, hn::Sqrt(hn::MulAdd(hn::Mul(n_l, n_l), keep, alpha2))));
    // D * V * cos: alpha^2 / (pi base^2) * 0.5 / smith * n_l; times pi, as sun_radiance is radiance / pi already.
    const VF lobe =
        hn::Div(hn::Mul(splat(0.5f), hn::Mul(alpha2, n_l)), hn::Max(hn::Mul(hn::Mul(base, base), smith), splat(1e-9f)));
    const VF grazing = hn::Sub(one, v_h);
    const VF grazing2 = hn::Mul(grazing, grazing);
    const VF schlick = hn::Mul(hn::Mul(grazing2, grazing2), grazing);

    const Rgb f0 = mix({splat(kDielectric), splat(kDielectric), splat(kDielectric)}, s.color, metallic);
    const Rgb fresnel = mix(f0, {one, one, one}, schlick);
    const Rgb diffuse = multiply(hn::Sub(one, metallic), s.color);
    const Rgb around = multiply_add(splat(1.0f), diffuse_light(uniforms, s.normal.y, hn::Zero(df)), s.lamps);
    Rgb out = multiply(diffuse, multiply_add(n_l, s.sun, around));
    out = multiply_add(lobe, multiply(fresnel, s.sun), out);

    // The sky in the mirrored direction, blurred towards the hemisphere's light as roughness grows.
    const VF twice = hn::Mul(splat(2.0f), n_v);
    const V3 mirrored_way = sub(scale(twice, s.normal), s.to_eye);
    const VF mirrored_y = hn::IfThenElse(s.has_waves, hn::Abs(mirrored_way.y), mirrored_way.y);
    const Rgb sky = mirrored_sky(uniforms, mirrored_way.x, mirrored_y, mirrored_way.z);
    const Rgb sharp = mix(sky, s.reflected.color, s.reflected.share);
    const Rgb blurred = diffuse_light(uniforms, mirrored_y, hn::Zero(df));
    const Rgb mirrored = mix(sharp, blurred, rough);
    const VF r0 = hn::Sub(one, rough), r1 = hn::MulAdd(rough, splat(-0.0275f), splat(0.0425f));
    const VF r2 = hn::MulAdd(rough, splat(-0.572f), splat(1.04f)), r3 = hn::MulAdd(rough, splat(0.022f), splat(-0.04f));
    // 2^(-9.28 n_v) = exp(-6.4324 n_v)
    const VF a004 = hn::MulAdd(hn::Min(hn::Mul(r0, r0), exp_negative(hn::Mul(n_v, splat(6.4324059f)))), r0, r1);
    const VF scale_f0 = hn::MulAdd(a004, splat(-1.04f), r2), bias = hn::MulAdd(a004, splat(1.04f), r3);
    const Rgb reflectance = multiply_add(scale_f0, f0, {bias, bias, bias});
    return multiply_add(reflectance, mirrored, out);
}

/// Shares [0, 1] of the sun that a vector of pixels sees.
HWY_INLINE VF load_sun_seen(const std::uint8_t* at) {
    const hn::Rebind<std::uint8_t, DI> bytes;
    return hn::Mul(hn::ConvertTo(df, hn::PromoteTo(di, hn::LoadU(bytes, at))), splat(1.0f / 255.0f));
}

/// A tile's lamps, by their index in ShadeSettings::lamps.
struct TileLamps {
    std::array<std::uint16_t, kMaxTileLamps> index;
    int count = 0;
};

/// Light of a tile's lamps on white surfaces. See lamp_falloff.
/// @param at  relative to the viewer
HWY_INLINE Rgb lamp_light(const ShadeFrame& frame, const TileLamps& lamps, const V3& at, const V3& normal) {
    Rgb sum = {hn::Zero(df), hn::Zero(df), hn::Zero(df)};
    const VF one = splat(1.0f);
    for (int i = 0; i < lamps.count; ++i) {
        const LampLight& lamp = frame.settings.lamps[lamps.index[std::size_t(i)]];
        const V3 toward = sub(broadcast(lamp.position), at);
        const VF distance2 = dot(toward, toward);
        const VF share = hn::Mul(distance2, splat(1.0f / (lamp.radius_m * lamp.radius_m)));
        if (hn::AllFalse(df, hn::Lt(share, one))) continue;
        const VF window = hn::Max(hn::NegMulAdd(share, share, one), hn::Zero(df));
        const VF cosine =
            hn::Div(hn::Max(dot(toward, normal), hn::Zero(df)), hn::Sqrt(hn::Max(distance2, splat(1e-12f))));
        const VF light = hn::Div(hn::Mul(hn::Mul(window, window), cosine), hn::Add(distance2, splat(kLampCore)));
        sum = multiply_add(light, {splat(lamp.strength.x), splat(lamp.strength.y), splat(lamp.strength.z)}, sum);
    }
    return sum;
}

/// Slopes of waves along x and z, and the variance of those that the pixels are too wide to see.
struct Slopes {
    VF x, z, unseen;
};

/// @param at        relative to the viewer
/// @param pixel_m   how wide the pixels are there
/// @param within_m  there are none beyond
HWY_INLINE Slopes wave_slopes(const Waves& waves, const V3& at, VF pixel_m, float within_m) {
    Slopes sum = {hn::Zero(df), hn::Zero(df), hn::Zero(df)};
    constexpr float kFade = 1.0f / (1.0f - kWavesFade);
    const VF near =
        clamp01(hn::NegMulAdd(hn::Sqrt(dot(at, at)), splat(kFade / std::max(within_m, 1e-3f)), splat(kFade)));
    if (hn::AllFalse(df, hn::Gt(near, hn::Zero(df)))) {
        for (const Wave& wave : waves) sum.unseen = hn::Add(sum.unseen, splat(0.5f * wave.slope * wave.slope));
        return sum;
    }
    for (const Wave& wave : waves) {
        constexpr float kPerRadian = 0.159154943f;
        const VF turns = hn::Mul(hn::MulAdd(at.x, splat(wave.x), hn::MulAdd(at.z, splat(wave.z), splat(wave.phase))),
                                 splat(kPerRadian));
        const VF turn = hn::Sub(turns, hn::Floor(hn::Add(turns, splat(0.5f))));  // [-0.5, 0.5]
        // cos(2 pi t) = sin(2 pi (1/4 - |t|)), by its series: error below 2e-4.
        const VF q = hn::Sub(splat(0.25f), hn::Abs(turn)), q2 = hn::Mul(q, q);
        VF sine = hn::MulAdd(q2, splat(-76.70586f), splat(81.60525f));
        sine = hn::MulAdd(q2, sine, splat(-41.34170f));
        sine = hn::Mul(q, hn::MulAdd(q2, sine, splat(6.283185f)));
        const VF wide = clamp01(hn::NegMulAdd(pixel_m, splat(2.0f / (kWaveGone * wave.length_m)), splat(2.0f)));
        const VF seen = hn::Mul(near, wide);
        const VF slope = hn::Mul(hn::Mul(seen, sine), splat(wave.slope * wave.length_m * kPerRadian));
        sum.x = hn::MulAdd(slope, splat(wave.x), sum.x);
        sum.z = hn::MulAdd(slope, splat(wave.z), sum.z);
        sum.unseen =
            hn::MulAdd(hn::NegMulAdd(seen, seen, splat(1.0f)), splat(0.5f * wave.slope * wave.slope), sum.unseen);
    }
    return sum;
}

/// How much of a layer that falls from the sky lies on surfaces of a normal's height.
HWY_INLINE VF lies_on(VF normal_y, float amount, float from, float full) {
    const VF share = clamp01(hn::Mul(hn::Sub(normal_y, splat(from)), splat(1.0f / (full - from))));
    return hn::Mul(share, splat(amount));
}

/// Linear colour of the pixels of a vector before fog.
/// @param depth     of the pixels
/// @param sun_seen  shares, where ShadeSettings::sun_seen is given
template <bool kOneTriangle>
HWY_INLINE Rgb shade_surface(const ShadeFrame& frame, const Records<kOneTriangle>& records, const Rays& rays,
                             const TileLamps& lamps, VF depth, VF sun_seen) {
    const std::int32_t bits = records.info_bits();
    const ShadingUniforms& uniforms = frame.uniforms;
    const Quad quad_s = records.quad(kQuadS);
    const VF s = affine(quad_s, rays.u, rays.v);
    // Edge on or degenerate: any point of the triangle will do.
    const VF safe = hn::IfThenElse(hn::Lt(hn::Abs(s), splat(1e-12f)), splat(1e-12f), s);
    const VF inverse = hn::Div(splat(1.0f), safe);
    const Quad quad1 = records.quad(kQuadW1), quad2 = records.quad(kQuadW2);
    const VF b1 = clamp01(hn::Mul(affine(quad1, rays.u, rays.v), inverse));
    const VF b2 = clamp01(hn::Mul(affine(quad2, rays.u, rays.v), inverse));
    const VI info = hn::BitCast(di, quad1.d), texture = hn::BitCast(di, quad2.d);
    const bool all_repeat = !(bits & kLaneWraps);
    VF u = hn::Zero(df), v = hn::Zero(df), footprint = hn::Zero(df);

    const Quad quad_color = records.quad(kQuadColor);
    Rgb color = {quad_color.a, quad_color.b, quad_color.c};
    if (frame.settings.sun_seen != nullptr) {
        const Quad shade = records.quad(kQuadShade);
        color = mix({shade.a, shade.b, shade.c}, color, sun_seen);
    }
    if (bits & kLaneVertexColor) {
        const Rgb vertex_color = {interpolated(records.quad(kQuadVertexRed), b1, b2),
                                  interpolated(records.quad(kQuadVertexGreen), b1, b2),
                                  interpolated(records.quad(kQuadVertexBlue), b1, b2)};
        color = select(has_bit(info, kLaneVertexColor), multiply(color, vertex_color), color);
    }
    if (bits & (kLaneTextured | kLaneEmissive | kLaneSpecular)) {
        const Quad quad_u = records.quad(kQuadU);
        u = interpolated(quad_u, b1, b2);
        v = interpolated(records.quad(kQuadV), b1, b2);
        if (bits & kLaneSways) {
            const V3 at = scale(depth, rays.directions(frame.view));
            ff::HWY_NAMESPACE::add_leaf_shift(df, frame.view.sway, quad_u.d, at.x, at.y, at.z, u, v);
        }
        const VF inverse2 = hn::Mul(inverse, inverse);
        // Between the cone's long axis (S^-4, blurs walls seen along a street) and its area (S^-3, shimmers there).
        footprint = hn::Mul(hn::Mul(quad_s.d, rays.length_squared),
                            hn::Mul(hn::Mul(inverse2, inverse2), hn::Sqrt(hn::Abs(safe))));
    }
    if (bits & kLaneTextured) {
        const Rgb texel =
            decode_srgb(sample_lanes<kOneTriangle>(frame.scene, texture, info, u, v, footprint, all_repeat));
        const Rgb textured = multiply(color, texel);
        color = kOneTriangle ? textured : select(has_bit(info, kLaneTextured), textured, color);
    }
    const MF unlit = has_bit(info, kLaneUnlit);
    if (bits & kLanePixelLit) {
        const Quad nx = records.quad(kQuadNormalX), ny = records.quad(kQuadNormalY), nz = records.quad(kQuadNormalZ);
        V3 n = normalized({interpolated(nx, b1, b2), interpolated(ny, b1, b2), interpolated(nz, b1, b2)});
        const VF turn = hn::And(interpolated({nx.d, ny.d, nz.d, nz.d}, b1, b2), hn::SignBit(df));
        n = {hn::Xor(n.x, turn), hn::Xor(n.y, turn), hn::Xor(n.z, turn)};
        const V3 flat = n;
        const MF water = has_bit(info, kLaneWater);
        VF unseen = hn::Zero(df);
        if (bits & kLaneWater) {
            const V3 at = scale(depth, rays.directions(frame.view));
            const VF pixel_m = hn::Mul(depth, splat(kWaterStretch * frame.view.pixel_angle()));
            const VF strength = records.quad(kQuadSpecular).a;
            const Slopes slopes = wave_slopes(*frame.settings.waves, at, pixel_m, frame.settings.waves_within_m);
            const V3 bent =
                normalized({hn::NegMulAdd(slopes.x, strength, n.x), n.y, hn::NegMulAdd(slopes.z, strength, n.z)});
            n = {hn::IfThenElse(water, bent.x, n.x), hn::IfThenElse(water, bent.y, n.y),
                 hn::IfThenElse(water, bent.z, n.z)};
            unseen = hn::IfThenElseZero(water, hn::Mul(hn::Mul(strength, strength), slopes.unseen));
        }
        const float snow = frame.settings.snow_cover, wet = frame.settings.wet;
        if (snow > 0.0f) {
            const VF white = splat(kSnowAlbedo);
            color =
                mix(color, {white, white, white}, hn::IfThenZeroElse(water, lies_on(n.y, snow, kSnowFrom, kSnowFull)));
        }
        const VF wetness = wet > 0.0f ? hn::IfThenZeroElse(water, lies_on(n.y, wet, kWetFrom, kWetFull)) : hn::Zero(df);
        if (wet > 0.0f) color = multiply(hn::NegMulAdd(wetness, splat(kWetDarkens), splat(1.0f)), color);
        const VF sun_cosine = dot(n, broadcast(Vec3(uniforms.to_sun)));
        Rgb light = diffuse_light(uniforms, n.y, hn::Mul(sun_cosine, sun_seen));
        Rgb from_lamps = {hn::Zero(df), hn::Zero(df), hn::Zero(df)};
        if (lamps.count > 0) {
            from_lamps = lamp_light(frame, lamps, scale(depth, rays.directions(frame.view)), n);
            light = multiply_add(splat(1.0f), light, from_lamps);
        }
        Rgb lit = multiply(color, light);
        if (wet > 0.0f) {
            const Surface film = {.normal = n,
                                  .to_eye = scale(splat(-1.0f), rays.unit_directions(frame.view)),
                                  .color = color,
                                  .metallic = hn::Zero(df),
                                  .roughness = splat(kWetRoughness),
                                  .sun = multiply(sun_seen, splat(uniforms.sun_radiance)),
                                  .lamps = from_lamps,
                                  .has_waves = hn::Lt(splat(0.0f), splat(-1.0f)),
                                  .reflected = no_reflection()};
            lit = mix(lit, specular_surface(uniforms, film), wetness);
        }
        if (bits & kLaneSpecular) {
            Surface surface;
            surface.normal = n;
            surface.to_eye = scale(splat(-1.0f), rays.unit_directions(frame.view));
            surface.color = color;
            surface.sun = multiply(sun_seen, splat(uniforms.sun_radiance));
            surface.lamps = from_lamps;
            const Quad quad_specular = records.quad(kQuadSpecular);
            surface.metallic = hn::IfThenZeroElse(water, quad_specular.a);
            surface.roughness = quad_specular.b;
            const MF specular = has_bit(info, kLaneSpecular);
            const VI map_info = hn::BitCast(di, quad_specular.c);
            const MF mapped = hn::And(specular, has_bit(map_info, kLaneTextured));
            if (!hn::AllFalse(df, mapped)) {  // glTF: roughness in green, metallic in blue, both linear
                const VI map_lanes = hn::IfThenElseZero(hn::RebindMask(di, mapped), map_info);
                const VI map = hn::IfThenElseZero(hn::RebindMask(di, mapped), hn::BitCast(di, quad_specular.d));
                const Rgb texel = sample_lanes<kOneTriangle>(frame.scene, map, map_lanes, u, v, footprint, all_repeat);
                surface.roughness = hn::IfThenElse(mapped, hn::Mul(surface.roughness, texel.g), surface.roughness);
                surface.metallic = hn::IfThenElse(mapped, hn::Mul(surface.metallic, texel.b), surface.metallic);
            }
            surface.has_waves = water;
            if (bits & kLaneWater) {
                // Slopes too small to see roughen: alpha^2 grows by twice their variance.
                const VF rough2 = hn::Mul(surface.roughness, surface.roughness);
                surface.roughness = hn::Sqrt(hn::Sqrt(hn::MulAdd(rough2, rough2, hn::Add(unseen, unseen))));
            }
            surface.reflected = no_reflection();
            if (bits & kLaneMirror) {
                const MF mirror = has_bit(info, kLaneMirror);
                const VF brightest = hn::Max(hn::Max(color.r, color.g), color.b);
                const VF f0 = hn::MulAdd(surface.metallic, hn::Sub(brightest, splat(kDielectric)), splat(kDielectric));
                const MF fades = has_bit(info, kLaneFades);
                surface.reflected =
                    bits & kLaneWater
                        ? find_reflected<true>(frame, rays.u, rays.v, surface.to_eye, flat, n, f0, depth, fades)
                        : find_reflected<false>(frame, rays.u, rays.v, surface.to_eye, flat, n, f0, depth, fades);
                surface.reflected.share = hn::IfThenElseZero(mirror, surface.reflected.share);
            }
            lit = select(specular, specular_surface(uniforms, surface), lit);
        }
        color = kOneTriangle ? lit : select(has_bit(info, kLanePixelLit), lit, color);
    }
    if (bits & kLaneEmissive) {
        const Quad quad_emissive = records.quad(kQuadEmissive);
        Rgb emissive = {quad_emissive.a, quad_emissive.b, quad_emissive.c};
        const VI map_info = hn::BitCast(di, quad_color.d);
        const MF mapped = hn::And(has_bit(info, kLaneEmissive), has_bit(map_info, kLaneTextured));
        if (!hn::AllFalse(df, mapped)) {
            const VI map_lanes = hn::IfThenElseZero(hn::RebindMask(di, mapped), map_info);
            const VI map = hn::IfThenElseZero(hn::RebindMask(di, mapped), hn::BitCast(di, quad_emissive.d));
            const Rgb texel =
                decode_srgb(sample_lanes<kOneTriangle>(frame.scene, map, map_lanes, u, v, footprint, all_repeat));
            emissive = select(mapped, multiply(emissive, texel), emissive);
        }
        color = multiply_add(splat(1.0f), color, emissive);
    }
    if (!(bits & kLaneUnlit)) return soft_clip(color);
    return select(unlit, color, soft_clip(color));
}

/// Surfaces behind fog or an atmosphere, those within reach of NearAir only where it shows.
HWY_INLINE Rgb behind_air_or_fog(const ShadeFrame& frame, const Rays& rays, const Rgb& color, VF depth, MF is_sky) {
    const VF distance = hn::Mul(depth, hn::Sqrt(rays.length_squared));
    const bool has_atmosphere = frame.uniforms.panorama_size.z > 0.0f;
    MF clear = hn::Lt(distance, splat(frame.near_air.reach_m));
    const bool any_near = !hn::AllFalse(df, clear);
    V3 d = {hn::Zero(df), hn::Zero(df), hn::Zero(df)};
    if (has_atmosphere) d = rays.unit_directions(frame.view);
    if (any_near) {
        clear = needs_no_air(frame.uniforms, frame.near_air, color, distance, d.x, d.y, d.z);
        if (hn::AllTrue(df, hn::Or(clear, is_sky))) return color;
    }
    Rgb seen;
    if (has_atmosphere) {
        seen = behind_air(frame.uniforms, color, distance, d.x, d.y, d.z);
    } else {
        const VF through = exp_negative(hn::Mul(distance, splat(frame.uniforms.to_sun.w)));
        seen = mix(splat(frame.uniforms.horizon), color, through);
    }
    return any_near ? select(clear, color, seen) : seen;
}

/// The set-up of a tile's triangles.
void set_up_triangles(const ShadeFrame& frame, TileNeeds needs, RawBlock& raw, TileScratch& scratch) {
    prefetch_vertices(frame, scratch.names, scratch.count);
    for (int first = 0; first < scratch.count; first += kBlock) {
        const int count = std::min(kBlock, scratch.count - first);
        float* record = scratch.records + record_offset(first);
        load_raw_block(frame, scratch.names + first, count, needs, raw, record);
        for (int lane = 0; lane < count; lane += int(hn::Lanes(df))) {
            if (needs.full) set_up_full(frame, raw, lane, record + lane * kRecordFloats);
            if (needs.prelit) set_up_prelit(frame, raw, lane, record + lane * kRecordFloats);
        }
    }
}

TileNeeds needs_of_tile(const ShadeFrame& frame, int x, int y) {
    if (frame.settings.prelit_beyond_m == std::numeric_limits<float>::infinity()) return {.full = true};
    TileNeeds needs;
    for (int j = 0; j < farfield::kTileSize; ++j) {
        const std::size_t first = frame.visibility.index(x, y + j);
        for (int i = 0; i < farfield::kTileSize; ++i) {
            if (frame.visibility.instance[first + i] == farfield::kSkyInstance) continue;
            const bool far = frame.visibility.depth[first + i] > frame.settings.prelit_beyond_m;
            needs.prelit |= far;
            needs.full |= !far;
        }
    }
    return needs;
}

/// Asks for a row of a tile's pixels. Without this the first touch of each waits for the last-level cache: 16 short
/// rows are too few for the processor's own prefetchers. Rows need not begin with a cache line: what the tile on the
/// left has not touched yet is the line of the row's last pixel.
HWY_INLINE void prefetch_row(const ShadeFrame& frame, const farfield::TileRequest& tile, int row) {
    const std::size_t last = frame.visibility.index(tile.x + farfield::kTileSize - 1, tile.y + row);
    __builtin_prefetch(frame.visibility.instance.data() + last);
    __builtin_prefetch(frame.visibility.triangle.data() + last);
    __builtin_prefetch(frame.visibility.depth.data() + last);
    __builtin_prefetch(frame.out.pixels.data() + last, 1);
}

/// @param next  the tile that comes after it
std::uint64_t shade_tile(const ShadeFrame& frame, const farfield::TileRequest& tile, const farfield::TileRequest& next,
                         RawBlock& raw, TileScratch& scratch) {
    const PinholeView& view = frame.view;
    const int x0 = tile.x, y0 = tile.y;
    const int columns = std::min(farfield::kTileSize, view.width - x0);
    const int row_count = std::min(farfield::kTileSize, view.height - y0);
    if (columns <= 0 || row_count <= 0) return 0;
    std::uint16_t rows[farfield::kTileSize]{};
    std::uint64_t pixels = 0;
    for (int j = 0; j < row_count; ++j) {
        rows[j] = std::uint16_t(tile.rows[j] & (0xFFFFu >> (farfield::kTileSize - columns)));
        pixels += std::uint64_t(std::popcount(rows[j]));
    }
    if (pixels == 0) return 0;

    collect_triangles(frame, x0, y0, rows, scratch);
    TileNeeds needs = needs_of_tile(frame, x0, y0);
    TileLamps lamps;
    if (needs.full) lamps.count = find_tile_lamps(frame.settings.lamps, view, frame.visibility, tile, lamps.index);
    needs.light_by_pixel = lamps.count > 0 || frame.settings.wet > 0.0f || frame.settings.snow_cover > 0.0f;
    set_up_triangles(frame, needs, raw, scratch);

    const int lanes = int(hn::Lanes(df));
    const std::uint32_t lane_bits = lanes == 32 ? 0xFFFFFFFFu : (1u << lanes) - 1u;
    const VF prelit_beyond = splat(frame.settings.prelit_beyond_m);
    const bool has_air = frame.uniforms.panorama_size.z > 0.0f || frame.uniforms.to_sun.w > 0.0f;
    for (int j = 0; j < row_count; ++j) {
        const std::size_t first = frame.visibility.index(x0, y0 + j);
        prefetch_row(frame, next, j);
        const VF v = splat((float(y0 + j) + 0.5f) * view.v_step + view.v_first);
        for (int i = 0; i < farfield::kTileSize; i += lanes) {
            const std::uint32_t wanted = std::uint32_t(rows[j]) >> i & lane_bits;
            if (wanted == 0) continue;
            Rays rays;
            const VF column = hn::Add(hn::Iota(df, float(x0 + i)), splat(0.5f));
            rays.u = hn::MulAdd(column, splat(view.u_step), splat(view.u_first));
            rays.v = v;
            rays.length_squared = hn::MulAdd(rays.u, rays.u, hn::MulAdd(v, v, splat(1.0f)));

            const std::int32_t* offsets = scratch.offset + j * farfield::kTileSize + i;
            const VI offset = hn::Load(di, offsets);
            const auto is_sky = hn::RebindMask(df, hn::Eq(offset, hn::Set(di, kSkyOffset)));
            Rgb color;
            if (hn::AllTrue(df, is_sky)) {
                const V3 d = rays.unit_directions(view);
                color = sky_color(frame.uniforms, frame.scene.environment, d.x, d.y, d.z);
            } else {
                const VF depth = hn::LoadU(df, frame.visibility.depth.data() + first + i);
                const bool one_triangle = hn::AllTrue(di, hn::Eq(offset, hn::Set(di, offsets[0])));
                const Records<true> one = {scratch.records + offsets[0], nullptr};
                const Records<false> many = {scratch.records, offsets};
                const MF far = hn::Gt(depth, prelit_beyond);
                const bool any_far = needs.prelit && !hn::AllFalse(df, far);
                const std::uint8_t* const sun_seen_at = frame.settings.sun_seen;
                const VF sun_seen = sun_seen_at == nullptr ? splat(1.0f) : load_sun_seen(sun_seen_at + first + i);
                color = {hn::Zero(df), hn::Zero(df), hn::Zero(df)};
                if (!any_far || !hn::AllTrue(df, hn::Or(far, is_sky)))
                    color = one_triangle ? shade_surface<true>(frame, one, rays, lamps, depth, sun_seen)
                                         : shade_surface<false>(frame, many, rays, lamps, depth, sun_seen);
                if (any_far) {
                    const auto quad = [&](int row) HWY_ATTR { return one_triangle ? one.quad(row) : many.quad(row); };
                    const Quad lit = quad(kQuadPrelit);
                    Rgb prelit = {lit.a, lit.b, lit.c};
                    if (sun_seen_at != nullptr) {
                        const Quad shade = quad(kQuadPrelitShade);
                        prelit = mix({shade.a, shade.b, shade.c}, prelit, sun_seen);
                    }
                    color = select(far, prelit, color);
                }
                if (has_air) color = behind_air_or_fog(frame, rays, color, depth, is_sky);
                if (!hn::AllFalse(df, is_sky)) {
                    const V3 d = rays.unit_directions(view);
                    color = select(is_sky, sky_color(frame.uniforms, frame.scene.environment, d.x, d.y, d.z), color);
                }
            }
            const VU encoded = encode_pixels(color, frame.uniforms.panorama_size.w > 0.0f);
            std::uint32_t* out =
                frame.out.pixels.data() + std::size_t(y0 + j) * std::size_t(frame.out.stride) + std::size_t(x0 + i);
            if (wanted == lane_bits) {
                hn::StoreU(encoded, du, out);
            } else {
                alignas(64) std::uint32_t lane_pixels[16];
                hn::Store(encoded, du, lane_pixels);
                for (int k = 0; k < lanes; ++k)
                    if (wanted >> k & 1) out[k] = lane_pixels[k];
            }
        }
    }
    return pixels;
}

std::uint64_t shade_batch(const ShadeFrame& frame, std::span<const farfield::TileRequest> tiles, TileScratch& scratch) {
    RawBlock raw{};
    std::uint64_t pixels = 0;
    for (std::size_t i = 0; i < tiles.size(); ++i)
        pixels += shade_tile(frame, tiles[i], tiles[std::min(i + 1, tiles.size() - 1)], raw, scratch);
    return pixels;
}

}  // namespace ff::shading::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace ff::shading {

HWY_EXPORT(shade_batch);

std::uint64_t shade_tile_batch(const ShadeFrame& frame, std::span<const farfield::TileRequest> tiles,
                               TileScratch& scratch) {
    return HWY_DYNAMIC_DISPATCH(shade_batch)(frame, tiles, scratch);
}

}  // namespace ff::shading
#endif
