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
        draw.surface.value = make_alpha_surface(draw.scene, instance, draw.instance, draw.triangle, corners);
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

// A triangle of a leaf that is set up, as a register of pixels wants it.
struct Drawn {
    VF a[3], b[3], c[3];
    VF gx, gy, g0, low, high;
    bool is_thin;
    HWY_INLINE Drawn(const LeafScratch& s, int i)
        : gx(hn::Set(f, s.gx[i])),
          gy(hn::Set(f, s.gy[i])),
          g0(hn::Set(f, s.g0[i])),
          low(hn::Set(f, s.low[i])),
          high(hn::Set(f, s.high[i])),
          is_thin(s.thin[i] != 0.0f) {
        for (int k = 0; k < 3; ++k) {
            a[k] = hn::Set(f, s.a[k][i]);
            b[k] = hn::Set(f, s.b[k][i]);
            c[k] = hn::Set(f, s.c[k][i]);
        }
    }
};

// Pixels at which a see-through triangle would win if it is there. They wait until they fill a register: a row of
// foliage has four or five, and to ask for their texels costs the same for one and for all lanes.
struct AlphaCandidates {
    const Drawn& drawn;
    AlphaDraw& alpha;
    const LeafScratch& s;
    int i;
    Tile& tile;
    int count = 0;
    bool has_won = false;
    alignas(64) float x[2 * kLanes], y[2 * kLanes];

    HWY_INLINE AlphaCandidates(const Drawn& of, AlphaDraw& draw, const LeafScratch& leaf, int triangle, Tile& into)
        : drawn(of), alpha(draw), s(leaf), i(triangle), tile(into) {}

    HWY_INLINE void add(MF win, VF at_x, VF at_y) {
        hn::StoreU(hn::Compress(at_x, win), f, x + count);
        hn::StoreU(hn::Compress(at_y, win), f, y + count);
        count += int(hn::CountTrue(f, win));
        if (count < kLanes) return;
        settle(kLanes);
        count -= kLanes;
        hn::Store(hn::Load(f, x + kLanes), f, x);
        hn::Store(hn::Load(f, y + kLanes), f, y);
    }

    // The first few win where the triangle is opaque.
    HWY_NOINLINE void settle(int few) {
        const Drawn& d = drawn;
        const VF at_x = hn::Load(f, x), at_y = hn::Load(f, y);
        VF e[3];
        for (int k = 0; k < 3; ++k) e[k] = hn::MulAdd(d.b[k], at_y, hn::MulAdd(d.a[k], at_x, d.c[k]));
        const VF plane = hn::MulAdd(d.gy, at_y, hn::MulAdd(d.gx, at_x, d.g0));
        const VF inverse_depth = hn::Min(hn::Max(plane, d.low), d.high);
        const MF first = hn::FirstN(f, std::size_t(few));
        std::uint32_t won = bits_of(opaque_lanes(first, alpha, s, i, at_x, at_y, e, inverse_depth));
        if (won == 0) return;
        has_won = true;
        const VF half = hn::Set(f, kHalf);
        const VF row = hn::Add(at_y, half), column = hn::Add(at_x, half);
        alignas(64) std::int32_t pixels[kLanes];
        alignas(64) float depths[kLanes];
        hn::Store(hn::ConvertTo(si, hn::MulAdd(row, hn::Set(f, float(kRowStride)), column)), si, pixels);
        hn::Store(inverse_depth, f, depths);
        for (; won != 0; won &= won - 1) {
            const int lane = std::countr_zero(won), pixel = pixels[lane];
            tile.best[pixel] = depths[lane];
            tile.instance[pixel] = alpha.instance;
            tile.triangle[pixel] = alpha.triangle;
        }
    }
};

