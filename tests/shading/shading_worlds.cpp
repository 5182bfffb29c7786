#include "tests/shading/shading_worlds.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/gtc/packing.hpp>

namespace ff::test {
namespace {

using scene::MeshSource;
using scene::SceneData;
using scene::Wrap;

std::uint32_t pack(double r, double g, double b) {
    const auto byte = [](double x) { return std::uint32_t(std::clamp(x, 0.0, 1.0) * 255.0 + 0.5); };
    return byte(r) | byte(g) << 8 | byte(b) << 16 | 0xFF000000u;
}

/// A closed sphere with smooth normals, `turns` texture repeats around it.
void append_sphere(MeshSource& mesh, const Vec3& center, float radius, int rings, float turns, std::uint16_t material,
                   Random* vertex_colors) {
    const auto first = std::uint32_t(mesh.positions.size());
    for (int j = 0; j <= rings; ++j)
        for (int i = 0; i <= 2 * rings; ++i) {
            const double theta = kPi * j / rings, phi = kPi * i / rings;
            const Vec3 n(float(std::sin(theta) * std::cos(phi)), float(std::cos(theta)),
                         float(std::sin(theta) * std::sin(phi)));
            scene::VertexAttributes attributes{};
            scene::encode_normal(n, attributes.normal_oct);
            attributes.uv = turns * Vec2(float(i) / float(2 * rings), 0.5f * float(j) / float(rings));
            attributes.color = 0xFFFFFFFFu;
            if (vertex_colors)
                attributes.color = pack(vertex_colors->unit(), vertex_colors->unit(), vertex_colors->unit());
            mesh.positions.push_back(center + radius * n);
            mesh.attributes.push_back(attributes);
        }
    const auto row = std::uint32_t(2 * rings + 1);
    for (int j = 0; j < rings; ++j)
        for (int i = 0; i < 2 * rings; ++i) {
            const std::uint32_t v = first + std::uint32_t(j) * row + std::uint32_t(i);
            for (const std::uint32_t k : {v, v + row + 1, v + row, v, v + 1, v + row + 1}) mesh.indices.push_back(k);
            mesh.triangle_materials.insert(mesh.triangle_materials.end(), 2, material);
        }
}

scene::Material random_material(Random& random, std::uint32_t textures) {
    scene::Material material = plain_material();
    const auto channel = [&] { return float(random.in(0.2, 0.9)); };
    material.base_color = Vec4(channel(), channel(), channel(), 1.0f);
    if (random.below(4) != 0) material.base_color_texture = random.below(textures);
    const std::uint32_t kind = random.below(8);
    if (kind == 0) material.flags |= scene::kMaterialUnlit;
    if (kind == 1 || kind == 2) {
        material.flags |= scene::kMaterialSpecular;
        material.metallic = random.below(2) == 0 ? 0.0f : float(random.unit());
        material.roughness = float(random.in(0.2, 1.0));
        if (kind == 2) material.metallic_roughness_texture = random.below(textures);
    }
    if (random.below(5) == 0) {
        material.emissive = 0.5f * Vec3(channel(), channel(), channel());
        if (random.below(2) == 0) material.emissive_texture = random.below(textures);
    }
    return material;
}

}  // namespace

std::vector<farfield::TileRequest> all_tiles(int width, int height) {
    std::vector<farfield::TileRequest> tiles;
    for (int y = 0; y < height; y += farfield::kTileSize)
        for (int x = 0; x < width; x += farfield::kTileSize) {
            farfield::TileRequest tile{std::uint16_t(x), std::uint16_t(y), {}};
            for (std::uint16_t& row : tile.rows) row = 0xFFFF;
            tiles.push_back(tile);
        }
    return tiles;
}

farfield::VisibilityBuffer cast_view(const scene::StaticScene& scene, const PinholeView& view) {
    farfield::VisibilityBuffer visibility;
    visibility.resize(view.width, view.height);
    farfield::make_embree_caster(scene)->cast_tiles(view, all_tiles(view.width, view.height), visibility);
    return visibility;
}

shading::Image shade_view(const scene::StaticScene& scene, const PinholeView& view,
                          const farfield::VisibilityBuffer& visibility, const shading::ShadeSettings& settings,
                          std::span<const scene::Instance> dynamic) {
    shading::Image image;
    image.resize(view.width, view.height);
    shading::shade_tiles(scene, dynamic, view, visibility, all_tiles(view.width, view.height), settings, image);
    return image;
}

void randomize_environment(Random& random, scene::Environment& environment) {
    environment.to_sun = glm::normalize(random.in_box(Vec3(-1.0f, 0.1f, -1.0f), Vec3(1.0f)));
    environment.sun_radiance = random.in_box(Vec3(0.6f), Vec3(1.4f));
    environment.sky_zenith = random.in_box(Vec3(0.0f), Vec3(1.0f));
    environment.sky_horizon = random.in_box(Vec3(0.0f), Vec3(1.0f));
    environment.ground_bounce = random.in_box(Vec3(0.0f), Vec3(0.4f));
    environment.fog_density_per_m = random.below(2) == 0 ? 0.0f : float(random.in(0.001, 0.05));
}

void add_panorama(SceneData& scene, std::uint32_t width, std::uint32_t height) {
    for (std::uint32_t j = 0; j < height; ++j)
        for (std::uint32_t i = 0; i < width; ++i) {
            const double azimuth = 2.0 * kPi * (i + 0.5) / width, polar = kPi * (j + 0.5) / height;
            const double texel[4] = {0.4 + 0.3 * std::sin(polar) * std::sin(azimuth), 0.5 + 0.3 * std::cos(polar),
                                     0.6 + 0.3 * std::sin(polar) * std::cos(2.0 * azimuth), 1.0};
            for (const double x : texel) scene.sky_panorama.push_back(glm::packHalf1x16(float(x)));
        }
    scene.environment.panorama_width = width;
    scene.environment.panorama_height = height;
}

std::uint32_t add_smooth_texture(SceneData& scene, Random& random, std::uint32_t width, std::uint32_t height,
                                 Wrap wrap_u, Wrap wrap_v) {
    // One wave across the texture, so that repeats have no seam either.
    const double phase[3] = {random.in(0, 6), random.in(0, 6), random.in(0, 6)};
    std::vector<std::uint32_t> texels;
    for (std::uint32_t j = 0; j < height; ++j)
        for (std::uint32_t i = 0; i < width; ++i) {
            double c[3];
            for (int k = 0; k < 3; ++k)
                c[k] = 0.5 + 0.2 * std::sin(2.0 * kPi * (i + 0.5) / width + phase[k]) +
                       0.2 * std::sin(2.0 * kPi * (j + 0.5) / height + 2.0 * phase[k]);
            texels.push_back(pack(c[0], c[1], c[2]));
        }
    return scene.add_texture(texels, width, height, wrap_u, wrap_v);
}

SceneData make_material_world(std::uint32_t seed, const WorldPos& origin) {
    Random random(seed);
    SceneData scene;
    randomize_environment(random, scene.environment);
    constexpr Wrap kWraps[3] = {Wrap::repeat, Wrap::clamp, Wrap::mirror};
    const std::uint32_t sizes[][2] = {{256, 256}, {256, 64}, {64, 256}, {128, 128}, {1, 1}, {1, 128}, {128, 1}};
    // Every third world has repeating textures only: the fast path's own.
    const bool all_repeat = seed % 3 == 0;
    for (const auto& size : sizes)
        add_smooth_texture(scene, random, size[0], size[1], all_repeat ? Wrap::repeat : kWraps[random.below(3)],
                           all_repeat ? Wrap::repeat : kWraps[random.below(3)]);
    const auto textures = std::uint32_t(scene.textures.size());
    scene.materials.push_back(plain_material());
    for (int i = 0; i < 12; ++i) scene.materials.push_back(random_material(random, textures));
    const auto any_material = [&] { return std::uint16_t(random.below(std::uint32_t(scene.materials.size()))); };

    for (int m = 0; m < 8; ++m) {
        MeshSource mesh;
        if (m < 4) {
            append_sphere(mesh, Vec3(0.0f), 2.0f, 4 + 6 * m, float(random.in(1, 4)), any_material(),
                          m % 2 == 0 ? &random : nullptr);
        } else if (m < 6) {
            append_box(mesh, Vec3(-1.5f, -2.0f, -1.0f), Vec3(1.5f, 2.0f, 1.0f), 1 + m, any_material());
        } else {
            for (int t = 0; t < 60; ++t) {
                const Vec3 a = random.in_box(Vec3(-3.0f), Vec3(3.0f));
                append_triangle(mesh, a, a + random.in_box(Vec3(-1.0f), Vec3(1.0f)),
                                a + random.in_box(Vec3(-1.0f), Vec3(1.0f)), any_material());
            }
            for (scene::VertexAttributes& vertex : mesh.attributes) {
                const Vec3 uv = random.in_box(Vec3(-1.5f), Vec3(2.5f));
                vertex.uv = Vec2(uv.x, uv.y);
            }
        }
        const std::uint32_t id = scene.add_mesh(scene::prepare_mesh(std::move(mesh), scene.materials));
        for (int i = 0; i < 6; ++i) {
            const Vec3 scale = random.in_box(Vec3(0.6f), Vec3(1.6f)) * Vec3(i % 2 == 0 ? 1.0f : -1.0f, 1.0f, 1.0f);
            const WorldPos position = origin + DVec3(random.in(-14, 14), random.in(-8, 8), random.in(-14, 14));
            scene.add_instance(id, position, turned_and_scaled(random.in(0, 6.28), scale), 0);
        }
    }
    scene.finish(16);
    return scene;
}

SceneData make_postcard() {
    SceneData scene;
    Random random(5);
    const auto textured = [&](std::uint32_t texture) {
        scene::Material material = plain_material();
        material.base_color = Vec4(1.0f);
        material.base_color_texture = texture;
        scene.materials.push_back(material);
        return std::uint16_t(scene.materials.size() - 1);
    };
    const auto texture = [&](std::uint32_t size, auto&& color) {
        std::vector<std::uint32_t> texels;
        for (std::uint32_t j = 0; j < size; ++j)
            for (std::uint32_t i = 0; i < size; ++i) {
                const Vec3 c = color(i, j);
                texels.push_back(pack(c.x, c.y, c.z));
            }
        return scene.add_texture(texels, size, size, Wrap::repeat, Wrap::repeat);
    };
    const auto grass = textured(texture(256, [&](std::uint32_t, std::uint32_t) {
        const float n = float(random.unit());
        return Vec3(0.36f, 0.47f, 0.22f) + (n - 0.5f) * Vec3(0.22f, 0.22f, 0.14f);
    }));
    const auto bricks = textured(texture(256, [&](std::uint32_t i, std::uint32_t j) {
        const std::uint32_t row = j / 32, shifted = i + (row % 2) * 32;
        const bool mortar = j % 32 < 3 || shifted % 64 < 3;
        const float n = float(random.unit()) * 0.06f + float((row * 7 + shifted / 64 * 3) % 5) * 0.02f;
        return mortar ? Vec3(0.72f, 0.70f, 0.66f) : Vec3(0.62f, 0.35f, 0.27f) + Vec3(n);
    }));
    const auto plaster = textured(texture(64, [&](std::uint32_t i, std::uint32_t j) {
        const bool window = i > 18 && i < 44 && j > 14 && j < 48;
        return window ? Vec3(0.25f, 0.30f, 0.36f) : Vec3(0.90f, 0.86f, 0.76f) - Vec3(float(random.unit()) * 0.03f);
    }));
    scene::Material metal = plain_material();
    metal.base_color = Vec4(0.9f, 0.7f, 0.4f, 1.0f);
    metal.metallic = 1.0f;
    metal.roughness = 0.35f;
    metal.flags |= scene::kMaterialSpecular;
    scene.materials.push_back(metal);
    const auto gold = std::uint16_t(scene.materials.size() - 1);
    scene::Material leaves = plain_material();
    leaves.base_color = Vec4(0.16f, 0.30f, 0.09f, 1.0f);
    scene.materials.push_back(leaves);
    const auto leaf = std::uint16_t(scene.materials.size() - 1);

    const auto place = [&](MeshSource mesh, const WorldPos& at, const Mat3& turn = Mat3(1.0f)) {
        scene.add_instance(scene.add_mesh(scene::prepare_mesh(std::move(mesh), scene.materials)), at, turn, 0);
    };
    MeshSource ground;  // hills with smooth normals
    constexpr int kQuads = 128;
    constexpr float kSpacing = 20.0f;
    const auto height = [](float x, float z) {
        const float far = std::max(0.0f, std::sqrt(x * x + z * z) - 150.0f) * 0.001f;
        return 90.0f * far * (1.2f + std::sin(0.006f * x + 1.0f) + std::cos(0.007f * z) + 0.3f * std::sin(0.03f * x));
    };
    for (int j = 0; j <= kQuads; ++j)
        for (int i = 0; i <= kQuads; ++i) {
            const float x = kSpacing * float(i - kQuads / 2), z = kSpacing * float(j - kQuads / 2);
            scene::VertexAttributes vertex{};
            scene::encode_normal(
                glm::normalize(Vec3(height(x - 5, z) - height(x + 5, z), 10.0f, height(x, z - 5) - height(x, z + 5))),
                vertex.normal_oct);
            vertex.uv = Vec2(x, z) / 4.0f;
            vertex.color = 0xFFFFFFFFu;
            ground.positions.emplace_back(x, height(x, z), z);
            ground.attributes.push_back(vertex);
            if (i == kQuads || j == kQuads) continue;
            const auto v = std::uint32_t(j * (kQuads + 1) + i);
            for (const std::uint32_t k : {v, v + kQuads + 1, v + kQuads + 2, v, v + kQuads + 2, v + 1})
                ground.indices.push_back(k);
            ground.triangle_materials.insert(ground.triangle_materials.end(), 2, grass);
        }
    place(std::move(ground), WorldPos(0.0));
    for (int b = 0; b < 14; ++b) {
        MeshSource house;
        const float w = float(random.in(4, 7)), h = float(random.in(5, 16)), d = float(random.in(4, 7));
        append_box(house, Vec3(-w, 0, -d), Vec3(w, h, d), 1, b % 2 == 0 ? bricks : plaster);
        for (scene::VertexAttributes& vertex : house.attributes) vertex.uv *= Vec2(4.0f, 4.0f);
        const double x = b % 2 == 0 ? -16.0 : 16.0, z = -20.0 - 22.0 * (b / 2);
        place(std::move(house), WorldPos(x + random.in(-3, 3), 0.0, z),
              turned_and_scaled(random.in(-0.3, 0.3), Vec3(1.0f)));
    }
    MeshSource ball;
    append_sphere(ball, Vec3(0.0f, 1.5f, 0.0f), 1.5f, 32, 1.0f, gold, nullptr);
    place(std::move(ball), WorldPos(-2.5, 0.0, -12.0));
    MeshSource tree;
    append_box(tree, Vec3(-0.2f, 0.0f, -0.2f), Vec3(0.2f, 3.0f, 0.2f), 1, 0);
    append_sphere(tree, Vec3(0.0f, 4.5f, 0.0f), 2.2f, 10, 1.0f, leaf, nullptr);
    const std::uint32_t tree_mesh = scene.add_mesh(scene::prepare_mesh(std::move(tree), scene.materials));
    for (int i = 0; i < 160; ++i) {
        const double x = random.in(-300, 300), z = random.in(-500, -5);
        if (std::abs(x) < 28.0 && z > -180.0) continue;
        scene.add_instance(tree_mesh, WorldPos(x, height(float(x), float(z)), z),
                           turned_and_scaled(random.in(0, 6), Vec3(float(random.in(0.7, 1.5)))), 0);
    }
    scene.environment.fog_density_per_m = 0.0006f;
    scene.finish(64);
    return scene;
}

}  // namespace ff::test
