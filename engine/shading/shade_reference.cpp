#include "engine/shading/shade_reference.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/exponential.hpp>
#include <glm/geometric.hpp>
#include <glm/gtc/packing.hpp>
#include <glm/matrix.hpp>

#include "engine/scene/scene_data.h"
#include "engine/shading/reflections.h"
#include "engine/shading/shading_model.h"

namespace ff::shading {
namespace {

using scene::StaticScene;
using DVec2 = glm::dvec2;

double linear_of(double c) {
    return c <= 0.04045 ? c / 12.92 : std::pow((c + 0.055) / 1.055, 2.4);
}
DVec3 linear_of(const DVec3& c) {
    return {linear_of(c.x), linear_of(c.y), linear_of(c.z)};
}
double clamp01(double x) {
    return x > 0.0 ? std::min(x, 1.0) : 0.0;
}
DVec3 unpack(std::uint32_t rgba) {
    return DVec3(rgba & 255u, rgba >> 8 & 255u, rgba >> 16 & 255u) / 255.0;
}
DVec3 soft_clip(const DVec3& c) {
    DVec3 out;
    for (int k = 0; k < 3; ++k) {
        const double bent = std::clamp(c[k] - kSoftClipStart, 0.0, 2.0 * (1.0 - kSoftClipStart));
        out[k] = std::min(c[k], 2.0 - kSoftClipStart) - bent * bent * kSoftClipScale;
    }
    return out;
}

/// A triangle as one pixel sees it.
struct SeenTriangle {
    const scene::Material* material;
    const scene::VertexAttributes* corner[3];
    DVec3 p[3];         ///< relative to the viewer, world axes
    DVec3 n[3];         ///< world, as transformed (not unit)
    double b1, b2;      ///< barycentrics of the pixel, clamped
    double plane;       ///< signed distance of its plane
    double slope;       ///< ray direction (z = -1) on the unit normal
    DVec3 unit_normal;  ///< by winding
    std::size_t index;  ///< in the scene
};

SeenTriangle see(const StaticScene& scene, const scene::Instance& instance, std::uint32_t triangle, const WorldPos& eye,
                 const DVec3& direction) {
    const scene::Mesh& mesh = scene.meshes[instance.mesh];
    SeenTriangle seen;
    seen.index = std::size_t(mesh.first_triangle) + triangle;
    seen.material = &scene.materials[scene.triangle_materials[seen.index]];
    const DMat3 to_world(instance.world_from_mesh);
    const DMat3 normals_to_world(glm::cross(to_world[1], to_world[2]), glm::cross(to_world[2], to_world[0]),
                                 glm::cross(to_world[0], to_world[1]));
    for (int k = 0; k < 3; ++k) {
        const std::size_t vertex = mesh.first_vertex + scene.indices[3 * seen.index + std::size_t(k)];
        seen.corner[k] = &scene.attributes[vertex];
        seen.p[k] = to_world * DVec3(scene.positions[vertex]) + (instance.position - eye);
        seen.n[k] = normals_to_world * DVec3(scene::decode_normal(scene.attributes[vertex].normal_oct));
    }
    const DVec3 e1 = seen.p[1] - seen.p[0], e2 = seen.p[2] - seen.p[0];
    const DVec3 normal = glm::cross(e1, e2);
    const double length = std::max(glm::length(normal), 1e-30);
    seen.unit_normal = normal / length;
    seen.plane = glm::dot(seen.unit_normal, seen.p[0]);
    seen.slope = glm::dot(seen.unit_normal, direction);
    if (std::abs(seen.slope) < 1e-12) seen.slope = 1e-12;
    seen.b1 = clamp01(glm::dot(direction, glm::cross(e2, seen.p[0])) / length / seen.slope);
    seen.b2 = clamp01(glm::dot(direction, glm::cross(seen.p[0], e1)) / length / seen.slope);
    return seen;
}

/// uv^2 per square metre.
double texture_density(const SeenTriangle& seen) {
    const DVec2 a = seen.corner[1]->uv - seen.corner[0]->uv, b = seen.corner[2]->uv - seen.corner[0]->uv;
    const double area = std::max(glm::length(glm::cross(seen.p[1] - seen.p[0], seen.p[2] - seen.p[0])), 1e-30);
    return std::abs(a.x * b.y - a.y * b.x) / area;
}

/// uv^2 that a pixel's ray cone covers on the triangle; its long axis shortened, see README.md.
double footprint_of(const SeenTriangle& seen, const DVec3& direction, double pixel_angle) {
    const double depth = seen.plane / seen.slope;
    const double cosine = seen.slope / glm::length(direction);
    const double width = depth * pixel_angle / cosine;
    return width * width * texture_density(seen) * std::sqrt(std::abs(seen.slope));
}

double lod_of(const scene::Texture& texture, double footprint) {
    return 0.5 * std::log2(footprint * double(texture.width) * double(texture.height));
}

std::int64_t wrapped(std::int64_t i, std::int64_t size, scene::Wrap wrap) {
    if (wrap == scene::Wrap::clamp) return std::clamp<std::int64_t>(i, 0, size - 1);
    const std::int64_t period = wrap == scene::Wrap::mirror ? 2 * size : size;
    i = (i % period + period) % period;
    return i < size ? i : 2 * size - 1 - i;
}

/// Encoded RGB, filtered as encoded.
DVec3 sample(const StaticScene& scene, const scene::Texture& texture, const DVec2& uv, double footprint) {
    const double lod = lod_of(texture, footprint);
    const auto level = std::uint32_t(lod > 0.0 ? std::min(std::floor(lod + 0.5), texture.level_count - 1.0) : 0.0);
    std::size_t first = texture.first_texel;
    for (std::uint32_t l = 0; l < level; ++l)
        first += std::size_t(std::max(1u, texture.width >> l)) * std::max(1u, texture.height >> l);
    const std::int64_t width = std::max(1u, texture.width >> level), height = std::max(1u, texture.height >> level);
    const double x = uv.x * double(width) - 0.5, y = uv.y * double(height) - 0.5;
    const double x0 = std::floor(x), y0 = std::floor(y);
    const auto texel = [&](double i, double j) {
        const std::int64_t column = wrapped(std::int64_t(i), width, texture.wrap_u);
        const std::int64_t row = wrapped(std::int64_t(j), height, texture.wrap_v);
        return unpack(scene.texels[first + std::size_t(row * width + column)]);
    };
    return glm::mix(glm::mix(texel(x0, y0), texel(x0 + 1, y0), x - x0),
                    glm::mix(texel(x0, y0 + 1), texel(x0 + 1, y0 + 1), x - x0), y - y0);
}

DVec3 diffuse_light(const ShadingUniforms& uniforms, const DVec3& normal, double sun_seen) {
    const DVec3 sky = DVec3(uniforms.ambient_side) + normal.y * DVec3(uniforms.ambient_slope) +
                      normal.y * normal.y * DVec3(uniforms.ambient_curve);
    return sky + sun_seen * std::max(glm::dot(normal, DVec3(uniforms.to_sun)), 0.0) * DVec3(uniforms.sun_radiance);
}

DVec3 sky_gradient(const ShadingUniforms& uniforms, double y) {
    const double up = std::max(y, 0.0), down = std::min(std::max(-y, 0.0) * kHazeRate, 1.0);
    const DVec3 sky = glm::mix(DVec3(uniforms.horizon), DVec3(uniforms.zenith), up * (2.0 - up));
    return glm::mix(sky, DVec3(uniforms.haze), down * (2.0 - down));
}

DVec3 panorama_texel(const scene::Environment& environment, std::int64_t i, std::int64_t j) {
    const std::int64_t width = environment.panorama_width, height = environment.panorama_height;
    i = (i % width + width) % width;
    j = std::clamp<std::int64_t>(j, 0, height - 1);
    const std::uint16_t* texel = environment.panorama.data() + 4 * (j * width + i);
    return {glm::unpackHalf1x16(texel[0]), glm::unpackHalf1x16(texel[1]), glm::unpackHalf1x16(texel[2])};
}

/// How bright the air's light shows: what is dark as it is, what is very bright saturates.
DVec3 shown_air(const DVec3& light) {
    return DVec3(1.0) - glm::exp(-light * (1.0 + 0.5 * light));
}

/// The light of two rows of the sky's table, `t` of the way between them; without sun and night.
/// @param d  unit
DVec3 light_of_rows(const ShadingUniforms& uniforms, const scene::SkyTable::Row& a, const scene::SkyTable::Row& b,
                    double t, const DVec3& d) {
    const double h = glm::dot(d, DVec3(uniforms.sunward)), m = glm::dot(d, DVec3(uniforms.to_sun));
    const auto mixed = [&](const Vec4& from, const Vec4& to) { return glm::mix(DVec3(from), DVec3(to), t); };
    return (mixed(a.rayleigh, b.rayleigh) + h * mixed(a.rayleigh_sunward, b.rayleigh_sunward)) * (1.0 + m * m) +
           (mixed(a.mie, b.mie) + h * mixed(a.mie_sunward, b.mie_sunward)) *
               std::pow(double(kHazeSquare) - double(kHazeTwice) * m, -1.5) +
           glm::mix(DVec3(a.again()), DVec3(b.again()), t) *
               (1.0 + h * glm::mix(double(a.again_sunward()), double(b.again_sunward()), t));
}

/// Without the sun's disc. @param d  unit
DVec3 atmosphere_light(const ShadingUniforms& uniforms, const DVec3& d) {
    const double at = std::sqrt(clamp01(d.y)) * (scene::SkyTable::kRows - 1);
    const int i = std::min(int(at), scene::SkyTable::kRows - 2);
    const DVec3 sky = shown_air(light_of_rows(uniforms, uniforms.sky_rows[i], uniforms.sky_rows[i + 1], at - i, d) +
                                DVec3(uniforms.night));
    const double down = std::min(std::max(-d.y, 0.0) * kHazeRate, 1.0);
    return glm::mix(sky, DVec3(uniforms.haze), down * (2.0 - down));
}

/// @param d  unit
DVec3 atmosphere_sky(const ShadingUniforms& uniforms, const DVec3& d) {
    const double disc = clamp01((glm::dot(d, DVec3(uniforms.to_sun)) - kSunDiscEdge) / (kSunDiscFull - kSunDiscEdge));
    return atmosphere_light(uniforms, d) +
           kSunDisc * disc * disc * clamp01(1.0 + d.y * kHazeRate) * DVec3(uniforms.sun_radiance);
}

/// Mean of exp(-x) from 0 to x: density along a ray that climbs x scale heights, over that where it starts.
double mean_density(double x) {
    x = std::clamp(x, -double(kMaxAirHeights), double(kMaxAirHeights));
    return std::abs(x) < 1e-6 ? 1.0 : -std::expm1(-x) / x;
}

/// A surface's colour behind the atmosphere. @param d  unit
DVec3 behind_air(const ShadingUniforms& uniforms, const DVec3& color, double distance_m, const DVec3& d) {
    const DVec3 air =
        shown_air(light_of_rows(uniforms, uniforms.sky_rows[0], uniforms.sky_rows[0], 0.0, d) + DVec3(uniforms.night));
    const double climb = distance_m * d.y;
    const DVec3 depth = distance_m * (DVec3(uniforms.air) * mean_density(climb / kRayleighHeightM) +
                                      DVec3(uniforms.haze_air) * mean_density(climb / kMieHeightM));
    return glm::mix(air, color, glm::exp(-depth));
}

/// Whether air changes a surface's colour too little to be seen. @param d  unit
bool needs_no_air(const ShadingUniforms& uniforms, const NearAir& near, const DVec3& color, double distance_m,
                  const DVec3& d) {
    const double high = std::max({color.x, color.y, color.z}), low = std::min({color.x, color.y, color.z});
    const double phase = std::pow(double(kHazeSquare) - double(kHazeTwice) * glm::dot(d, DVec3(uniforms.to_sun)), -1.5);
    const double bright = std::min(near.bright + near.ahead * phase, double(near.brightest));
    const double contrast = std::max({bright - low, high - near.darkest, double(kLeastAirContrast)});
    const double shown = std::max(low - near.spread * (high - low), 0.0);
    return distance_m < near.reach_m &&
           distance_m * contrast < near.clear_m * std::max(std::sqrt(shown), double(near.root));
}

/// @param d  unit
DVec3 sky_color(const ShadingUniforms& uniforms, const scene::Environment& environment, const DVec3& d) {
    if (uniforms.panorama_size.x > 0.0f) {
        const double column = std::atan2(d.x, -d.z) / (2.0 * kPi) * environment.panorama_width - 0.5;
        const double row = std::acos(std::clamp(d.y, -1.0, 1.0)) / kPi * environment.panorama_height - 0.5;
        const double i = std::floor(column), j = std::floor(row);
        const auto i0 = std::int64_t(i), j0 = std::int64_t(j);
        return glm::mix(
            glm::mix(panorama_texel(environment, i0, j0), panorama_texel(environment, i0 + 1, j0), column - i),
            glm::mix(panorama_texel(environment, i0, j0 + 1), panorama_texel(environment, i0 + 1, j0 + 1), column - i),
            row - j);
    }
    if (uniforms.panorama_size.z > 0.0f) return atmosphere_sky(uniforms, d);
    const double cosine = std::max(glm::dot(d, DVec3(uniforms.to_sun)), 0.0);
    const double disc = clamp01((cosine - kSunDiscEdge) / (kSunDiscFull - kSunDiscEdge));
    const double sun =
        kSunGlowWide * std::pow(cosine, 8.0) + kSunGlowNarrow * std::pow(cosine, 128.0) + kSunDisc * disc * disc;
    return sky_gradient(uniforms, d.y) + sun * clamp01(1.0 + d.y * kHazeRate) * DVec3(uniforms.sun_radiance);
}

/// Light from the world in a mirror, and its share of what that shows.
struct Reflected {
    DVec3 color{0.0};
    double share = 0.0;
};

/// See specular_surface in shading_kernel.cpp for the sources.
DVec3 specular_surface(const ShadingUniforms& uniforms, const DVec3& n, const DVec3& to_eye, const DVec3& color,
                       double metallic, double roughness, double sun_seen, const DVec3& lamps, bool has_waves = false,
                       const Reflected& reflected = {}) {
    const DVec3 sun(uniforms.to_sun);
    const double n_l = std::max(glm::dot(n, sun), 0.0), n_v = std::max(glm::dot(n, to_eye), 1e-4);
    const DVec3 half = glm::normalize(sun + to_eye);
    const double n_h = clamp01(glm::dot(n, half)), v_h = clamp01(glm::dot(to_eye, half));
    const double rough = std::clamp(roughness, double(kMinRoughness), 1.0);
    metallic = clamp01(metallic);
    const double alpha2 = rough * rough * rough * rough;
    const double base = n_h * n_h * (alpha2 - 1.0) + 1.0;
    const double smith =
        n_l * std::sqrt(n_v * n_v * (1.0 - alpha2) + alpha2) + n_v * std::sqrt(n_l * n_l * (1.0 - alpha2) + alpha2);
    const double lobe = 0.5 * alpha2 * n_l / std::max(base * base * smith, 1e-9);
    const DVec3 f0 = glm::mix(DVec3(kDielectric), color, metallic);
    const DVec3 fresnel = glm::mix(f0, DVec3(1.0), std::pow(1.0 - v_h, 5.0));
    const DVec3 lit = (1.0 - metallic) * color * (diffuse_light(uniforms, n, sun_seen) + lamps) +
                      sun_seen * lobe * fresnel * DVec3(uniforms.sun_radiance);

    DVec3 mirrored_way = 2.0 * n_v * n - to_eye;
    if (has_waves) mirrored_way.y = std::abs(mirrored_way.y);
    const double mirrored_y = mirrored_way.y;
    const DVec3 blurred = DVec3(uniforms.ambient_side) + mirrored_y * DVec3(uniforms.ambient_slope) +
                          mirrored_y * mirrored_y * DVec3(uniforms.ambient_curve);
    const DVec3 sky =
        uniforms.panorama_size.z > 0.0f ? atmosphere_light(uniforms, mirrored_way) : sky_gradient(uniforms, mirrored_y);
    const DVec3 mirrored = glm::mix(glm::mix(sky, reflected.color, reflected.share), blurred, rough);
    const double r0 = 1.0 - rough, r1 = 0.0425 - 0.0275 * rough, r2 = 1.04 - 0.572 * rough, r3 = 0.022 * rough - 0.04;
    const double a004 = std::min(r0 * r0, std::exp2(-9.28 * n_v)) * r0 + r1;
    return lit + mirrored * (f0 * (r2 - 1.04 * a004) + DVec3(1.04 * a004 + r3));
}

/// Light of lamps on a white surface. @param at  relative to the viewer
DVec3 lamp_light(std::span<const LampLight> lamps, const DVec3& at, const DVec3& n) {
    DVec3 sum(0.0);
    for (const LampLight& lamp : lamps) {
        const DVec3 toward = DVec3(lamp.position) - at;
        const double distance2 = glm::dot(toward, toward);
        sum += DVec3(lamp.strength) * lamp_falloff(distance2, lamp.radius_m) *
               std::max(0.0, glm::dot(toward, n) / std::sqrt(std::max(distance2, 1e-12)));
    }
    return sum;
}

/// Slopes of waves along x and z, and the variance of those that a pixel is too wide to see.
DVec3 wave_slopes(const Waves& waves, const DVec3& at, double pixel_m, double within_m) {
    DVec3 sum(0.0);
    const double near = clamp01((1.0 - glm::length(at) / std::max(within_m, 1e-3)) / (1.0 - double(kWavesFade)));
    for (const Wave& wave : waves) {
        const double seen = near * clamp01(2.0 - pixel_m * 2.0 / double(kWaveGone * wave.length_m));
        const double slope = double(wave.slope) * seen * std::cos(wave.x * at.x + wave.z * at.z + wave.phase) *
                             wave.length_m / (2.0 * kPi);
        sum += DVec3(slope * wave.x, slope * wave.z, 0.5 * double(wave.slope * wave.slope) * (1.0 - seen * seen));
    }
    return sum;
}

/// The four pixels around a point of the image, of those that are known.
struct ReflectionSample {
    Reflected light;
    bool is_known = false;
};
ReflectionSample sample_reflections(const Reflections& reflections, double x, double y) {
    const Image& image = reflections.image;
    x = std::clamp(x, 0.0, image.width - 1.001);
    y = std::clamp(y, 0.0, image.height - 1.001);
    const int left = int(x), top = int(y);
    double known = 0.0, surface = 0.0;
    DVec3 sum(0.0);
    for (int k = 0; k < 4; ++k) {
        const double weight = (k % 2 ? x - left : 1.0 - (x - left)) * (k / 2 ? y - top : 1.0 - (y - top));
        const std::uint32_t pixel =
            image.pixels[std::size_t(top + k / 2) * std::size_t(image.stride) + std::size_t(left + k % 2)];
        if ((pixel >> 24) > kReflectsUnknown) known += weight;
        if ((pixel >> 24) <= kReflectsSky) continue;
        surface += weight;
        sum += weight * unpack(pixel);
    }
    return {{linear_of(sum / std::max(surface, 1e-6)), surface / std::max(known, 1e-6)}, known > 0.2};
}

/// See find_reflected in simd_reflection-inl.h.
Reflected find_reflected(const Reflections& reflections, const PinholeView& view, const DVec3& direction,
                         const DVec3& flat, const DVec3& bent, double f0, double depth, bool fades) {
    const DVec3 to_eye = -glm::normalize(direction);
    double share = reflection_share(float(clamp01(glm::dot(flat, to_eye))), float(f0));
    if (fades) share *= clamp01(2.0 - 2.0 * depth / reflections.within_m);
    if (!(share > 0.0)) return {};
    const DMat3 axes(view.world_from_camera);
    const DVec2 first = DVec2(reflections.left, reflections.top) / double(reflections.step) + 0.5;
    const auto place_of = [&](const DVec3& way, double least_ahead) {
        const double ahead = std::max(-glm::dot(way, axes[2]), least_ahead);
        return DVec2((glm::dot(way, axes[0]) / ahead - view.u_first) / (double(view.u_step) * reflections.step),
                     (glm::dot(way, axes[1]) / ahead - view.v_first) / (double(view.v_step) * reflections.step)) -
               first;
    };
    const DVec2 at = place_of(direction, 0.0);
    ReflectionSample sample = sample_reflections(reflections, at.x, at.y);
    if (flat != bent) {
        const DVec3 way = 2.0 * glm::dot(bent, to_eye) * bent - to_eye;
        const DVec3 seen = way - 2.0 * glm::dot(flat, way) * flat;
        const auto nearest = [](double x, int size) { return std::size_t(std::clamp(x + 0.5, 0.0, size - 1.0)); };
        const double way_m =
            reflections.depth[nearest(at.y, reflections.image.height) * std::size_t(reflections.image.stride) +
                              nearest(at.x, reflections.image.width)];
        const double far = sample.is_known ? clamp01(1.0 - depth / std::max(way_m, depth)) : 0.0;
        const DVec2 moved = at + far * (place_of(seen, 0.05) - at);
        const ReflectionSample there = sample_reflections(reflections, moved.x, moved.y);
        if (there.is_known) sample = there;
    }
    if (!sample.is_known) return {};
    sample.light.share *= share;
    return sample.light;
}

/// How much of a layer that falls from the sky lies on surfaces of a normal's height.
double lies_on(double normal_y, double amount, double from, double full) {
    return amount * clamp01((normal_y - from) / (full - from));
}

/// Linear, before fog.
DVec3 surface_color(const StaticScene& scene, const ShadingUniforms& uniforms, const SeenTriangle& seen,
                    const PinholeView& view, const DVec3& direction, double depth, double sun_seen,
                    const ShadeSettings& settings) {
    const double pixel_angle = view.pixel_angle();
    const scene::Material& material = *seen.material;
    const auto interpolated = [&](const auto& at0, const auto& at1, const auto& at2) {
        return at0 + seen.b1 * (at1 - at0) + seen.b2 * (at2 - at0);
    };
    const double footprint = footprint_of(seen, direction, pixel_angle);
    DVec2 uv = interpolated(DVec2(seen.corner[0]->uv), DVec2(seen.corner[1]->uv), DVec2(seen.corner[2]->uv));
    if ((material.flags & scene::kMaterialSways) != 0 && !view.sway.is_none())
        uv += DVec2(leaf_shift(view.sway, Vec2(uv), float(std::sqrt(texture_density(seen))), Vec3(depth * direction)));
    DVec3 color =
        DVec3(material.base_color) *
        interpolated(unpack(seen.corner[0]->color), unpack(seen.corner[1]->color), unpack(seen.corner[2]->color));
    if (material.base_color_texture != scene::kNoTexture)
        color *= linear_of(sample(scene, scene.textures[material.base_color_texture], uv, footprint));
    DVec3 emissive(material.emissive);
    if (material.emissive_texture != scene::kNoTexture)
        emissive *= linear_of(sample(scene, scene.textures[material.emissive_texture], uv, footprint));
    if (material.flags & scene::kMaterialUnlit) return color + emissive;

    DVec3 normal = interpolated(seen.n[0], seen.n[1], seen.n[2]);
    const DVec3 facing = seen.plane < 0.0 ? seen.unit_normal : -seen.unit_normal;
    if (glm::dot(normal, facing) < 0.0) normal = -normal;
    normal /= std::max(glm::length(normal), 1e-30);
    const bool has_waves = settings.waves != nullptr && (material.flags & scene::kMaterialSpecular) != 0 &&
                           (material.flags & scene::kMaterialWater) != 0;
    double unseen = 0.0;
    const DVec3 flat = normal;
    if (has_waves) {
        const DVec3 slopes = wave_slopes(*settings.waves, depth * direction, kWaterStretch * depth * pixel_angle,
                                         double(settings.waves_within_m));
        const double strength = material.wave_strength();
        normal = glm::normalize(normal - strength * DVec3(slopes.x, 0.0, slopes.y));
        unseen = strength * strength * slopes.z;
    }
    const double on_land = has_waves ? 0.0 : 1.0;
    color = glm::mix(color, DVec3(kSnowAlbedo), on_land * lies_on(normal.y, settings.snow_cover, kSnowFrom, kSnowFull));
    const double wetness = on_land * lies_on(normal.y, settings.wet, kWetFrom, kWetFull);
    color *= 1.0 - kWetDarkens * wetness;
    const DVec3 lamps = lamp_light(settings.lamps, depth * direction, normal), to_eye = -glm::normalize(direction);
    if (!(material.flags & scene::kMaterialSpecular)) {
        const DVec3 dry = color * (diffuse_light(uniforms, normal, sun_seen) + lamps);
        const DVec3 film = specular_surface(uniforms, normal, to_eye, color, 0.0, kWetRoughness, sun_seen, lamps);
        return soft_clip(glm::mix(dry, film, wetness) + emissive);
    }
    DVec2 rough_metal(material.roughness, material.metallic);
    if (material.metallic_roughness_texture != scene::kNoTexture) {
        const DVec3 map = sample(scene, scene.textures[material.metallic_roughness_texture], uv, footprint);
        rough_metal *= DVec2(map.y, map.z);
    }
    if (has_waves) rough_metal = {std::pow(std::pow(rough_metal.x, 4.0) + 2.0 * unseen, 0.25), 0.0};
    Reflected reflected;
    if (settings.reflections != nullptr && is_mirror(material)) {
        const double f0 = glm::mix(double(kDielectric), std::max({color.x, color.y, color.z}), rough_metal.y);
        const bool fades = (material.flags & scene::kMaterialWater) == 0;
        reflected = find_reflected(*settings.reflections, view, direction, flat, normal, f0, depth, fades);
    }
    return soft_clip(specular_surface(uniforms, normal, to_eye, color, rough_metal.y, rough_metal.x, sun_seen, lamps,
                                      has_waves, reflected) +
                     emissive);
}

DVec3 prelit_color(const StaticScene& scene, const ShadingUniforms& uniforms, const SeenTriangle& seen,
                   double sun_seen) {
    const scene::Material& material = *seen.material;
    const DVec3 color = unpack(scene.prelit_colors[seen.index]);
    DVec3 emissive(material.emissive);
    if (material.emissive_texture != scene::kNoTexture) {
        const scene::Texture& texture = scene.textures[material.emissive_texture];
        emissive *= linear_of(sample(scene, texture, DVec2(0.0), 1e30));
    }
    if (material.flags & scene::kMaterialUnlit) return color + emissive;
    DVec3 normal = seen.n[0] / std::max(glm::length(seen.n[0]), 1e-30);
    if (glm::dot(normal, seen.p[0]) >= 0.0) normal = -normal;
    const auto lit = [&](double seen_share) {
        return soft_clip(color * diffuse_light(uniforms, normal, seen_share) + emissive);
    };
    return glm::mix(lit(0.0), lit(1.0), sun_seen);  // by triangle, so the share comes last
}

const scene::Instance& instance_of(const StaticScene& scene, std::span<const scene::Instance> dynamic,
                                   std::uint32_t id) {
    return id < scene.instances.size() ? scene.instances[id] : dynamic[id - scene.instances.size()];
}

DVec3 ray_direction(const PinholeView& view, int x, int y) {
    const DVec3 d((x + 0.5) * view.u_step + view.u_first, (y + 0.5) * view.v_step + view.v_first, -1.0);
    return DMat3(view.world_from_camera) * d;
}

}  // namespace

Vec3 shade_reference(const StaticScene& scene, std::span<const scene::Instance> dynamic, const PinholeView& view, int x,
                     int y, std::uint32_t instance, std::uint32_t triangle, float depth,
                     const ShadeSettings& settings) {
    ShadingUniforms uniforms = make_uniforms(scene.environment, view);
    if (settings.plain_srgb) uniforms.panorama_size.w = 0.0f;
    const DVec3 direction = ray_direction(view, x, y);
    DVec3 color;
    if (instance == farfield::kSkyInstance) {
        color = sky_color(uniforms, scene.environment, glm::normalize(direction));
    } else {
        const SeenTriangle seen = see(scene, instance_of(scene, dynamic, instance), triangle, view.position, direction);
        const std::size_t stride =
            std::size_t(view.width + farfield::kTileSize - 1) / farfield::kTileSize * farfield::kTileSize;
        const double sun_seen =
            settings.sun_seen == nullptr ? 1.0 : settings.sun_seen[std::size_t(y) * stride + std::size_t(x)] / 255.0;
        color = depth > settings.prelit_beyond_m
                    ? prelit_color(scene, uniforms, seen, sun_seen)
                    : surface_color(scene, uniforms, seen, view, direction, depth, sun_seen, settings);
        const double distance_m = depth * glm::length(direction);
        const NearAir near = make_near_air(uniforms, settings.air_error);
        if (!needs_no_air(uniforms, near, color, distance_m, glm::normalize(direction)))
            color = uniforms.panorama_size.z > 0.0f
                        ? behind_air(uniforms, color, distance_m, glm::normalize(direction))
                        : glm::mix(DVec3(uniforms.horizon), color, std::exp(-double(uniforms.to_sun.w) * distance_m));
    }
    return Vec3(encode_color(color, uniforms.panorama_size.w > 0.0f));
}

double reference_lod(const StaticScene& scene, std::span<const scene::Instance> dynamic, const PinholeView& view, int x,
                     int y, std::uint32_t instance, std::uint32_t triangle) {
    if (instance == farfield::kSkyInstance) return std::nan("");
    const DVec3 direction = ray_direction(view, x, y);
    const SeenTriangle seen = see(scene, instance_of(scene, dynamic, instance), triangle, view.position, direction);
    if (seen.material->base_color_texture == scene::kNoTexture) return std::nan("");
    return lod_of(scene.textures[seen.material->base_color_texture], footprint_of(seen, direction, view.pixel_angle()));
}

}  // namespace ff::shading
