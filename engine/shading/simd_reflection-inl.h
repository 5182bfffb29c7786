// Per-target SIMD: what mirrors show of the world, looked up in the frame's Reflections. Included by shading_kernel.cpp
// once per Highway target.

#if defined(FF_SHADING_SIMD_REFLECTION_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef FF_SHADING_SIMD_REFLECTION_INL_H_
#undef FF_SHADING_SIMD_REFLECTION_INL_H_
#else
#define FF_SHADING_SIMD_REFLECTION_INL_H_
#endif

#include "engine/shading/reflections.h"
#include "engine/shading/tile_setup-inl.h"

HWY_BEFORE_NAMESPACE();
namespace ff::shading::HWY_NAMESPACE {

/// Light from the world, and its share of what a mirror shows; the rest is sky.
struct Reflected {
    Rgb color;
    VF share;
};

HWY_INLINE Reflected no_reflection() {
    const VF zero = hn::Zero(df);
    return {{zero, zero, zero}, zero};
}

struct ReflectionSample {
    Reflected light;
    MF is_known;
};

/// The four pixels around a point, of those that are known. x, y: in pixels of the image from its first one's centre.
HWY_INLINE ReflectionSample sample_reflections(const Reflections& reflections, VF x, VF y) {
    const Image& image = reflections.image;
    const auto clamped = [](VF at, int size)
                             HWY_ATTR { return hn::Min(hn::Max(at, hn::Zero(df)), splat(float(size) - 1.001f)); };
    const VF inside_x = clamped(x, image.width), inside_y = clamped(y, image.height);
    const VF left = hn::Floor(inside_x), top = hn::Floor(inside_y);
    const VF right_share = hn::Sub(inside_x, left), low_share = hn::Sub(inside_y, top);
    const VI first = hn::Add(hn::Mul(hn::ConvertTo(di, top), hn::Set(di, image.stride)), hn::ConvertTo(di, left));
    const std::uint32_t* const pixels = image.pixels.data();
    const VF one = splat(1.0f), zero = hn::Zero(df);
    Rgb sum = {zero, zero, zero};
    VF known = zero, surface = zero;
    const auto add = [&](int offset, VF weight) HWY_ATTR {
        const VU pixel = hn::GatherIndex(du, pixels + offset, first);
        const VF alpha = hn::ConvertTo(df, hn::BitCast(di, hn::ShiftRight<24>(pixel)));
        known = hn::Add(known, hn::IfThenElseZero(hn::Gt(alpha, splat(float(kReflectsUnknown))), weight));
        const VF hit = hn::IfThenElseZero(hn::Gt(alpha, splat(float(kReflectsSky))), weight);
        surface = hn::Add(surface, hit);
        sum = multiply_add(hit, unpack_color(pixel), sum);
    };
    add(0, hn::Mul(hn::Sub(one, right_share), hn::Sub(one, low_share)));
    add(1, hn::Mul(right_share, hn::Sub(one, low_share)));
    add(image.stride, hn::Mul(hn::Sub(one, right_share), low_share));
    add(image.stride + 1, hn::Mul(right_share, low_share));
    const VF tiny = splat(1e-6f);
    // Filtered as encoded, as textures are.
    const Rgb color = decode_srgb(multiply(hn::Div(one, hn::Max(surface, tiny)), sum));
    return {{color, hn::Div(surface, hn::Max(known, tiny))}, hn::Gt(known, splat(0.2f))};
}

/// What mirrors show, where their normals are bent by waves or are not: the image is looked up where the bent way goes
/// as seen in the flat mirror, nearer to the pixel's own place the nearer to the mirror what stands there is.
/// @param u, v     of the pixels' rays
/// @param to_eye   unit
/// @param f0       reflectance of who looks straight at it
/// @param fades    lanes whose mirrors show less with distance
template <bool kBent>
HWY_INLINE Reflected find_reflected(const ShadeFrame& frame, VF u, VF v, const V3& to_eye, const V3& flat,
                                    const V3& bent, VF f0, VF depth, MF fades) {
    const Reflections& reflections = *frame.settings.reflections;
    const PinholeView& view = frame.view;
    const VF one = splat(1.0f);
    const VF grazing = hn::Sub(one, clamp01(dot(flat, to_eye))), grazing2 = hn::Mul(grazing, grazing);
    const VF reflectance = hn::MulAdd(hn::Sub(one, f0), hn::Mul(hn::Mul(grazing2, grazing2), grazing), f0);
    VF share = clamp01(
        hn::Mul(hn::Sub(reflectance, splat(kLeastReflectance)), splat(1.0f / (kFullReflectance - kLeastReflectance))));
    const VF near = clamp01(hn::NegMulAdd(depth, splat(2.0f / reflections.within_m), splat(2.0f)));
    share = hn::IfThenElse(fades, hn::Mul(share, near), share);
    if (hn::AllFalse(df, hn::Gt(share, hn::Zero(df)))) return no_reflection();

    const float per_step = 1.0f / float(reflections.step);
    const VF scale_x = splat(per_step / view.u_step), scale_y = splat(per_step / view.v_step);
    const float first_x = -0.5f - float(reflections.left) * per_step;
    const float first_y = -0.5f - float(reflections.top) * per_step;
    const VF x = hn::MulAdd(hn::Sub(u, splat(view.u_first)), scale_x, splat(first_x));
    const VF y = hn::MulAdd(hn::Sub(v, splat(view.v_first)), scale_y, splat(first_y));
    ReflectionSample sample = sample_reflections(reflections, x, y);
    if constexpr (kBent) {
        // The bent way's direction, mirrored back by the flat mirror: where the eye would look for it.
        const V3 way = sub(scale(hn::Mul(splat(2.0f), dot(bent, to_eye)), bent), to_eye);
        const V3 seen = sub(way, scale(hn::Mul(splat(2.0f), dot(flat, way)), flat));
        const auto along = [&](int axis) HWY_ATTR { return dot(seen, broadcast(view.world_from_camera[axis])); };
        const VF ahead = hn::Max(hn::Neg(along(2)), splat(0.05f)), inverse = hn::Div(one, ahead);
        const VF moved_x = hn::Mul(hn::NegMulAdd(u, ahead, along(0)), hn::Mul(inverse, scale_x));
        const VF moved_y = hn::Mul(hn::NegMulAdd(v, ahead, along(1)), hn::Mul(inverse, scale_y));
        const auto nearest = [](VF at, int size) HWY_ATTR {
            return hn::ConvertTo(di, hn::Min(hn::Max(hn::Add(at, splat(0.5f)), hn::Zero(df)), splat(float(size - 1))));
        };
        const VI place = hn::Add(hn::Mul(nearest(y, reflections.image.height), hn::Set(di, reflections.image.stride)),
                                 nearest(x, reflections.image.width));
        const VF way_m = hn::GatherIndex(df, reflections.depth, place);
        const VF far =
            hn::IfThenElseZero(sample.is_known, clamp01(hn::Sub(one, hn::Div(depth, hn::Max(way_m, depth)))));
        const ReflectionSample there =
            sample_reflections(reflections, hn::MulAdd(moved_x, far, x), hn::MulAdd(moved_y, far, y));
        sample.light.color = select(there.is_known, there.light.color, sample.light.color);
        sample.light.share = hn::IfThenElse(there.is_known, there.light.share, sample.light.share);
        sample.is_known = hn::Or(sample.is_known, there.is_known);
    }
    sample.light.share = hn::IfThenElseZero(sample.is_known, hn::Mul(sample.light.share, share));
    return sample.light;
}

}  // namespace ff::shading::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