// Draws a register's columns from `column` on, rows y0..y1; true if a pixel was won. Rows are the inner loop: what
// depends on the column alone is done once.
// @tparam kBehind  only what lies beyond Tile::behind_* counts
// @param see_through  nullptr: it is not; else pixels are left to them, and none is won
template <bool kAlpha, bool kBehind>
HWY_INLINE bool draw_columns(const Drawn& d, int column, int y0, int y1, std::uint32_t instance, std::uint32_t triangle,
                             Tile& tile, AlphaCandidates* see_through, const LeafScratch& s, int i) {
    const VF x = hn::Iota(f, float(column) - kHalf);
    const VF c0 = hn::MulAdd(d.a[0], x, d.c[0]), c1 = hn::MulAdd(d.a[1], x, d.c[1]);
    const VF c2 = hn::MulAdd(d.a[2], x, d.c[2]), g = hn::MulAdd(d.gx, x, d.g0);
    const VF too_near = hn::MulAdd(hn::Set(f, tile.behind_x), x, hn::Set(f, tile.behind_c));
    MF any = hn::MaskFromVec(hn::Zero(f));
    VF y = hn::Set(f, float(y0) - kHalf);
    for (int row = y0; row <= y1; ++row, y = hn::Add(y, hn::Set(f, 1.0f))) {
        const VF e[3] = {hn::MulAdd(d.b[0], y, c0), hn::MulAdd(d.b[1], y, c1), hn::MulAdd(d.b[2], y, c2)};
        // Not-a-number (a sliver's plane) becomes `low`: x86's max returns its second operand then.
        const VF inverse_depth = hn::Min(hn::Max(hn::MulAdd(d.gy, y, g), d.low), d.high);
        const int at = row * kRowStride + column;
        const VF best = hn::LoadU(f, tile.best + at);
        const MF inside = hn::Ge(min3(e[0], e[1], e[2]), hn::Zero(f));
        MF win = hn::And(inside, hn::Ge(inverse_depth, best));
        if constexpr (kBehind)
            win = hn::And(win, hn::Lt(inverse_depth, hn::MulAdd(hn::Set(f, tile.behind_y), y, too_near)));
        if (HWY_UNLIKELY(d.is_thin)) {
            const VF low_x = hn::Set(f, float(s.x0[i]) - kHalf), high_x = hn::Set(f, float(s.x1[i]) - kHalf);
            win = hn::And(win, hn::And(hn::Ge(x, low_x), hn::Le(x, high_x)));
        }
        // Half of the registers win something: to write back what was there is cheaper than to guess.
        if constexpr (kAlpha) {
            if (hn::AllFalse(f, win)) continue;
        }
        const auto own_instance = hn::Set(ui, instance), own_triangle = hn::Set(ui, triangle);
        const auto old_instance = hn::LoadU(ui, tile.instance + at), old_triangle = hn::LoadU(ui, tile.triangle + at);
        const MF tie = hn::And(win, hn::Eq(inverse_depth, best));
        if (HWY_UNLIKELY(!hn::AllFalse(f, tie))) {
            const auto smaller =
                hn::Or(hn::Lt(own_instance, old_instance),
                       hn::And(hn::Eq(own_instance, old_instance), hn::Lt(own_triangle, old_triangle)));
            win = hn::AndNot(hn::AndNot(hn::RebindMask(f, smaller), tie), win);
        }
        if constexpr (kAlpha) {
            see_through->add(win, x, y);
            continue;
        }
        hn::StoreU(hn::IfThenElse(win, inverse_depth, best), f, tile.best + at);
        const auto win_u = hn::RebindMask(ui, win);
        hn::StoreU(hn::IfThenElse(win_u, own_instance, old_instance), ui, tile.instance + at);
        hn::StoreU(hn::IfThenElse(win_u, own_triangle, old_triangle), ui, tile.triangle + at);
        any = hn::Or(any, win);
    }
    return !hn::AllFalse(f, any);
}

// Lanes of a register as a block of pixels, row by row.
template <int kColumns>
struct BlockLanes {
    static constexpr int kRows = kLanes / kColumns;
    static_assert(kRows * kColumns == kLanes && kRows >= 2);
    using Row = hn::CappedTag<float, kColumns>;
    alignas(64) float x[kLanes], y[kLanes];
};
template <int kColumns>
constexpr BlockLanes<kColumns> block_lanes() {
    BlockLanes<kColumns> lanes{};
    for (int lane = 0; lane < kLanes; ++lane) {
        lanes.x[lane] = float(lane % kColumns);
        lanes.y[lane] = float(lane / kColumns);
    }
    return lanes;
}

template <int kColumns>
HWY_INLINE VF load_block(const float* first) {
    constexpr typename BlockLanes<kColumns>::Row row;
    const auto at = [&](int r) HWY_ATTR { return hn::LoadU(row, first + r * kRowStride); };
    if constexpr (BlockLanes<kColumns>::kRows == 2) {
        return hn::Combine(f, at(1), at(0));
    } else {
        const hn::Half<F> half;
        return hn::Combine(f, hn::Combine(half, at(3), at(2)), hn::Combine(half, at(1), at(0)));
    }
}

// Of lanes that are as near as what a block's pixels show, by bits, those whose triangle has the greater name.
template <int kColumns>
HWY_NOINLINE std::uint32_t lost_ties(std::uint32_t tie, int at, std::uint32_t instance, std::uint32_t triangle,
                                     const Tile& tile) {
    std::uint32_t lost = 0;
    for (; tie != 0; tie &= tie - 1) {
        const int lane = std::countr_zero(tie), pixel = at + lane / kColumns * kRowStride + lane % kColumns;
        const std::uint32_t other = tile.instance[pixel];
        const bool is_smaller = instance < other || (instance == other && triangle < tile.triangle[pixel]);
        if (!is_smaller) lost |= tie & (~tie + 1);
    }
    return lost;
}

