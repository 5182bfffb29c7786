// Triangles that are set up, into the pixels that they win: the nearest stays, on a tie the smaller (instance,
// triangle); see-through texels win nothing. Compiled once per SIMD target; include after <hwy/highway.h>.
#if defined(FF_BEAM_ROWS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef FF_BEAM_ROWS_INL_H_
#undef FF_BEAM_ROWS_INL_H_
#else
#define FF_BEAM_ROWS_INL_H_
#endif

#include <hwy/highway.h>

#include <bit>
#include <cstdint>

#include "engine/farfield/alpha_test.h"
#include "engine/farfield/beam_setup-inl.h"

HWY_BEFORE_NAMESPACE();
namespace ff::farfield::beam {
namespace HWY_NAMESPACE {
namespace {

// A see-through triangle, looked up once one of its pixels may win.
struct AlphaDraw {
    const scene::StaticScene& scene;
    std::uint32_t instance, triangle;
    const AlphaRays& rays;
    Vec3 corners[3];  // mesh space
    bool is_known = false;
    AlphaSurface surface;
};

HWY_INLINE VI texel_of(VF coordinate, std::uint32_t size, scene::Wrap wrap) {
    VF c = coordinate;
    if (wrap == scene::Wrap::repeat) {
        c = hn::Sub(c, hn::Floor(c));
    } else if (wrap == scene::Wrap::mirror) {
        c = hn::Sub(c, hn::Mul(hn::Set(f, 2.0f), hn::Floor(hn::Mul(hn::Set(f, 0.5f), c))));
        c = hn::IfThenElse(hn::Gt(c, hn::Set(f, 1.0f)), hn::Sub(hn::Set(f, 2.0f), c), c);
    }
    const VF texel = hn::Max(hn::Mul(c, hn::Set(f, float(size))), hn::Zero(f));  // not-a-number becomes 0
    return hn::ConvertTo(si, hn::Min(texel, hn::Set(f, float(size - 1))));
}

// texels_around() of scene/texel_address.h.
struct Taps {
    VI first, second;
    VF weight;
};
HWY_INLINE Taps taps_along(VF coordinate, std::int32_t size, scene::Wrap wrap) {
    VF c = coordinate;
    if (wrap == scene::Wrap::repeat) {
        c = hn::Sub(c, hn::Floor(c));
    } else if (wrap == scene::Wrap::mirror) {
        c = hn::Sub(c, hn::Mul(hn::Set(f, 2.0f), hn::Floor(hn::Mul(hn::Set(f, 0.5f), c))));
    } else {  // not-a-number becomes 0
        c = hn::Min(hn::Max(c, hn::Zero(f)), hn::Set(f, 1.0f));
    }
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

// Switches off the lanes of `win` whose point is see-through: is_opaque_at() of alpha_test.h, operation by operation,
// for a register of pixels. x_at, y_at: the pixels; e: their edge functions.
HWY_NOINLINE MF opaque_lanes(MF win, AlphaDraw& draw, const LeafScratch& s, int i, VF x_at, VF y_at, const VF (&e)[3],
                             VF inverse_depth) {
    if (!draw.is_known) {
        const scene::Instance& instance = draw.scene.instances[draw.instance];
        draw.surface = make_alpha_surface(draw.scene, instance, draw.instance, draw.triangle, draw.corners);
        draw.is_known = true;
    }
    const AlphaSurface& surface = draw.surface;
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
    const VF w0 = hn::Mul(e[0], hn::Set(f, s.weight[0][i])), w1 = hn::Mul(e[1], hn::Set(f, s.weight[1][i]));
    const VF w2 = hn::Mul(e[2], hn::Set(f, s.weight[2][i]));
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
        const VF u = mix(surface.uv[0].x, surface.uv[1].x, surface.uv[2].x);
        const VF v = mix(surface.uv[0].y, surface.uv[1].y, surface.uv[2].y);
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
            const auto* first = surface.texels + scene::level_offset(texture, std::uint32_t(level));
            const VI texel = hn::GatherIndex(si, reinterpret_cast<const std::int32_t*>(first), index);
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

// Draws triangle i of the leaf into the pixels that it wins.
template <bool kAlpha>
HWY_INLINE void draw(const LeafScratch& s, int i, std::uint32_t instance, std::uint32_t triangle, Tile& tile,
                     AlphaDraw* alpha) {
    const VF a0 = hn::Set(f, s.a[0][i]), a1 = hn::Set(f, s.a[1][i]), a2 = hn::Set(f, s.a[2][i]);
    const VF b0 = hn::Set(f, s.b[0][i]), b1 = hn::Set(f, s.b[1][i]), b2 = hn::Set(f, s.b[2][i]);
    const VF c0 = hn::Set(f, s.c[0][i]), c1 = hn::Set(f, s.c[1][i]), c2 = hn::Set(f, s.c[2][i]);
    const VF gx = hn::Set(f, s.gx[i]), gy = hn::Set(f, s.gy[i]), g0 = hn::Set(f, s.g0[i]);
    const VF low = hn::Set(f, s.low[i]), high = hn::Set(f, s.high[i]);
    const auto own_instance = hn::Set(ui, instance), own_triangle = hn::Set(ui, triangle);
    const bool is_thin = s.thin[i] != 0.0f;
    const int first_chunk = s.x0[i] / kLanes * kLanes, last_chunk = s.x1[i];
    for (int row = s.y0[i]; row <= s.y1[i]; ++row) {
        const VF y = hn::Set(f, float(row) - kHalf);
        const VF r0 = hn::MulAdd(b0, y, c0), r1 = hn::MulAdd(b1, y, c1), r2 = hn::MulAdd(b2, y, c2);
        const VF rg = hn::MulAdd(gy, y, g0);
        for (int chunk = first_chunk; chunk <= last_chunk; chunk += kLanes) {
            const VF x = hn::Iota(f, float(chunk) - kHalf);
            const VF e[3] = {hn::MulAdd(a0, x, r0), hn::MulAdd(a1, x, r1), hn::MulAdd(a2, x, r2)};
            // Not-a-number (a sliver's plane) becomes `low`: x86's max returns its second operand then.
            const VF inverse_depth = hn::Min(hn::Max(hn::MulAdd(gx, x, rg), low), high);
            float* best_at = tile.best + row * 16 + chunk;
            const VF best = hn::Load(f, best_at);
            const MF inside = hn::Ge(min3(e[0], e[1], e[2]), hn::Zero(f));
            MF win = hn::And(inside, hn::Ge(inverse_depth, best));
            if (hn::AllFalse(f, win)) continue;
            if (HWY_UNLIKELY(is_thin)) {
                const VF low_x = hn::Set(f, float(s.x0[i]) - kHalf), high_x = hn::Set(f, float(s.x1[i]) - kHalf);
                win = hn::And(win, hn::And(hn::Ge(x, low_x), hn::Le(x, high_x)));
                if (hn::AllFalse(f, win)) continue;
            }
            std::uint32_t* instance_at = tile.instance + row * 16 + chunk;
            std::uint32_t* triangle_at = tile.triangle + row * 16 + chunk;
            const auto old_instance = hn::Load(ui, instance_at), old_triangle = hn::Load(ui, triangle_at);
            const MF tie = hn::And(win, hn::Eq(inverse_depth, best));
            if (HWY_UNLIKELY(!hn::AllFalse(f, tie))) {
                const auto smaller =
                    hn::Or(hn::Lt(own_instance, old_instance),
                           hn::And(hn::Eq(own_instance, old_instance), hn::Lt(own_triangle, old_triangle)));
                win = hn::AndNot(hn::AndNot(hn::RebindMask(f, smaller), tie), win);
            }
            if constexpr (kAlpha) {
                win = opaque_lanes(win, *alpha, s, i, x, y, e, inverse_depth);
                if (hn::AllFalse(f, win)) continue;
            }
            hn::Store(hn::IfThenElse(win, inverse_depth, best), f, best_at);
            const auto win_u = hn::RebindMask(ui, win);
            hn::Store(hn::IfThenElse(win_u, own_instance, old_instance), ui, instance_at);
            hn::Store(hn::IfThenElse(win_u, own_triangle, old_triangle), ui, triangle_at);
            tile.changed = true;
        }
    }
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace ff::farfield::beam
HWY_AFTER_NAMESPACE();

#endif
