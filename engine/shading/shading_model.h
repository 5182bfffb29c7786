#pragma once
// The engine's one shading model: its constants, and what it needs of a frame, laid out so that C++ and GLSL read the
// same bytes. engine/shading/README.md has the formulas; shaders/shading.glsl repeats them for the rasteriser.

#include "engine/math/camera.h"
#include "engine/scene/environment.h"
#include "engine/shading/atmosphere.h"

namespace ff::shading {

/// Share of the sky's radiance that reaches a surface facing it: what makes sun and shade differ by about 1:3.
inline constexpr float kSkyLight = 0.55f;
/// Lit colours bend from here and reach white at 2 - kSoftClipStart, so that sunlit walls keep their texture.
inline constexpr float kSoftClipStart = 0.6f;
inline constexpr float kSoftClipScale = 0.25f / (1.0f - kSoftClipStart);

/// sRGB to linear: c * (k0 + c * (k1 + ...)); at most 0.43/255 off once encoded again.
inline constexpr float kDecode[5] = {0.0664250691f, 0.195165952f, 1.76834260f, -1.77607619f, 0.749894059f};
/// Linear to sRGB above kEncodeLinearEnd as a polynomial of sqrt(x), at most 0.2/255 off; below it 12.92 x.
inline constexpr float kEncode[5] = {-0.0370060697f, 1.44790652f, -0.944849486f, 0.842726083f, -0.309520361f};
inline constexpr float kEncodeLinearEnd = 0.0031308f;
/// Likewise for the pictures of an atmosphere, whose light is as measured: a screen, far darker than daylight, needs
/// more contrast and colour than that to look alike (Hunt 1952, Stevens 1963). Film gives contrast by its curve, x^1.25
/// / (0.6 x^1.25 + 0.4) for linear [0, 1], which these are within 4.2/255 of once encoded, and colour by kFilmColor:
/// differences from the luminance grow by so much.
inline constexpr float kFilm[5] = {0.0f, 0.495170f, 4.059123f, -6.399927f, 2.845635f};
inline constexpr float kFilmColor = 1.15f;
inline constexpr float kLuminance[3] = {0.2126f, 0.7152f, 0.0722f};

/// Per unit of a direction's height below the horizon, how fast the sky turns into haze.
inline constexpr float kHazeRate = 8.0f;
/// Sun in the sky, as shares of its radiance: cos^8 and cos^128 around it, and a disc of 0.6 degrees with a soft edge.
inline constexpr float kSunGlowWide = 0.06f;
inline constexpr float kSunGlowNarrow = 0.20f;
inline constexpr float kSunDisc = 4.0f;
inline constexpr float kSunDiscEdge = 0.99988f;  ///< cosine where it begins: 0.9 degrees
inline constexpr float kSunDiscFull = 0.99997f;  ///< and is full: 0.45 degrees
/// 1 + g^2 and 2 g of the haze's phase function (atmosphere.h).
inline constexpr float kHazeSquare = 1.0f + kMieG * kMieG;
inline constexpr float kHazeTwice = 2.0f * kMieG;
/// Aerial perspective: heights above the eye are taken to be within so many scale heights.
inline constexpr float kMaxAirHeights = 8.0f;
/// Wet ground: faces up from this height of the normal on, wholly from the other; darker by so much, and so rough.
inline constexpr float kWetFrom = 0.55f, kWetFull = 0.9f;
inline constexpr float kWetDarkens = 0.45f;
inline constexpr float kWetRoughness = 0.22f;
/// Snow lies likewise, and is so white.
inline constexpr float kSnowFrom = 0.5f, kSnowFull = 0.85f;
inline constexpr float kSnowAlbedo = 0.82f;
/// Reflectance of dielectrics facing the viewer, glTF's.
inline constexpr float kDielectric = 0.04f;
/// Below this a highlight would be a single pixel that flickers.
inline constexpr float kMinRoughness = 0.08f;

/// A frame's light and air as std140 uniforms. Vectors are in world axes, colours linear RGB.
struct alignas(16) ShadingUniforms {
    Vec4 to_sun;         ///< xyz unit; w: fog density per metre
    Vec4 sun_radiance;   ///< w: pixel_angle squared
    Vec4 ambient_side;   ///< light on a surface by its normal's height y: side + y * slope + y^2 * curve
    Vec4 ambient_slope;  //
    Vec4 ambient_curve;  //
    Vec4 horizon;        ///< sky at eye level, and the colour of fog
    Vec4 zenith;         //
    Vec4 haze;           ///< what stands below the horizon where the world ends
    Vec4 panorama_size;  ///< xy: width and height in texels, 0 without one; z: 1 with an atmosphere, else 0;
                         ///< w: likewise, where the picture is encoded by kFilm
    // With an atmosphere (scene::SkyTable):
    Vec4 sunward;   ///< xz: unit, level, towards the sun's azimuth
    Vec4 night;     //
    Vec4 air;       ///< xyz: Rayleigh extinction per metre at the eye
    Vec4 haze_air;  ///< xyz: haze's and fog's
    scene::SkyTable::Row sky_rows[scene::SkyTable::kRows];
};
static_assert(sizeof(ShadingUniforms) == (13 + 4 * scene::SkyTable::kRows) * 16);

/// Where air is so thin that a surface may be shown without it: its colour would change by less than
/// ShadeSettings::air_error. A matter of each pixel's ray and colour alone, so that it is the same whoever shades the
/// pixel, in whichever tile.
///
/// Air mixes a colour c with its own light a by 1 - exp(-x), x the optical depth: each channel changes by at most |a -
/// c| x. As pixels hold it, by sRGB or by film, a channel changes at most kEncodeSlope times as much as the square root
/// of its light. The root of a light y that changes by d changes by at most d / sqrt(y), and by at most sqrt(d). So
/// with e = air_error / kEncodeSlope it is enough that |a - c| x < e max(sqrt(y), e), with the largest |a - c| and x
/// and the smallest y of all channels.
struct NearAir {
    float reach_m = 0.0f;  ///< farther away no colour is shown without air; 0: none ever is
    float clear_m = 0.0f;  ///< e over the optical depth of a metre
    float root = 0.0f;     ///< e
    /// The air's light is at most bright + ahead p in each channel, p the haze's phase function, and at most brightest;
    /// and at least darkest.
    float bright = 0.0f, ahead = 0.0f, brightest = 0.0f, darkest = 0.0f;
    float spread = 0.0f;  ///< film darkens the darkest channel by so much of what the brightest is above it
};
/// |a - c| is never taken to be less: so that what is far away is known at once to need its air.
inline constexpr float kLeastAirContrast = 0.25f;
/// Largest slope of kEncode's, sRGB's and kFilm's values by the square root of linear light.
inline constexpr float kEncodeSlope = 1.52f;

/// @param air_error  as ShadeSettings has it
[[nodiscard]] NearAir make_near_air(const ShadingUniforms& uniforms, float air_error);

/// A colour as pixels hold it, [0, 1]: by sRGB, or by film as uniforms.panorama_size.w says.
/// @param linear  any values
[[nodiscard]] DVec3 encode_color(const DVec3& linear, bool by_film);

[[nodiscard]] ShadingUniforms make_uniforms(const scene::Environment& environment, const PinholeView& view);

}  // namespace ff::shading
