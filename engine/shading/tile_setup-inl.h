// Per-target SIMD: from the triangles that a tile sees to their records (tile_records.h).

#if defined(FF_SHADING_TILE_SETUP_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef FF_SHADING_TILE_SETUP_INL_H_
#undef FF_SHADING_TILE_SETUP_INL_H_
#else
#define FF_SHADING_TILE_SETUP_INL_H_
#endif

#include "engine/shading/raw_block.h"
#include "engine/shading/simd_color-inl.h"
#include "engine/shading/simd_quads-inl.h"
#include "engine/shading/tile_records.h"

HWY_BEFORE_NAMESPACE();
namespace ff::shading::HWY_NAMESPACE {

struct V3 {
    VF x, y, z;
};
HWY_INLINE VF dot(const V3& a, const V3& b) {
    return hn::MulAdd(a.x, b.x, hn::MulAdd(a.y, b.y, hn::Mul(a.z, b.z)));
}
HWY_INLINE V3 cross(const V3& a, const V3& b) {
    return {hn::Sub(hn::Mul(a.y, b.z), hn::Mul(a.z, b.y)), hn::Sub(hn::Mul(a.z, b.x), hn::Mul(a.x, b.z)),
            hn::Sub(hn::Mul(a.x, b.y), hn::Mul(a.y, b.x))};
}
HWY_INLINE V3 sub(const V3& a, const V3& b) {
    return {hn::Sub(a.x, b.x), hn::Sub(a.y, b.y), hn::Sub(a.z, b.z)};
}
HWY_INLINE V3 scale(VF s, const V3& a) {
    return {hn::Mul(s, a.x), hn::Mul(s, a.y), hn::Mul(s, a.z)};
}
/// Columns a, b, c times (x, y, z).
HWY_INLINE V3 transform(const V3& a, const V3& b, const V3& c, const V3& p) {
    return {hn::MulAdd(a.x, p.x, hn::MulAdd(b.x, p.y, hn::Mul(c.x, p.z))),
            hn::MulAdd(a.y, p.x, hn::MulAdd(b.y, p.y, hn::Mul(c.y, p.z))),
            hn::MulAdd(a.z, p.x, hn::MulAdd(b.z, p.y, hn::Mul(c.z, p.z)))};
}
HWY_INLINE V3 broadcast(const Vec3& p) {
    return {splat(p.x), splat(p.y), splat(p.z)};
}
HWY_INLINE V3 load3(const float (*rows)[kBlock], int lane) {
    return {hn::Load(df, rows[0] + lane), hn::Load(df, rows[1] + lane), hn::Load(df, rows[2] + lane)};
}
/// Unit, or almost 0 where there is no direction.
HWY_INLINE V3 normalized(const V3& a) {
    return scale(hn::Div(splat(1.0f), hn::Sqrt(hn::Max(dot(a, a), splat(1e-36f)))), a);
}

/// Unit normal from octahedral snorm16 (as decode_normal in engine/scene).
HWY_INLINE V3 decode_normal(VI oct) {
    const VF unit = splat(1.0f / 32767.0f);
    VF x = hn::Mul(hn::ConvertTo(df, hn::ShiftRight<16>(hn::ShiftLeft<16>(oct))), unit);
    VF y = hn::Mul(hn::ConvertTo(df, hn::ShiftRight<16>(oct)), unit);
    const VF z = hn::Sub(hn::Sub(splat(1.0f), hn::Abs(x)), hn::Abs(y));
    const VF fold = hn::Max(hn::Neg(z), hn::Zero(df));
    x = hn::Sub(x, hn::CopySign(fold, x));
    y = hn::Sub(y, hn::CopySign(fold, y));
    return normalized({x, y, z});
}

/// Sun and sky on a white diffuse surface of a unit normal.
HWY_INLINE Rgb diffuse_light(const ShadingUniforms& uniforms, VF normal_y, VF sun_cosine) {
    const Rgb slope = multiply_add(normal_y, splat(uniforms.ambient_curve), splat(uniforms.ambient_slope));
    const Rgb sky = multiply_add(normal_y, slope, splat(uniforms.ambient_side));
    return multiply_add(hn::Max(sun_cosine, hn::Zero(df)), splat(uniforms.sun_radiance), sky);
}

HWY_INLINE Rgb unpack_color(VU rgba) {
    const VF unit = splat(1.0f / 255.0f);
    const VU low = hn::Set(du, 255u);
    const auto channel = [&](VU bits)
                             HWY_ATTR { return hn::Mul(hn::ConvertTo(df, hn::BitCast(di, hn::And(bits, low))), unit); };
    return {channel(rgba), channel(hn::ShiftRight<8>(rgba)), channel(hn::ShiftRight<16>(rgba))};
}

/// Columns of the cofactor matrix: takes normals to the world, up to a factor that normalising removes.
struct NormalTransform {
    V3 a, b, c;
    HWY_INLINE explicit NormalTransform(const RawBlock& raw, int lane) {
        const V3 x = load3(raw.world_from_mesh, lane), y = load3(raw.world_from_mesh + 3, lane);
        const V3 z = load3(raw.world_from_mesh + 6, lane);
        a = cross(y, z);
        b = cross(z, x);
        c = cross(x, y);
    }
    HWY_INLINE V3 operator()(const V3& n) const { return transform(a, b, c, n); }
};

HWY_INLINE V3 world_position(const RawBlock& raw, int corner, int lane) {
    const V3 p = transform(load3(raw.world_from_mesh, lane), load3(raw.world_from_mesh + 3, lane),
                           load3(raw.world_from_mesh + 6, lane), load3(raw.position + 3 * corner, lane));
    const V3 offset = load3(raw.offset, lane);
    return {hn::Add(p.x, offset.x), hn::Add(p.y, offset.y), hn::Add(p.z, offset.z)};
}

/// The quads of the full model, for the triangles [lane, lane + Lanes) of a block.
HWY_INLINE void set_up_full(const ShadeFrame& frame, const RawBlock& raw, int lane, float* record) {
    const ShadingUniforms& uniforms = frame.uniforms;
    const V3 p0 = world_position(raw, 0, lane);
    const V3 e1 = sub(world_position(raw, 1, lane), p0), e2 = sub(world_position(raw, 2, lane), p0);

    // Ray o + t d (o = 0) meets p0 + b1 e1 + b2 e2 where b1 S = d . (e2 x p0), b2 S = d . (p0 x e1), S = d . n, all
    // affine in the pixel's (u, v). Based on: Moeller, Trumbore, JGT 1997. Scaled so that n is a unit vector.
    const V3 normal = cross(e1, e2);
    const VF length = hn::Max(hn::Sqrt(dot(normal, normal)), splat(1e-30f));
    const VF inverse = hn::Div(splat(1.0f), length);
    const V3 unit = scale(inverse, normal);
    const V3 right = broadcast(frame.view.world_from_camera[0]), up = broadcast(frame.view.world_from_camera[1]);
    const V3 ahead = broadcast(-frame.view.world_from_camera[2]);
    const auto store_affine = [&](int row, const V3& c, VF last) HWY_ATTR {
        store_quad(record, row, {dot(c, right), dot(c, up), dot(c, ahead), last});
    };
    const VI info = hn::Load(di, raw.info + lane);
    store_affine(kQuadW1, scale(inverse, cross(e2, p0)), hn::BitCast(df, info));
    store_affine(kQuadW2, scale(inverse, cross(p0, e1)), hn::BitCast(df, hn::Load(di, raw.texture + lane)));
    const VF plane = dot(unit, p0);  // signed distance of the plane: depth = plane / S

    const auto has = [&](std::int32_t bit) HWY_ATTR { return hn::RebindMask(df, hn::TestBit(info, hn::Set(di, bit))); };

    // Texture coordinates, and the uv area under a pixel: a pixel's cone is depth * pixel_angle wide and meets the
    // plane at |cos| = |S| / |d|.
    const VF u0 = hn::Load(df, raw.uv[0] + lane), v0 = hn::Load(df, raw.uv[1] + lane);
    const VF du1 = hn::Sub(hn::Load(df, raw.uv[2] + lane), u0), dv1 = hn::Sub(hn::Load(df, raw.uv[3] + lane), v0);
    const VF du2 = hn::Sub(hn::Load(df, raw.uv[4] + lane), u0), dv2 = hn::Sub(hn::Load(df, raw.uv[5] + lane), v0);
    const VF zero = hn::Zero(df);
    const VF uv_area = hn::Abs(hn::Sub(hn::Mul(du1, dv2), hn::Mul(du2, dv1)));
    const VF density = hn::Mul(uv_area, inverse);
    store_quad(record, kQuadU, {u0, du1, du2, hn::IfThenElseZero(has(kLaneSways), hn::Sqrt(density))});
    store_quad(record, kQuadV, {v0, dv1, dv2, zero});
    store_affine(kQuadS, unit, hn::Mul(hn::Mul(plane, plane), hn::Mul(density, splat(uniforms.sun_radiance.w))));

    // The side of the plane that the viewer sees; normals turn to it.
    const VF flip_facing = hn::Xor(hn::And(plane, hn::SignBit(df)), hn::SignBit(df));  // plane < 0: it faces already
    const V3 facing = {hn::Xor(unit.x, flip_facing), hn::Xor(unit.y, flip_facing), hn::Xor(unit.z, flip_facing)};
    const NormalTransform to_world(raw, lane);
    V3 n0 = to_world(decode_normal(hn::Load(di, raw.normal[0] + lane)));

    // Colour factor: times the light already where normals and vertex colours are constant.
    Rgb color = {hn::Load(df, raw.color[0] + lane), hn::Load(df, raw.color[1] + lane),
                 hn::Load(df, raw.color[2] + lane)};
    const Rgb vertex_color = unpack_color(hn::Load(du, raw.vertex_color[0] + lane));
    color = select(has(kLaneVertexColor), color, multiply(color, vertex_color));
    const V3 flat = normalized(n0);
    const VF turn = hn::And(dot(flat, facing), hn::SignBit(df));
    const V3 to_sun = broadcast(Vec3(uniforms.to_sun));
    const Rgb light = diffuse_light(uniforms, hn::Xor(flat.y, turn), hn::Xor(dot(flat, to_sun), turn));
    const MF constant_light = hn::Not(hn::Or(has(kLanePixelLit), has(kLaneUnlit)));
    if (frame.settings.sun_seen != nullptr) {
        const Rgb sky = diffuse_light(uniforms, hn::Xor(flat.y, turn), zero);
        const Rgb shade = select(constant_light, multiply(color, sky), color);
        store_quad(record, kQuadShade, {shade.r, shade.g, shade.b, zero});
    }
    color = select(constant_light, multiply(color, light), color);
    store_quad(record, kQuadColor,
               {color.r, color.g, color.b, hn::BitCast(df, hn::Load(di, raw.emissive_info + lane))});

    if (raw.any_bits & kLanePixelLit) {
        const V3 n1 = to_world(decode_normal(hn::Load(di, raw.normal[1] + lane)));
        const V3 n2 = to_world(decode_normal(hn::Load(di, raw.normal[2] + lane)));
        const VF facing0 = dot(n0, facing);
        store_corners(record, kQuadNormalX, n0.x, n1.x, n2.x, facing0);
        store_corners(record, kQuadNormalY, n0.y, n1.y, n2.y, hn::Sub(dot(n1, facing), facing0));
        store_corners(record, kQuadNormalZ, n0.z, n1.z, n2.z, hn::Sub(dot(n2, facing), facing0));
    }
    if (raw.any_bits & kLaneVertexColor) {
        const Rgb c1 = unpack_color(hn::Load(du, raw.vertex_color[1] + lane));
        const Rgb c2 = unpack_color(hn::Load(du, raw.vertex_color[2] + lane));
        const MF varies = has(kLaneVertexColor);
        const VF one = splat(1.0f);
        const auto channel = [&](int row, VF at0, VF at1, VF at2) HWY_ATTR {
            store_corners(record, row, hn::IfThenElse(varies, at0, one), hn::IfThenElse(varies, at1, one),
                          hn::IfThenElse(varies, at2, one), zero);
        };
        channel(kQuadVertexRed, vertex_color.r, c1.r, c2.r);
        channel(kQuadVertexGreen, vertex_color.g, c1.g, c2.g);
        channel(kQuadVertexBlue, vertex_color.b, c1.b, c2.b);
    }
}

/// The prelit colour: mean base colour in the light on corner 0's normal, turned to the viewer (P1 4.6).
HWY_INLINE void set_up_prelit(const ShadeFrame& frame, const RawBlock& raw, int lane, float* record) {
    const VI info = hn::Load(di, raw.info + lane);
    const NormalTransform to_world(raw, lane);
    const V3 normal = normalized(to_world(decode_normal(hn::Load(di, raw.normal[0] + lane))));
    const VF toward = hn::And(dot(normal, world_position(raw, 0, lane)), hn::SignBit(df));
    const VF flip = hn::Xor(toward, hn::SignBit(df));
    const VF up = hn::Xor(normal.y, flip);
    const VF sun_cosine = hn::Xor(dot(normal, broadcast(Vec3(frame.uniforms.to_sun))), flip);
    const MF unlit = hn::RebindMask(df, hn::TestBit(info, hn::Set(di, kLaneUnlit)));
    const Rgb color = unpack_color(hn::Load(du, raw.prelit + lane));
    const Rgb emissive = {hn::Load(df, raw.prelit_emissive[0] + lane), hn::Load(df, raw.prelit_emissive[1] + lane),
                          hn::Load(df, raw.prelit_emissive[2] + lane)};
    const auto store_lit = [&](int row, VF cosine) HWY_ATTR {
        const Rgb lit = soft_clip(multiply_add(color, diffuse_light(frame.uniforms, up, cosine), emissive));
        const Rgb prelit = select(unlit, multiply_add(splat(1.0f), color, emissive), lit);
        store_quad(record, row, {prelit.r, prelit.g, prelit.b, hn::Zero(df)});
    };
    store_lit(kQuadPrelit, sun_cosine);
    if (frame.settings.sun_seen != nullptr) store_lit(kQuadPrelitShade, hn::Zero(df));
}

}  // namespace ff::shading::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
