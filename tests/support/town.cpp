#include "tests/support/town.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "tests/support/worlds.h"

namespace ff::test {
namespace {

using scene::MeshSource;
using scene::SceneData;

constexpr double kCellM = 128.0;

std::uint32_t pack(double r, double g, double b) {
    const auto byte = [](double x) { return std::uint32_t(std::clamp(x, 0.0, 1.0) * 255.0 + 0.5); };
    return byte(r) | byte(g) << 8 | byte(b) << 16 | 0xFF000000u;
}

/// A texture from a function of (x, y) in texels.
template <class Color>
std::uint32_t add_painted(SceneData& scene, std::uint32_t size, Color&& color) {
    std::vector<std::uint32_t> texels(std::size_t(size) * size);
    for (std::uint32_t y = 0; y < size; ++y)
        for (std::uint32_t x = 0; x < size; ++x) texels[std::size_t(y) * size + x] = color(x, y);
    return scene.add_texture(texels, size, size, scene::Wrap::repeat, scene::Wrap::repeat);
}

struct Materials {
    std::uint16_t grass, road, facade, roof, bark, leaf, lamp, water, glass;
};

Materials add_materials(SceneData& scene, Random& random) {
    const auto add = [&](scene::Material material) {
        scene.materials.push_back(material);
        return std::uint16_t(scene.materials.size() - 1);
    };
    const auto textured = [](std::uint32_t texture) {
        scene::Material material;
        material.base_color_texture = texture;
        return material;
    };
    Materials m{};
    add(plain_material());
    m.grass = add(textured(add_painted(scene, 64, [&](auto, auto) {
        const double shade = random.in(0.75, 1.0);
        return pack(0.33 * shade, 0.42 * shade, 0.2 * shade);
    })));
    m.road = add(textured(add_painted(scene, 64, [&](std::uint32_t x, std::uint32_t y) {
        const double shade = x >= 30 && x < 34 && y < 32 ? 0.85 : random.in(0.33, 0.4);
        return pack(shade, shade, shade);
    })));
    m.facade = add(textured(add_painted(scene, 64, [&](std::uint32_t x, std::uint32_t y) {
        const bool is_window = x % 32 >= 10 && x % 32 < 22 && y % 32 >= 8 && y % 32 < 24;
        const double shade = random.in(0.9, 1.0);
        return is_window ? pack(0.15, 0.2, 0.27) : pack(0.8 * shade, 0.7 * shade, 0.58 * shade);
    })));
    m.roof = add(textured(add_painted(scene, 32, [&](auto, std::uint32_t y) {
        const double shade = y % 8 < 2 ? 0.6 : random.in(0.85, 1.0);
        return pack(0.6 * shade, 0.3 * shade, 0.22 * shade);
    })));
    m.bark = add({.base_color = {0.25f, 0.18f, 0.12f, 1.0f}});
    m.leaf = std::uint16_t(add_leaf_material(scene));
    m.lamp = add({.base_color = {0.9f, 0.9f, 0.8f, 1.0f}, .emissive = {0.9f, 0.7f, 0.4f}});
    m.water = add({.base_color = {0.05f, 0.08f, 0.09f, 1.0f},
                   .metallic = 0.1f,
                   .roughness = 0.15f,
                   .flags = scene::kMaterialSpecular});
    m.glass = add({.base_color = {0.5f, 0.65f, 0.7f, 0.4f}, .flags = scene::kMaterialBlend});
    return m;
}

void scale_uv(MeshSource& mesh, std::size_t first_vertex, const Vec2& scale) {
    for (std::size_t v = first_vertex; v < mesh.attributes.size(); ++v) mesh.attributes[v].uv *= scale;
}

/// Four walls, a ridge along z and its gables.
void append_house(MeshSource& mesh, const Vec3& low, const Vec3& high, const Materials& m) {
    const Vec3 ground[4] = {low, {high.x, low.y, low.z}, {high.x, low.y, high.z}, {low.x, low.y, high.z}};
    const Vec3 up(0.0f, high.y - low.y, 0.0f);
    for (int side = 0; side < 4; ++side) {
        const Vec3 a = ground[(side + 1) % 4], b = ground[side];
        const std::size_t first = mesh.positions.size();
        append_quad(mesh, a, b, b + up, a + up, m.facade);
        scale_uv(mesh, first, Vec2(glm::length(b - a) / 6.0f, up.y / 6.0f));
    }
    const float middle = 0.5f * (low.x + high.x), ridge = high.y + 0.3f * (high.x - low.x);
    const Vec3 south(middle, ridge, high.z), north(middle, ridge, low.z);
    const std::size_t first = mesh.positions.size();
    append_quad(mesh, ground[3] + up, south, north, ground[0] + up, m.roof);
    append_quad(mesh, ground[1] + up, north, south, ground[2] + up, m.roof);
    scale_uv(mesh, first, Vec2(4.0f));
    append_triangle(mesh, ground[0] + up, north, ground[1] + up, m.facade);
    append_triangle(mesh, ground[2] + up, south, ground[3] + up, m.facade);
}

MeshSource make_tree(Random& random, const Materials& m) {
    MeshSource tree;
    append_box(tree, {-0.2f, 0.0f, -0.2f}, {0.2f, 3.0f, 0.2f}, 1, m.bark);
    for (int i = 0; i < 160; ++i) {
        const Vec3 offset = random.in_box(Vec3(-1.0f), Vec3(1.0f));
        if (glm::dot(offset, offset) > 1.0f) continue;
        const Vec3 at = Vec3(0.0f, 5.0f, 0.0f) + offset * Vec3(2.2f, 2.8f, 2.2f);
        const Vec3 right = random.in_box(Vec3(-0.8f), Vec3(0.8f)), up = random.in_box(Vec3(-0.8f), Vec3(0.8f));
        append_quad(tree, at - right - up, at + right - up, at + right + up, at - right + up, m.leaf);
    }
    return tree;
}

/// The ground of one cell, with its corner at the origin; finer where the town stands.
MeshSource make_ground(double low_x, double low_z, const Materials& m) {
    constexpr int kQuads = 16;
    MeshSource mesh;
    const double quad_m = kCellM / kQuads;
    for (int j = 0; j < kQuads; ++j)
        for (int i = 0; i < kQuads; ++i) {
            const auto corner = [&](int dx, int dz) {
                const double x = (i + dx) * quad_m, z = (j + dz) * quad_m;
                return Vec3(float(x), float(small_town_ground(low_x + x, low_z + z)), float(z));
            };
            const bool is_road = std::abs(low_x + (i + 0.5) * quad_m) < quad_m;
            const std::size_t first = mesh.positions.size();
            append_quad(mesh, corner(0, 1), corner(1, 1), corner(1, 0), corner(0, 0), is_road ? m.road : m.grass);
            if (!is_road) scale_uv(mesh, first, Vec2(2.0f));
        }
    return mesh;
}

std::uint32_t cell_of(const WorldPos& p) {
    const auto square = [](double x) { return std::uint32_t(std::floor(x / kCellM) + 32.0); };
    return square(p.z) * 64 + square(p.x);
}

}  // namespace

double small_town_ground(double x, double z) {
    const double far_off = std::clamp((std::sqrt(x * x + z * z) - 250.0) / 1500.0, 0.0, 1.0);
    return far_off * far_off * (420.0 + 160.0 * std::sin(0.006 * x) * std::cos(0.005 * z));
}

SceneData make_small_town(const TownSettings& settings) {
    SceneData scene;
    Random random(17);
    const Materials m = add_materials(scene, random);
    const auto place = [&](MeshSource mesh, const WorldPos& at) {
        scene.add_instance(scene.add_mesh(scene::prepare_mesh(std::move(mesh), scene.materials)), at, Mat3(1.0f),
                           cell_of(at));
    };
    constexpr int kHalfCells = 16;
    for (int j = -kHalfCells; j < kHalfCells; ++j)
        for (int i = -kHalfCells; i < kHalfCells; ++i) {
            const WorldPos at((i + 1e-6) * kCellM, 0.0, (j + 1e-6) * kCellM);
            place(make_ground(at.x, at.z, m), at);
        }

    for (int i = -14; i < 14; ++i)
        for (const int side : {-1, 1}) {
            MeshSource house;
            const auto width = float(random.in(4.0, 6.5)), depth = float(random.in(5.0, 7.0));
            const auto height = float(random.in(5.0, 14.0));
            append_house(house, {-width, 0.0f, -depth}, {width, height, depth}, m);
            if (settings.glass && i % 3 == 0) {
                const float x = float(-side) * (width + 1.0f);
                append_quad(house, {x, 0.2f, -4.0f}, {x, 0.2f, 4.0f}, {x, 3.5f, 4.0f}, {x, 3.5f, -4.0f}, m.glass);
                append_quad(house, {x - float(side), 0.2f, -4.0f}, {x - float(side), 0.2f, 4.0f},
                            {x - float(side), 2.5f, 4.0f}, {x - float(side), 2.5f, -4.0f}, m.glass);
            }
            place(std::move(house), WorldPos(side * 20.0, 0.0, i * 17.0 + 8.0));
            MeshSource lamp;
            append_box(lamp, {-0.06f, 0.0f, -0.06f}, {0.06f, 4.0f, 0.06f}, 1, m.bark);
            append_box(lamp, {-0.25f, 4.0f, -0.25f}, {0.25f, 4.5f, 0.25f}, 1, m.lamp);
            place(std::move(lamp), WorldPos(side * 9.0, 0.0, i * 17.0));
        }
    MeshSource pond;
    append_quad(pond, {-12, 0.15f, 9}, {12, 0.15f, 9}, {12, 0.15f, -9}, {-12, 0.15f, -9}, m.water);
    place(std::move(pond), WorldPos(45.0, 0.0, -20.0));

    std::uint32_t kinds[3];
    for (std::uint32_t& kind : kinds) kind = scene.add_mesh(scene::prepare_mesh(make_tree(random, m), scene.materials));
    for (int i = 0; i < 1200; ++i) {
        const double side = random.below(2) == 0 ? -1.0 : 1.0;
        const bool in_street = i < 40;
        const double x = side * (in_street ? 8.5 : random.in(32.0, 700.0));
        const double z = in_street ? (i - 20) * 12.0 + 3.0 : random.in(-800.0, 800.0);
        const auto scale = float(random.in(0.7, 1.4));
        const WorldPos at(x, small_town_ground(x, z), z);
        scene.add_instance(kinds[random.below(3)], at, turned_and_scaled(random.in(0.0, 2.0 * kPi), Vec3(scale)),
                           cell_of(at));
    }
    scene.environment.fog_density_per_m = 2e-4f;
    scene.finish(256);
    return scene;
}

}  // namespace ff::test