// As draw_columns(), to the same bits, for a triangle no wider than kColumns: several rows to a register, as most
// triangles are but a few pixels wide.
template <bool kAlpha, bool kBehind, int kColumns>
HWY_INLINE bool draw_narrow(const Drawn& d, int column, int y0, int y1, std::uint32_t instance, std::uint32_t triangle,
                            Tile& tile, AlphaCandidates* see_through, const LeafScratch& s, int i) {
    using Lanes = BlockLanes<kColumns>;
    constexpr typename Lanes::Row row_d;
    constexpr hn::RebindToUnsigned<typename Lanes::Row> row_u;
    static constexpr Lanes kBlock = block_lanes<kColumns>();
    const VF x = hn::Add(hn::Load(f, kBlock.x), hn::Set(f, float(column) - kHalf));
    const VF c0 = hn::MulAdd(d.a[0], x, d.c[0]), c1 = hn::MulAdd(d.a[1], x, d.c[1]);
    const VF c2 = hn::MulAdd(d.a[2], x, d.c[2]), g = hn::MulAdd(d.gx, x, d.g0);
    const VF too_near = hn::MulAdd(hn::Set(f, tile.behind_x), x, hn::Set(f, tile.behind_c));
    bool any = false;
    for (int row = y0; row <= y1; row += Lanes::kRows) {
        const VF y = hn::Add(hn::Load(f, kBlock.y), hn::Set(f, float(row) - kHalf));
        const VF e[3] = {hn::MulAdd(d.b[0], y, c0), hn::MulAdd(d.b[1], y, c1), hn::MulAdd(d.b[2], y, c2)};
        const VF inverse_depth = hn::Min(hn::Max(hn::MulAdd(d.gy, y, g), d.low), d.high);
        const int at = row * kRowStride + column;
        const VF best = load_block<kColumns>(tile.best + at);
        MF win = hn::And(hn::Ge(min3(e[0], e[1], e[2]), hn::Zero(f)), hn::Ge(inverse_depth, best));
        if constexpr (kBehind)
            win = hn::And(win, hn::Lt(inverse_depth, hn::MulAdd(hn::Set(f, tile.behind_y), y, too_near)));
        if (HWY_UNLIKELY(d.is_thin)) {
            const VF low_x = hn::Set(f, float(s.x0[i]) - kHalf), high_x = hn::Set(f, float(s.x1[i]) - kHalf);
            win = hn::And(win, hn::And(hn::Ge(x, low_x), hn::Le(x, high_x)));
        }
        // Rows beyond the last are not the tile's.
        const int lanes = (y1 - row + 1) * kColumns;
        const std::uint32_t rows_left = lanes >= kLanes ? ~0u : (1u << lanes) - 1u;
        std::uint32_t bits = bits_of(win) & rows_left;
        if (bits == 0) continue;
        const std::uint32_t tie = bits & bits_of(hn::Eq(inverse_depth, best));
        if (HWY_UNLIKELY(tie != 0)) bits &= ~lost_ties<kColumns>(tie, at, instance, triangle, tile);
        if (bits == 0) continue;
        if constexpr (kAlpha) {
            see_through->add(mask_of(bits), x, y);
            continue;
        }
        any = true;
        alignas(64) float depths[kLanes];
        hn::Store(inverse_depth, f, depths);
        for (int r = 0; r < Lanes::kRows; ++r, bits >>= kColumns) {
            const std::uint8_t of_row[8] = {std::uint8_t(bits & ((1u << kColumns) - 1u))};
            if (of_row[0] == 0) continue;
            const auto won = hn::LoadMaskBits(row_d, of_row);
            const auto won_u = hn::RebindMask(row_u, won);
            const int to = at + r * kRowStride;
            hn::BlendedStore(hn::Load(row_d, depths + r * kColumns), won, row_d, tile.best + to);
            hn::BlendedStore(hn::Set(row_u, instance), won_u, row_u, tile.instance + to);
            hn::BlendedStore(hn::Set(row_u, triangle), won_u, row_u, tile.triangle + to);
        }
    }
    return any;
}

// First and last pixel centres of the cells' columns and rows.
struct CellCorners {
    alignas(64) float x[2][16], y[2][16];
};
constexpr CellCorners cell_corners() {
    CellCorners corners{};
    for (int cell = 0; cell < kCells * kCells; ++cell) {
        for (int side = 0; side < 2; ++side) {
            corners.x[side][cell] = float(cell % kCells * 8 + side * 7) - kHalf;
            corners.y[side][cell] = float(cell / kCells * 8 + side * 7) - kHalf;
        }
    }
    return corners;
}
constexpr CellCorners kCellCorners = cell_corners();

