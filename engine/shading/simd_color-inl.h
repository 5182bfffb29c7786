// Per-target SIMD: transfer functions and fog. Included by shading_kernel.cpp once per Highway target.

#if defined(FF_SHADING_SIMD_COLOR_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef FF_SHADING_SIMD_COLOR_INL_H_
#undef FF_SHADING_SIMD_COLOR_INL_H_
#else
#define FF_SHADING_SIMD_COLOR_INL_H_
#endif

#include <hwy/highway.h>

#include "engine/shading/shading_model.h"

HWY_BEFORE_NAMESPACE();
namespace ff::shading::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

// At most a tile's row: 4 lanes on SSE4, 8 on AVX2, 16 on AVX-512.
using DF = hn::CappedTag<float, 16>;
using DI = hn::RebindToSigned<DF>;
using DU = hn::RebindToUnsigned<DF>;
using VF = hn::Vec<DF>;
using VI = hn::Vec<DI>;
using VU = hn::Vec<DU>;
using MF = hn::Mask<DF>;

inline constexpr DF df{};
inline constexpr DI di{};
inline constexpr DU du{};

HWY_INLINE VF splat(float x) {
    return hn::Set(df, x);
}

/// 2^23: a float of [0, 2^23) added to it is rounded to an integer in the low bits, cheaper than a conversion that
/// minds overflow.
inline constexpr float kMagic = 8388608.0f;

struct Rgb {
    VF r, g, b;
};

HWY_INLINE Rgb splat(const Vec4& color) {
    return {splat(color.x), splat(color.y), splat(color.z)};
}
HWY_INLINE Rgb multiply(const Rgb& a, const Rgb& b) {
    return {hn::Mul(a.r, b.r), hn::Mul(a.g, b.g), hn::Mul(a.b, b.b)};
}
HWY_INLINE Rgb multiply(VF a, const Rgb& b) {
    return {hn::Mul(a, b.r), hn::Mul(a, b.g), hn::Mul(a, b.b)};
}
/// a * b + c
HWY_INLINE Rgb multiply_add(VF a, const Rgb& b, const Rgb& c) {
    return {hn::MulAdd(a, b.r, c.r), hn::MulAdd(a, b.g, c.g), hn::MulAdd(a, b.b, c.b)};
}
HWY_INLINE Rgb multiply_add(const Rgb& a, const Rgb& b, const Rgb& c) {
    return {hn::MulAdd(a.r, b.r, c.r), hn::MulAdd(a.g, b.g, c.g), hn::MulAdd(a.b, b.b, c.b)};
}
/// a + (b - a) * t
HWY_INLINE Rgb mix(const Rgb& a, const Rgb& b, VF t) {
    return {hn::MulAdd(hn::Sub(b.r, a.r), t, a.r), hn::MulAdd(hn::Sub(b.g, a.g), t, a.g),
            hn::MulAdd(hn::Sub(b.b, a.b), t, a.b)};
}
HWY_INLINE Rgb select(MF mask, const Rgb& yes, const Rgb& no) {
    return {hn::IfThenElse(mask, yes.r, no.r), hn::IfThenElse(mask, yes.g, no.g), hn::IfThenElse(mask, yes.b, no.b)};
}

/// [0, 1]. A NaN becomes 0 on x86, whose maximum takes its second operand then.
HWY_INLINE VF clamp01(VF x) {
    return hn::Min(hn::Max(x, hn::Zero(df)), splat(1.0f));
}

HWY_INLINE VF decode_srgb(VF c) {
    VF sum = hn::MulAdd(c, splat(kDecode[4]), splat(kDecode[3]));
    sum = hn::MulAdd(c, sum, splat(kDecode[2]));
    sum = hn::MulAdd(c, sum, splat(kDecode[1]));
    sum = hn::MulAdd(c, sum, splat(kDecode[0]));
    return hn::Mul(c, sum);
}
HWY_INLINE Rgb decode_srgb(const Rgb& c) {
    return {decode_srgb(c.r), decode_srgb(c.g), decode_srgb(c.b)};
}

