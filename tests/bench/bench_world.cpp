#include "tests/bench/bench_world.h"

#include <cmath>
#include <glm/geometric.hpp>

namespace ff::bench {
namespace {

using scene::MeshSource;
using scene::SceneData;
using scene::VertexAttributes;

constexpr float kCell = 512.0f;

/// A small deterministic generator; the standard's distributions differ between libraries.
struct Rng {
    std::uint32_t state;
    float next() {
        state = state * 1664525u + 1013904223u;
        return float(state >> 8) / 16777216.0f;
    }
    float between(float low, float high) { return low + (high - low) * next(); }
};

std::uint32_t add_vertex(MeshSource& mesh, const Vec3& p, const Vec3& normal, const Vec2& uv) {
    VertexAttributes attributes{};
    scene::encode_normal(normal, attributes.normal_oct);
    attributes.uv = uv;
    attributes.color = 0xFFFFFFFFu;
    mesh.positions.push_back(p);
    mesh.attributes.push_back(attributes);
    return std::uint32_t(mesh.positions.size() - 1);
}

void add_quad(MeshSource& mesh, const Vec3& corner, const Vec3& a, const Vec3& b, const Vec2& uv_scale,
              std::uint16_t material) {
    const Vec3 normal = glm::normalize(glm::cross(a, b));
    const auto first = add_vertex(mesh, corner, normal, {0, uv_scale.y});
    add_vertex(mesh, corner + a, normal, {uv_scale.x, uv_scale.y});
    add_vertex(mesh, corner + a + b, normal, {uv_scale.x, 0});
    add_vertex(mesh, corner + b, normal, {0, 0});
    for (const std::uint32_t i : {0u, 1u, 2u, 0u, 2u, 3u}) mesh.indices.push_back(first + i);
    mesh.triangle_materials.insert(mesh.triangle_materials.end(), 2, material);
}

/// A box with its windows as geometry: a grid of panels on every wall.
void add_building(MeshSource& mesh, const Vec3& base, const Vec3& size, float yaw, std::uint16_t material) {
    const Vec3 x = Vec3(std::cos(yaw), 0, std::sin(yaw)), z = Vec3(-x.z, 0, x.x), up(0, size.y, 0);
    const Vec3 corner = base - x * (0.5f * size.x) - z * (0.5f * size.z);
    const Vec3 corners[4] = {corner, corner + x * size.x, corner + x * size.x + z * size.z, corner + z * size.z};
    for (int wall = 0; wall < 4; ++wall) {
        const Vec3 from = corners[wall], along = corners[(wall + 1) % 4] - from;
        const float length = glm::length(along);
        add_quad(mesh, from, along, up, {length / 6.0f, size.y / 6.0f}, material);
        const Vec3 out = glm::normalize(glm::cross(along, up)) * 0.2f;
        const int columns = int(length / 6.0f), floors = int(size.y / 6.0f);
        for (int floor = 0; floor < floors; ++floor)
            for (int column = 0; column < columns; ++column)
                add_quad(mesh,
                         from + along * ((float(column) + 0.3f) / float(columns)) +
                             Vec3(0, 6.0f * float(floor) + 2.0f, 0) + out,
                         along * (0.4f / float(columns)), Vec3(0, 2.2f, 0), {1, 1}, std::uint16_t(4));
    }
    add_quad(mesh, corners[0] + up, corners[1] - corners[0], corners[3] - corners[0], {1, 1}, std::uint16_t(1));
}

std::uint32_t texel(float r, float g, float b, float a) {
    return std::uint32_t(255 * r) | std::uint32_t(255 * g) << 8 | std::uint32_t(255 * b) << 16 |
           std::uint32_t(255 * a) << 24;
}

void add_texture(SceneData& data, std::uint32_t size, auto&& color) {
    scene::Texture texture;
    texture.width = texture.height = size;
    texture.first_texel = data.texels.size();
    for (std::uint32_t level = size; level != 0; level /= 2) {
        ++texture.level_count;
        // Every mip is the mean of the texels of level 0 under it, each evaluated anew; small enough for a bench.
        const std::uint32_t block = size / level;
        for (std::uint32_t y = 0; y < level; ++y)
            for (std::uint32_t x = 0; x < level; ++x) {
                std::uint32_t sum[4] = {};
                for (std::uint32_t k = 0; k < block * block; ++k) {
                    const std::uint32_t c = color((float(x * block + k % block) + 0.5f) / float(size),
                                                  (float(y * block + k / block) + 0.5f) / float(size));
                    for (int channel = 0; channel < 4; ++channel) sum[channel] += (c >> (8 * channel)) & 255u;
                }
                std::uint32_t mean = 0;
                for (int channel = 0; channel < 4; ++channel) mean |= sum[channel] / (block * block) << (8 * channel);
                data.texels.push_back(mean);
            }
    }
    data.textures.push_back(texture);
}

void append_mesh(SceneData& data, MeshSource mesh) {
    scene::Mesh entry;
    entry.first_vertex = std::uint32_t(data.positions.size());
    entry.vertex_count = std::uint32_t(mesh.positions.size());
    entry.first_triangle = std::uint32_t(data.triangle_materials.size());
    entry.triangle_count = std::uint32_t(mesh.triangle_materials.size());
    for (const Vec3& p : mesh.positions) entry.bounds.add(p);
    for (const std::uint16_t m : mesh.triangle_materials) entry.material_flags |= data.materials[m].flags;
    data.positions.insert(data.positions.end(), mesh.positions.begin(), mesh.positions.end());
    data.attributes.insert(data.attributes.end(), mesh.attributes.begin(), mesh.attributes.end());
    data.indices.insert(data.indices.end(), mesh.indices.begin(), mesh.indices.end());
    data.triangle_materials.insert(data.triangle_materials.end(), mesh.triangle_materials.begin(),
                                   mesh.triangle_materials.end());
    data.meshes.push_back(entry);
}

}  // namespace

float town_height(float x, float z) {
    const float far = std::sqrt(x * x + z * z) / 1500.0f;
    return (30.0f * std::sin(x / 190.0f) * std::cos(z / 230.0f) + 12.0f * std::sin(x / 61.0f + z / 47.0f)) *
               std::min(1.0f, 0.15f + far) +
           40.0f * far * far;
}

SceneData make_town(const TownSize& size) {
    SceneData data;
    const float noise_scale = 40.0f;
    add_texture(data, 256, [&](float u, float v) {
        const float n = 0.5f + 0.25f * std::sin(noise_scale * u) * std::cos(1.7f * noise_scale * v) +
                        0.2f * std::sin(3.1f * noise_scale * (u + v));
        return texel(0.3f * n + 0.1f, 0.5f * n + 0.1f, 0.2f * n, 1.0f);
    });
    add_texture(data, 256, [&](float u, float v) {
        const bool mortar = std::fmod(v * 16, 1.0f) < 0.12f || std::fmod(u * 8, 1.0f) < 0.06f;
        return mortar ? texel(0.75f, 0.73f, 0.7f, 1.0f) : texel(0.62f, 0.35f + 0.1f * std::sin(9 * u), 0.28f, 1.0f);
    });
    add_texture(data, 128, [&](float u, float v) {
        const float leaf = std::sin(31 * u) * std::sin(29 * v) + 0.5f * std::sin(70 * (u - v));
        const float r = std::hypot(u - 0.5f, v - 0.5f);
        return texel(0.15f, 0.35f + 0.2f * v, 0.1f, leaf > -0.1f && r < 0.48f ? 1.0f : 0.0f);
    });
    data.materials.resize(5);
    data.materials[0].base_color_texture = 0;
    data.materials[1].base_color = Vec4(0.45f, 0.42f, 0.4f, 1.0f);
    data.materials[2].base_color_texture = 1;
    data.materials[3].base_color_texture = 2;
    if (size.masked_trees) data.materials[3].flags = scene::kMaterialAlphaMask | scene::kMaterialDoubleSided;
    data.materials[4].base_color = Vec4(0.12f, 0.15f, 0.22f, 1.0f);

    MeshSource tree;
    Rng leaves{7};
    for (int i = 0; i < 60; ++i) {
        const float yaw = leaves.between(0, 6.28f), tilt = leaves.between(-0.6f, 0.6f);
        const Vec3 a = 1.6f * Vec3(std::cos(yaw), 0, std::sin(yaw));
        const Vec3 b = 1.6f * Vec3(-std::sin(yaw) * std::sin(tilt), std::cos(tilt), std::cos(yaw) * std::sin(tilt));
        const Vec3 center(leaves.between(-2, 2), leaves.between(2.5f, 7), leaves.between(-2, 2));
        add_quad(tree, center - a - b, 2.0f * a, 2.0f * b, {1, 1}, std::uint16_t(3));
    }
    add_quad(tree, Vec3(-0.2f, 0, 0), Vec3(0.4f, 0, 0), Vec3(0, 4, 0), {1, 1}, std::uint16_t(1));
    add_quad(tree, Vec3(0, 0, -0.2f), Vec3(0, 0, 0.4f), Vec3(0, 4, 0), {1, 1}, std::uint16_t(1));
    append_mesh(data, std::move(tree));

    for (int cz = 0; cz < size.cells; ++cz)
        for (int cx = 0; cx < size.cells; ++cx) {
            const DVec3 origin(double(kCell) * (cx - size.cells / 2), 0, double(kCell) * (cz - size.cells / 2));
            const auto height = [&](float x, float z) { return town_height(float(origin.x) + x, float(origin.z) + z); };
            MeshSource cell;
            const int n = size.terrain_quads;
            const float step = kCell / float(n);
            for (int j = 0; j <= n; ++j)
                for (int i = 0; i <= n; ++i) {
                    const float x = step * float(i), z = step * float(j);
                    const Vec3 normal = glm::normalize(
                        Vec3(height(x - 1, z) - height(x + 1, z), 2.0f, height(x, z - 1) - height(x, z + 1)));
                    add_vertex(cell, {x, height(x, z), z}, normal, Vec2(x, z) / 12.0f);
                }
            for (int j = 0; j < n; ++j)
                for (int i = 0; i < n; ++i) {
                    const auto a = std::uint32_t(j * (n + 1) + i), b = a + std::uint32_t(n) + 1;
                    for (const std::uint32_t v : {a, b, a + 1, a + 1, b, b + 1}) cell.indices.push_back(v);
                    cell.triangle_materials.insert(cell.triangle_materials.end(), 2, std::uint16_t(0));
                }
            Rng rng{std::uint32_t(cz * 1000 + cx + 1)};
            const int side = int(std::sqrt(float(size.buildings)));
            for (int b = 0; b < side * side; ++b) {
                const float spacing = kCell / float(side);
                const float x = spacing * (float(b % side) + 0.5f), z = spacing * (float(b / side) + 0.5f);
                const float tall = std::exp(-float(glm::length(origin)) / 600.0f) * rng.between(0, 60);
                add_building(
                    cell, {x, height(x, z) - 2, z},
                    {spacing * rng.between(0.35f, 0.6f), rng.between(7, 16) + tall, spacing * rng.between(0.35f, 0.6f)},
                    rng.between(-0.1f, 0.1f), std::uint16_t(2));
            }
            append_mesh(data, std::move(cell));
            const auto place = [&](std::uint32_t mesh, const DVec3& position, const Mat3& axes) {
                scene::Instance instance;
                instance.mesh = mesh;
                instance.position = position;
                instance.world_from_mesh = axes;
                instance.cell = std::uint32_t(cz * size.cells + cx);
                const Box3& local = data.meshes[mesh].bounds;
                for (int corner = 0; corner < 8; ++corner)
                    instance.bounds.add(position + DVec3(axes * Vec3(corner & 1 ? local.high.x : local.low.x,
                                                                     corner & 2 ? local.high.y : local.low.y,
                                                                     corner & 4 ? local.high.z : local.low.z)));
                data.bounds.add(instance.bounds);
                data.instances.push_back(instance);
            };
            place(std::uint32_t(data.meshes.size() - 1), origin, Mat3(1.0f));
            for (int t = 0; t < size.trees; ++t) {
                const float x = rng.between(0, kCell), z = rng.between(0, kCell), yaw = rng.between(0, 6.28f);
                const float scale = rng.between(0.8f, 1.3f), c = scale * std::cos(yaw), s = scale * std::sin(yaw);
                place(0, origin + DVec3(x, height(x, z), z), Mat3(Vec3(c, 0, -s), Vec3(0, scale, 0), Vec3(s, 0, c)));
            }
        }
    return data;
}

}  // namespace ff::bench