// Cells that triangle i may win pixels of, as bits: the corner where an edge function or 1/depth is greatest is asked,
// with the very operations of the pixels.
HWY_INLINE std::uint32_t cells_to_draw(const Drawn& d, const LeafScratch& s, int i, const Tile& tile) {
    std::uint32_t cells = 0;
    for (int first = 0; first < kCells * kCells; first += kLanes) {
        const auto most = [&](float slope_x, float slope_y, VF a, VF b, VF c) {
            const VF x = hn::Load(f, kCellCorners.x[slope_x >= 0.0f] + first);
            const VF y = hn::Load(f, kCellCorners.y[slope_y >= 0.0f] + first);
            return hn::MulAdd(b, y, hn::MulAdd(a, x, c));
        };
        const VF inside =
            min3(most(s.a[0][i], s.b[0][i], d.a[0], d.b[0], d.c[0]), most(s.a[1][i], s.b[1][i], d.a[1], d.b[1], d.c[1]),
                 most(s.a[2][i], s.b[2][i], d.a[2], d.b[2], d.c[2]));
        const VF nearest = hn::Min(hn::Max(most(s.gx[i], s.gy[i], d.gx, d.gy, d.g0), d.low), d.high);
        const VF best = hn::Load(f, &tile.cell_best[0][0] + first);
        cells |= bits_of(hn::And(hn::Ge(inside, hn::Zero(f)), hn::Ge(nearest, best))) << first;
    }
    return cells;
}

// Draws triangle i of the leaf into the pixels that it wins; true if any.
template <bool kAlpha, bool kBehind>
HWY_INLINE bool draw_pixels(const Drawn& d, const LeafScratch& s, int i, std::uint32_t instance, std::uint32_t triangle,
                            Tile& tile, AlphaCandidates* see_through) {
    const int x0 = s.x0[i], x1 = s.x1[i], y0 = s.y0[i], y1 = s.y1[i];
    const auto columns = [&](int column, int first_row, int last_row) {
        return draw_columns<kAlpha, kBehind>(d, column, first_row, last_row, instance, triangle, tile, see_through, s,
                                             i);
    };
    if (kLanes >= 8 && x1 - x0 < 4)
        return draw_narrow<kAlpha, kBehind, std::min(4, kLanes / 2)>(d, x0, y0, y1, instance, triangle, tile,
                                                                     see_through, s, i);
    if (kLanes >= 16 && x1 - x0 < 8)
        return draw_narrow<kAlpha, kBehind, std::min(8, kLanes / 2)>(d, x0, y0, y1, instance, triangle, tile,
                                                                     see_through, s, i);
    bool has_won = false;
    if (x1 - x0 < 8) {
        for (int column = x0; column <= x1; column += kLanes) has_won |= columns(column, y0, y1);
        return has_won;
    }
    // Much of a wide triangle's bounds lies outside or behind.
    const std::uint32_t cells = cells_to_draw(d, s, i, tile);
    constexpr int kCellsAtOnce = std::max(1, kLanes / 8);
    for (int row = y0; row <= y1; row = row / 8 * 8 + 8) {
        const std::uint32_t of_row = cells >> row / 8 * kCells;
        for (int column = x0 / 8 * 8; column <= x1; column += kLanes) {
            if ((of_row >> column / 8 & ((1u << kCellsAtOnce) - 1u)) == 0) continue;
            has_won |= columns(column, row, std::min(y1, row / 8 * 8 + 7));
        }
    }
    return has_won;
}

// The same, and notes the cells that have changed.
// @param alpha  of a see-through triangle
template <bool kAlpha, bool kBehind = false>
HWY_INLINE void draw(const LeafScratch& s, int i, std::uint32_t instance, std::uint32_t triangle, Tile& tile,
                     AlphaDraw* alpha) {
    const Drawn d(s, i);
    bool has_won;
    if constexpr (kAlpha) {
        AlphaCandidates candidates(d, *alpha, s, i, tile);
        (void)draw_pixels<true, kBehind>(d, s, i, instance, triangle, tile, &candidates);
        if (candidates.count > 0) candidates.settle(candidates.count);
        has_won = candidates.has_won;
    } else {
        has_won = draw_pixels<false, kBehind>(d, s, i, instance, triangle, tile, nullptr);
    }
    if (has_won) tile.changed_cells |= cells_of(s.x0[i], s.x1[i], s.y0[i], s.y1[i]);
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace ff::farfield::beam
HWY_AFTER_NAMESPACE();

#endif