/// Linear [0, 1] to 0..255, rounded to nearest, in the low bits of a float of kMagic and something.
HWY_INLINE VU encode_srgb8(VF x) {
    const VF s = hn::Sqrt(x);
    VF sum = hn::MulAdd(s, splat(255.0f * kEncode[4]), splat(255.0f * kEncode[3]));
    sum = hn::MulAdd(s, sum, splat(255.0f * kEncode[2]));
    sum = hn::MulAdd(s, sum, splat(255.0f * kEncode[1]));
    sum = hn::MulAdd(s, sum, splat(255.0f * kEncode[0]));
    const VF dark = hn::Mul(x, splat(255.0f * 12.92f));
    const VF value = hn::IfThenElse(hn::Lt(x, splat(kEncodeLinearEnd)), dark, sum);
    return hn::BitCast(du, hn::Add(value, splat(kMagic)));
}

/// Likewise by the film's curve.
HWY_INLINE VU encode_film8(VF x) {
    const VF s = hn::Sqrt(x);
    VF sum = hn::MulAdd(s, splat(255.0f * kFilm[4]), splat(255.0f * kFilm[3]));
    sum = hn::MulAdd(s, sum, splat(255.0f * kFilm[2]));
    sum = hn::MulAdd(s, sum, splat(255.0f * kFilm[1]));
    sum = hn::MulAdd(s, sum, splat(kMagic + 255.0f * kFilm[0]));
    return hn::BitCast(du, sum);
}

/// Linear RGB of any value to opaque RGBA8, by sRGB or by film.
HWY_INLINE VU encode_pixels(const Rgb& c, bool by_film) {
    VU r, g, b;
    if (by_film) {
        const VF gray = hn::Mul(splat(1.0f - kFilmColor),
                                hn::MulAdd(c.r, splat(kLuminance[0]),
                                           hn::MulAdd(c.g, splat(kLuminance[1]), hn::Mul(c.b, splat(kLuminance[2])))));
        const auto shown = [&](VF x) HWY_ATTR { return encode_film8(clamp01(hn::MulAdd(x, splat(kFilmColor), gray))); };
        r = shown(c.r), g = shown(c.g), b = shown(c.b);
    } else {
        r = encode_srgb8(clamp01(c.r)), g = encode_srgb8(clamp01(c.g)), b = encode_srgb8(clamp01(c.b));
    }
    // What kMagic leaves above the low byte is shifted out, or lies where alpha is 255.
    const VU rg = hn::Or(r, hn::ShiftLeft<8>(g));
    return hn::Or(hn::Or(rg, hn::ShiftLeft<16>(b)), hn::Set(du, 0xFF000000u));
}

/// Bends x above kSoftClipStart so that it reaches 1 with slope 0 at 2 - kSoftClipStart.
HWY_INLINE VF soft_clip(VF x) {
    const VF over = hn::Max(hn::Sub(x, splat(kSoftClipStart)), hn::Zero(df));
    const VF bent = hn::Min(over, splat(2.0f * (1.0f - kSoftClipStart)));
    return hn::NegMulAdd(hn::Mul(bent, bent), splat(kSoftClipScale), hn::Min(x, splat(2.0f - kSoftClipStart)));
}
HWY_INLINE Rgb soft_clip(const Rgb& c) {
    return {soft_clip(c.r), soft_clip(c.g), soft_clip(c.b)};
}

/// exp(-x) for x >= 0, relative error below 1e-4 (four-term minimax of 2^f); 0 for x = +inf.
HWY_INLINE VF exp_negative(VF x) {
    const VF power = hn::Max(hn::Mul(x, splat(-1.44269504f)), splat(-126.0f));
    const VF whole = hn::Floor(power);
    const VF f = hn::Sub(power, whole);
    VF sum = hn::MulAdd(f, splat(0.0135557f), splat(0.0520323f));
    sum = hn::MulAdd(f, sum, splat(0.2413793f));
    sum = hn::MulAdd(f, sum, splat(0.6930321f));
    sum = hn::MulAdd(f, sum, splat(1.0000026f));
    const VI exponent = hn::ShiftLeft<23>(hn::BitCast(di, hn::Add(whole, splat(kMagic + 127.0f))));
    return hn::Mul(sum, hn::BitCast(df, exponent));
}

/// x^(2^n) by repeated squaring.
template <int kSquarings>
HWY_INLINE VF square_times(VF x) {
    for (int i = 0; i < kSquarings; ++i) x = hn::Mul(x, x);
    return x;
}

}  // namespace ff::shading::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
