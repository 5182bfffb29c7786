// Which pixels of a register see a see-through triangle: alpha_test.h, operation by operation. Compiled once per SIMD
// target; include after <hwy/highway.h>.
#if defined(FF_BEAM_ALPHA_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef FF_BEAM_ALPHA_INL_H_
#undef FF_BEAM_ALPHA_INL_H_
#else
#define FF_BEAM_ALPHA_INL_H_
#endif

#include <hwy/highway.h>

#include <algorithm>
#include <bit>
#include <cstdint>
#include <new>

#include "engine/farfield/alpha_test.h"
#include "engine/farfield/beam_setup-inl.h"
#include "engine/math/leaf_sway-inl.h"

HWY_BEFORE_NAMESPACE();
namespace ff::farfield::beam {
namespace HWY_NAMESPACE {
namespace {

// Room for a surface that most triangles never need: it is large, so nothing of it is touched before.
struct LateSurface {
    bool is_known = false;
    union {
        AlphaSurface value;
    };
    LateSurface() {}
};

// A see-through triangle of a leaf, looked up once one of its pixels may win.
struct AlphaDraw {
    const scene::StaticScene& scene;
    std::uint32_t instance, triangle;
    const AlphaRays& rays;
    const BvhLeaf& leaf;  // whose i-th triangle it is
    int i;
    LateSurface surface;
};

// A texture coordinate in the first of the periods by which it repeats: one picture, or two where every other is
// mirrored. Those that do not repeat stay as they are.
HWY_INLINE VF in_first_period(VF c, scene::Wrap wrap) {
    if (wrap == scene::Wrap::repeat) return hn::Sub(c, hn::Floor(c));
    if (wrap != scene::Wrap::mirror) return c;
    return hn::Sub(c, hn::Mul(hn::Set(f, 2.0f), hn::Floor(hn::Mul(hn::Set(f, 0.5f), c))));
}

HWY_INLINE VI texel_of(VF coordinate, std::uint32_t size, scene::Wrap wrap) {
    VF c = in_first_period(coordinate, wrap);
    if (wrap == scene::Wrap::mirror) c = hn::IfThenElse(hn::Gt(c, hn::Set(f, 1.0f)), hn::Sub(hn::Set(f, 2.0f), c), c);
    const VF texel = hn::Max(hn::Mul(c, hn::Set(f, float(size))), hn::Zero(f));  // not-a-number becomes 0
    return hn::ConvertTo(si, hn::Min(texel, hn::Set(f, float(size - 1))));
}

// texels_around() of scene/texel_address.h.
struct Taps {
    VI first, second;
    VF weight;
};
HWY_INLINE Taps taps_along(VF coordinate, std::int32_t size, scene::Wrap wrap) {
    VF c = in_first_period(coordinate, wrap);
    if (wrap == scene::Wrap::clamp) c = hn::Min(hn::Max(c, hn::Zero(f)), hn::Set(f, 1.0f));  // not-a-number becomes 0
    const VF at = hn::MulSub(c, hn::Set(f, float(size)), hn::Set(f, 0.5f));
    const VF below = hn::Floor(at);
    const VI texel = hn::ConvertTo(si, below);
    const auto wrapped = [&](VI i) HWY_ATTR {
        const VI last = hn::Set(si, size - 1);
        if (wrap == scene::Wrap::repeat) return hn::And(i, last);
        if (wrap == scene::Wrap::mirror) {
            const VI phase = hn::And(i, hn::Set(si, 2 * size - 1));
            return hn::Min(phase, hn::Sub(hn::Set(si, 2 * size - 1), phase));
        }
        return hn::Min(hn::Max(i, hn::Zero(si)), last);
    };
    return {wrapped(texel), wrapped(hn::Add(texel, hn::Set(si, 1))), hn::Sub(at, below)};
}

HWY_INLINE VF alpha_of(const std::uint32_t* level, VI index) {
    const VI texel = hn::GatherIndex(si, reinterpret_cast<const std::int32_t*>(level), index);
    return hn::ConvertTo(f, hn::BitCast(si, hn::ShiftRight<24>(hn::BitCast(ui, texel))));
}

HWY_INLINE VF threshold_of(std::uint32_t seed, VI x, VI y) {
    auto h = hn::Xor(hn::Set(ui, seed), hn::Xor(hn::Mul(hn::BitCast(ui, x), hn::Set(ui, 0x9E3779B1u)),
                                                hn::Mul(hn::BitCast(ui, y), hn::Set(ui, 0x85EBCA77u))));
    h = hn::Mul(hn::Xor(h, hn::ShiftRight<15>(h)), hn::Set(ui, 0x2C1B3C6Du));
    h = hn::Mul(hn::Xor(h, hn::ShiftRight<12>(h)), hn::Set(ui, 0x297A2D39u));
    h = hn::Xor(h, hn::ShiftRight<15>(h));
    const VI k = hn::Add(hn::BitCast(si, hn::ShiftRight<8>(h)), hn::Set(si, 1));
    return hn::Mul(hn::ConvertTo(f, k), hn::Set(f, 1.0f / 16777216.0f));
}

// level_offset() of scene/texel_address.h: a geometric series while no side is at its last texel.
HWY_INLINE std::size_t offset_of(const scene::Texture& texture, std::uint32_t level) {
    const std::size_t width = texture.width >> level, height = texture.height >> level;
    if (width == 0 || height == 0) return scene::level_offset(texture, level);
    return 4 * (std::size_t(texture.width) * texture.height - width * height) / 3;
}

// Whether the four texels around a point have an alpha of 1.
HWY_INLINE MF all_four_filled(const std::uint32_t* texels, std::int32_t width, VF u, VF v,
                              const scene::Texture& texture, std::int32_t level) {
    const Taps x = taps_along(u, width, texture.wrap_u);
    const Taps y = taps_along(v, std::int32_t(std::max(1u, texture.height >> level)), texture.wrap_v);
    const VI upper = hn::Mul(y.first, hn::Set(si, width)), lower = hn::Mul(y.second, hn::Set(si, width));
    const VF above = hn::Min(alpha_of(texels, hn::Add(upper, x.first)), alpha_of(texels, hn::Add(upper, x.second)));
    const VF below = hn::Min(alpha_of(texels, hn::Add(lower, x.first)), alpha_of(texels, hn::Add(lower, x.second)));
    return hn::Eq(hn::Min(above, below), hn::Set(f, 255.0f));
}

// Squared ratio of distance to depth of the pixels at (x, y).
HWY_INLINE VF squared_length(const AlphaRays& rays, VF x, VF y) {
    const VF u = hn::MulAdd(x, hn::Set(f, rays.u_step), hn::Set(f, rays.u_middle));
    const VF v = hn::MulAdd(y, hn::Set(f, rays.v_step), hn::Set(f, rays.v_middle));
    return hn::MulAdd(u, u, hn::MulAdd(v, v, hn::Set(f, 1.0f)));
}

// is_in_layer() of alpha_test.h for blended hits.
HWY_INLINE MF lanes_in_layer(const AlphaRays& rays, VF x, VF y, VF inverse_depth) {
    const VF within = hn::Mul(inverse_depth, hn::Set(f, rays.blend_within_m));
    return hn::Lt(squared_length(rays, x, y), hn::Mul(within, within));
}

// Where the wind has moved the picture at the pixels (x, y).
HWY_NOINLINE void sway(const AlphaRays& rays, const AlphaSurface& surface, VF x, VF y, VF inverse_depth, VF& u, VF& v) {
    const VF depth = hn::Div(hn::Set(f, 1.0f), inverse_depth);
    const VF across = hn::MulAdd(x, hn::Set(f, rays.u_step), hn::Set(f, rays.u_middle));
    const VF up = hn::MulAdd(y, hn::Set(f, rays.v_step), hn::Set(f, rays.v_middle));
    ff::HWY_NAMESPACE::add_leaf_shift(f, rays.sway, hn::Set(f, surface.sway_uv_per_m), hn::Mul(across, depth),
                                      hn::Mul(up, depth), hn::Neg(depth), u, v);
}

// Switches off the lanes of `win` whose point is see-through: is_opaque_at() of alpha_test.h, operation by operation,
// for a register of pixels. x_at, y_at: the pixels; e: their edge functions.
[[maybe_unused]] HWY_NOINLINE MF opaque_lanes(MF win, AlphaDraw& draw, const LeafScratch& s, int i, VF x_at, VF y_at,
                                              const VF (&e)[3], VF inverse_depth) {
    if (!draw.surface.is_known) {
        const scene::Instance& instance = draw.scene.instances[draw.instance];
        Vec3 corners[3];
        for (int k = 0; k < 3; ++k) {
            const int v = draw.leaf.corner[k][draw.i];
            corners[k] = {draw.leaf.x[v], draw.leaf.y[v], draw.leaf.z[v]};
        }
        new (&draw.surface.value)
            AlphaSurface(make_alpha_surface(draw.scene, instance, draw.instance, draw.triangle, corners));
        draw.surface.is_known = true;
    }
    const AlphaSurface& surface = draw.surface.value;
    if (!surface.is_see_through) return win;
    MF in_layer = hn::MaskFromVec(hn::Zero(f)), solid = win;
    if (surface.is_blended && draw.rays.blend_within_m > 0.0f) {
        in_layer = hn::And(win, lanes_in_layer(draw.rays, x_at, y_at, inverse_depth));
        if (std::max({surface.alpha[0], surface.alpha[1], surface.alpha[2]}) <= 1.0f - kAlphaStep) {  // as most glass
            win = hn::AndNot(in_layer, win);
            in_layer = hn::MaskFromVec(hn::Zero(f));
        }
        if (hn::AllFalse(f, win)) return win;
    }
    // Barycentrics by the edges as they are: of a triangle smaller than a pixel their widening is a good part of a
    // texel.
    const auto weight_of = [&](int k) {
        return hn::Mul(hn::Sub(e[k], hn::Set(f, s.widening[k][i])), hn::Set(f, s.weight[k][i]));
    };
    const VF w0 = weight_of(0), w1 = weight_of(1), w2 = weight_of(2);
    const VF inverse_sum = hn::Div(hn::Set(f, 1.0f), hn::Add(w0, hn::Add(w1, w2)));
    const VF b1 = hn::Mul(w1, inverse_sum), b2 = hn::Mul(w2, inverse_sum);
    const VF b0 = hn::Sub(hn::Sub(hn::Set(f, 1.0f), b1), b2);
    const VF footprint = hn::Div(hn::Set(f, draw.rays.pixel_angle), inverse_depth);
    const auto mix = [&](float v0, float v1, float v2) {
        return hn::Add(hn::Add(hn::Mul(hn::Set(f, v0), b0), hn::Mul(hn::Set(f, v1), b1)), hn::Mul(hn::Set(f, v2), b2));
    };
    VF alpha = mix(surface.alpha[0], surface.alpha[1], surface.alpha[2]);
    solid = hn::Gt(alpha, hn::Set(f, 1.0f - kAlphaStep));
    VI x, y;
    if (surface.texture != nullptr) {
        const scene::Texture& texture = *surface.texture;
        const VF texels = hn::Max(hn::Mul(footprint, hn::Set(f, surface.texels_per_m)), hn::Set(f, 1.0f));
        const VI octave = hn::Sub(hn::ShiftRight<23>(hn::BitCast(si, texels)), hn::Set(si, 127));
        const VI levels = hn::Min(octave, hn::Set(si, std::int32_t(surface.last_level)));
        VF u = mix(surface.uv[0].x, surface.uv[1].x, surface.uv[2].x);
        VF v = mix(surface.uv[0].y, surface.uv[1].y, surface.uv[2].y);
        if (surface.sway_uv_per_m > 0.0f && !draw.rays.sway.is_none())
            sway(draw.rays, surface, x_at, y_at, inverse_depth, u, v);
        // Mostly all pixels are on one level; a register is done level by level.
        alignas(64) std::int32_t level_of[16];
        hn::Store(levels, si, level_of);
        VF texture_alpha = hn::Zero(f);
        x = y = hn::Zero(si);
        for (std::uint32_t left = bits_of(win); left != 0;) {
            const std::int32_t level = level_of[std::countr_zero(left)];
            const MF here = hn::RebindMask(f, hn::Eq(levels, hn::Set(si, level)));
            left &= ~bits_of(here);
            const std::uint32_t width = std::max(1u, texture.width >> level);
            const VI level_x = texel_of(u, width, texture.wrap_u);
            const VI level_y = texel_of(v, std::max(1u, texture.height >> level), texture.wrap_v);
            const VI index = hn::Add(hn::Mul(level_y, hn::Set(si, std::int32_t(width))), level_x);
            const auto* first = surface.texels + offset_of(texture, std::uint32_t(level));
            // Lanes that win nothing ask for the same texel: each of its own would be waited for.
            const VI of_winners = hn::IfThenElseZero(hn::RebindMask(si, hn::And(here, win)), index);
            const VI texel = hn::GatherIndex(si, reinterpret_cast<const std::int32_t*>(first), of_winners);
            const VF level_alpha = hn::ConvertTo(f, hn::BitCast(si, hn::ShiftRight<24>(hn::BitCast(ui, texel))));
            texture_alpha = hn::IfThenElse(here, level_alpha, texture_alpha);
            if (HWY_UNLIKELY(!hn::AllFalse(f, hn::And(here, in_layer)))) {
                const MF filled = all_four_filled(first, std::int32_t(width), u, v, texture, level);
                solid = hn::And(solid, hn::Or(hn::Not(here), filled));
            }
            x = hn::IfThenElse(hn::RebindMask(si, here), level_x, x);
            y = hn::IfThenElse(hn::RebindMask(si, here), level_y, y);
        }
        alpha = hn::Mul(alpha, hn::Mul(texture_alpha, hn::Set(f, 1.0f / 255.0f)));
    } else {
        x = texel_of(b1, 64, scene::Wrap::clamp);
        y = texel_of(b2, 64, scene::Wrap::clamp);
    }
    const VF threshold = surface.is_blended ? threshold_of(surface.seed, x, y) : hn::Set(f, surface.cutoff);
    const MF opaque = hn::Ge(alpha, threshold);
    return hn::And(win, hn::Or(hn::AndNot(in_layer, opaque), hn::And(in_layer, solid)));
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace ff::farfield::beam
HWY_AFTER_NAMESPACE();

#endif
