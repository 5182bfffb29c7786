#pragma once
// Where a see-through triangle is there: the one rule of all casters, so that they agree in every leaf of every tree.
//
//   alpha = base colour factor * vertex colour * nearest texel of the mip whose texels are as large as the ray's
//           footprint on the triangle, but of no mip with less than 64 texels: those cannot hold a coverage any more
//           (one texel is all or nothing), and distant trees would lose all leaves at once
//   masked:  opaque where alpha >= cutoff; foliage is looked up where wind has moved its picture (math/leaf_sway.h)
//   blended, nearer to the eye than PinholeView::blend_within_m:
//            opaque where it is solid, alpha being 1 in all four texels around; elsewhere not there at all, being a
//            transparent layer (layer_finder.h)
//   blended, farther away:
//            opaque where alpha >= a threshold hashed from (instance, triangle, texel), so that coverage is right on
//            average and nothing flickers (Wyman, McGuire, "Hashed Alpha Testing", I3D 2017)

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>

#include "engine/math/leaf_sway.h"
#include "engine/scene/static_scene.h"
#include "engine/scene/texel_address.h"

namespace ff::farfield {

/// What the test reads of one triangle of one instance.
struct AlphaSurface {
    Vec2 uv[3];
    float alpha[3]{1.0f, 1.0f, 1.0f};         ///< vertex colour times base colour factor
    float cutoff = 0.0f;                      ///< masked only
    float texels_per_m = 0.0f;                ///< of mip 0, along one side, in the world
    float sway_uv_per_m = 0.0f;               ///< texture widths a metre; 0: no wind moves it
    const scene::Texture* texture = nullptr;  ///< none: the factors alone
    std::uint32_t last_level = 0;             ///< the coarsest mip that still holds a coverage
    const std::uint32_t* texels = nullptr;    ///< of mip 0
    bool is_see_through = false;              ///< else every point is opaque
    bool is_blended = false;
    std::uint32_t seed = 0;  ///< of the hashed threshold
};

/// @param instance_id  only names the hash; `instance` may be a dynamic one.
/// @param corners      the triangle's, mesh space: casters have them at hand, and positions are seldom in the cache
[[nodiscard]] AlphaSurface make_alpha_surface(const scene::StaticScene& scene, const scene::Instance& instance,
                                              std::uint32_t instance_id, std::uint32_t triangle,
                                              const Vec3 (&corners)[3]);
/// The same with the corners from the scene.
[[nodiscard]] AlphaSurface make_alpha_surface(const scene::StaticScene& scene, const scene::Instance& instance,
                                              std::uint32_t instance_id, std::uint32_t triangle);

/// The last level of at least 64 texels; 0 for textures that have none.
[[nodiscard]] inline std::uint32_t last_alpha_level(const scene::Texture& texture) {
    constexpr int kLogTexels = 6;
    const int log_area = std::bit_width(texture.width) + std::bit_width(texture.height) - 2;
    return std::uint32_t(std::max(0, log_area - kLogTexels) / 2);
}

/// The mip level for a ray that is `footprint_m` wide where it hits: floor(log2(texels under it)), 0 for a footprint of
/// 0, whole octaves so that every caster finds the same.
[[nodiscard]] inline std::uint32_t alpha_level(const AlphaSurface& surface, float footprint_m) {
    const float texels = std::max(footprint_m * surface.texels_per_m, 1.0f);
    const auto octave = (std::bit_cast<std::uint32_t>(texels) >> 23) - 127u;
    return std::min(octave, surface.last_level);
}

[[nodiscard]] inline float hashed_threshold(std::uint32_t seed, std::uint32_t x, std::uint32_t y) {
    std::uint32_t h = seed ^ (x * 0x9E3779B1u) ^ (y * 0x85EBCA77u);
    h = (h ^ (h >> 15)) * 0x2C1B3C6Du;
    h = (h ^ (h >> 12)) * 0x297A2D39u;
    h ^= h >> 15;
    return float((h >> 8) + 1u) * (1.0f / 16777216.0f);  // (0, 1]
}

/// Alphas nearer to 0 or 1 than this, half a step of 8 bits, are 0 or 1.
inline constexpr float kAlphaStep = 0.5f / 255.0f;

/// Whether a blended surface hides what is behind it, filtered or not. Any float is answered.
[[nodiscard]] inline bool is_solid_at(const AlphaSurface& surface, float b1, float b2, float footprint_m) {
    const float b0 = 1.0f - b1 - b2;
    const float factor = surface.alpha[0] * b0 + surface.alpha[1] * b1 + surface.alpha[2] * b2;
    if (!(factor > 1.0f - kAlphaStep)) return false;
    if (surface.texture == nullptr) return true;
    const scene::Texture& texture = *surface.texture;
    const Vec2 uv = surface.uv[0] * b0 + surface.uv[1] * b1 + surface.uv[2] * b2;
    const std::uint32_t level = alpha_level(surface, footprint_m);
    const std::uint32_t width = std::max(1u, texture.width >> level), height = std::max(1u, texture.height >> level);
    const scene::TexelPair x = scene::texels_around(uv.x, width, texture.wrap_u);
    const scene::TexelPair y = scene::texels_around(uv.y, height, texture.wrap_v);
    const std::uint32_t* first = surface.texels + scene::level_offset(texture, level);
    const std::uint32_t *upper = first + std::size_t(y.first) * width, *lower = first + std::size_t(y.second) * width;
    return ((upper[x.first] & upper[x.second] & lower[x.first] & lower[x.second]) >> 24) == 255u;
}

/// Whether a hit belongs to a transparent layer, unless it is solid. A distance, not a depth along the view axis: it
/// does not change as the viewer turns, so that panoramas may hold what lies beyond.
/// @param distance_m  from the eye to the hit
/// @param within_m    PinholeView::blend_within_m
[[nodiscard]] inline bool is_in_layer(const AlphaSurface& surface, float distance_m, float within_m) {
    return surface.is_blended && distance_m < within_m;
}

/// Where a surface is hit, for wind to know.
struct SwayPlace {
    const LeafSway* sway = nullptr;  ///< nullptr or none: leaves stand still
    Vec3 from_eye{0.0f};             ///< metres, in the sway's axes
};

/// Whether the point with barycentrics (1 - b1 - b2, b1, b2) is there. Any float is answered.
/// @param footprint_m  width of the ray at the hit, metres: depth * PinholeView::pixel_angle(); 0 for a bare ray.
/// @param in_layer     is_in_layer() of the hit
[[nodiscard]] inline bool is_opaque_at(const AlphaSurface& surface, float b1, float b2, float footprint_m,
                                       bool in_layer = false, const SwayPlace& place = {}) {
    if (!surface.is_see_through) return true;
    if (in_layer) return is_solid_at(surface, b1, b2, footprint_m);
    const float b0 = 1.0f - b1 - b2;
    float alpha = surface.alpha[0] * b0 + surface.alpha[1] * b1 + surface.alpha[2] * b2;
    std::uint32_t x, y;
    if (surface.texture != nullptr) {
        const scene::Texture& texture = *surface.texture;
        Vec2 uv = surface.uv[0] * b0 + surface.uv[1] * b1 + surface.uv[2] * b2;
        if (surface.sway_uv_per_m > 0.0f && place.sway != nullptr && !place.sway->is_none())
            uv += leaf_shift(*place.sway, uv, surface.sway_uv_per_m, place.from_eye);
        const std::uint32_t level = alpha_level(surface, footprint_m);
        const std::uint32_t width = std::max(1u, texture.width >> level);
        x = scene::wrap_texel(uv.x, width, texture.wrap_u);
        y = scene::wrap_texel(uv.y, std::max(1u, texture.height >> level), texture.wrap_v);
        const std::uint32_t texel = surface.texels[scene::level_offset(texture, level) + std::size_t(y) * width + x];
        alpha *= float(texel >> 24) * (1.0f / 255.0f);
    } else {
        x = scene::wrap_texel(b1, 64, scene::Wrap::clamp);
        y = scene::wrap_texel(b2, 64, scene::Wrap::clamp);
    }
    return alpha >= (surface.is_blended ? hashed_threshold(surface.seed, x, y) : surface.cutoff);
}

}  // namespace ff::farfield
