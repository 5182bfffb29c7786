#include "tools/cook/city_materials.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tools/cook/buildings_facade.h"

namespace ff::cook::city {
namespace {

constexpr std::uint32_t kSide = 256;  // texels of kWallTile metres: 1.25 cm each

using Shade = double (*)(std::uint32_t x, std::uint32_t y);  // sRGB value in [0, 1]

double grain(std::uint64_t seed, std::uint32_t x, std::uint32_t y) {
    return hash_unit(seed, x % kSide, y % kSide);
}

/// Grain averaged over squares of `size` texels, smoothly; `size` divides kSide.
double blotches(std::uint64_t seed, std::uint32_t x, std::uint32_t y, std::uint32_t size) {
    const std::uint32_t cx = x / size, cy = y / size, count = kSide / size;
    const double fx = double(x % size) / size, fy = double(y % size) / size;
    const auto at = [&](std::uint32_t a, std::uint32_t b) { return hash_unit(seed, a % count, b % count); };
    return std::lerp(std::lerp(at(cx, cy), at(cx + 1, cy), fx), std::lerp(at(cx, cy + 1), at(cx + 1, cy + 1), fx), fy);
}

// Courses of 10 cm, every second one moved by half a brick.
double brick_shade(std::uint32_t x, std::uint32_t y) {
    const std::uint32_t course = y / 8, moved = (x + (course & 1) * 8) % kSide;
    if (y % 8 == 0 || moved % 16 == 0) return 0.92 + 0.06 * grain(1, x, y);
    return 0.66 + 0.2 * hash_unit(2, moved / 16, course) + 0.08 * grain(3, x, y);
}
double plaster_shade(std::uint32_t x, std::uint32_t y) {
    return 0.88 + 0.05 * grain(4, x, y) + 0.07 * blotches(5, x, y, 32);
}
// Ashlar of 80 by 40 cm.
double stone_shade(std::uint32_t x, std::uint32_t y) {
    const std::uint32_t course = y / 32, moved = (x + (course & 1) * 32) % kSide;
    if (y % 32 < 1 || moved % 64 < 1) return 0.62;
    return 0.8 + 0.1 * hash_unit(6, moved / 64, course) + 0.05 * grain(7, x, y) + 0.05 * blotches(8, x, y, 8);
}
double concrete_shade(std::uint32_t x, std::uint32_t y) {
    return 0.8 + 0.04 * grain(9, x, y) + 0.1 * blotches(10, x, y, 64) + 0.06 * blotches(11, x, y, 16);
}

std::uint32_t add_wall_texture(WorldSource& into, const char* name, Shade shade) {
    SourceTexture texture;
    texture.name = fmt::format("city {}", name);
    texture.content_hash = texture.name;
    texture.width = texture.height = kSide;
    texture.rgba.reserve(std::size_t(kSide) * kSide);
    for (std::uint32_t y = 0; y < kSide; ++y)
        for (std::uint32_t x = 0; x < kSide; ++x) {
            const auto value = std::uint32_t(std::clamp(shade(x, y), 0.0, 1.0) * 255.0 + 0.5);
            texture.rgba.push_back(0xFF000000u | value << 16 | value << 8 | value);
        }
    into.textures.push_back(std::move(texture));
    return std::uint32_t(into.textures.size() - 1);
}

}  // namespace

CityMaterials add_city_materials(const CityTextures& textures, WorldSource& into) {
    const auto add = [&](std::uint32_t texture, const Vec4& color = Vec4(1.0f), float roughness = 1.0f,
                         float metallic = 0.0f) {
        scene::Material material;
        material.base_color = color;
        material.base_color_texture = texture;
        material.roughness = roughness;
        material.metallic = metallic;
        if (roughness < 0.5f) material.flags |= scene::kMaterialSpecular;
        if (scene::is_smooth(material)) material.flags |= scene::kMaterialMirror;
        into.materials.push_back(material);
        return std::uint32_t(into.materials.size() - 1);
    };
    // Where a texture is missing its mean colour stands in.
    const auto add_ground = [&](std::uint32_t texture, const Vec3& mean) {
        return add(texture, texture == scene::kNoTexture ? Vec4(mean, 1.0f) : Vec4(1.0f));
    };
    CityMaterials m;
    m.brick = add(add_wall_texture(into, "brick", brick_shade));
    m.plaster = add(add_wall_texture(into, "plaster", plaster_shade));
    m.stone = add(add_wall_texture(into, "stone", stone_shade));
    m.concrete = add(add_wall_texture(into, "concrete", concrete_shade));
    m.plain = add(scene::kNoTexture);
    m.metal = add(scene::kNoTexture, Vec4(0.75f, 0.76f, 0.78f, 1.0f), 0.45f, 0.6f);
    m.glass = add(scene::kNoTexture, Vec4(0.055f, 0.07f, 0.085f, 1.0f), 0.15f, 0.0f);
    m.curtain_glass = add(scene::kNoTexture, Vec4(0.10f, 0.16f, 0.20f, 1.0f), 0.12f, 0.25f);
    m.roof_red = add_ground(textures.roof_red, {0.35f, 0.12f, 0.07f});
    m.roof_dark = add_ground(textures.roof_dark, {0.09f, 0.09f, 0.1f});
    m.roof_flat = add_ground(textures.gravel, {0.3f, 0.29f, 0.27f});
    m.asphalt = add_ground(textures.asphalt, {0.08f, 0.08f, 0.085f});
    m.pavement = add_ground(textures.pavement, {0.4f, 0.38f, 0.36f});
    m.grass = add_ground(textures.grass, {0.1f, 0.19f, 0.05f});
    m.gravel = m.roof_flat;
    m.leaves =
        add(textures.grass, Vec4(textures.grass == scene::kNoTexture ? Vec3(0.06f, 0.13f, 0.03f) : Vec3(0.55f), 1.0f));
    return m;
}

}  // namespace ff::cook::city
