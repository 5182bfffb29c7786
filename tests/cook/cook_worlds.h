#pragma once
// Small sources for tests of the assembly.

#include <cmath>
#include <random>

#include "tools/cook/world_source.h"

namespace ff::test {

inline std::uint16_t add_plain_material(cook::WorldSource& world, const Vec4& color = Vec4(1.0f)) {
    world.materials.push_back({.base_color = color});
    return static_cast<std::uint16_t>(world.materials.size() - 1);
}

/// A box with flat normals that face outwards; 12 triangles.
inline scene::MeshSource box_mesh(const Vec3& half, std::uint16_t material) {
    scene::MeshSource mesh;
    for (int axis = 0; axis < 3; ++axis)
        for (const float side : {-1.0f, 1.0f}) {
            const int u = (axis + 1) % 3, v = (axis + 2) % 3;
            const auto first = static_cast<std::uint32_t>(mesh.positions.size());
            for (const auto& [a, b] : {std::pair(-1.0f, -1.0f), {1.0f, -1.0f}, {1.0f, 1.0f}, {-1.0f, 1.0f}}) {
                Vec3 p, n(0.0f);
                p[axis] = side * half[axis], p[u] = a * half[u] * side, p[v] = b * half[v];
                n[axis] = side;
                mesh.positions.push_back(p);
                scene::VertexAttributes attributes{.normal_oct = {}, .uv = {a, b}, .color = 0xFFFFFFFFu};
                scene::encode_normal(n, attributes.normal_oct);
                mesh.attributes.push_back(attributes);
            }
            for (const std::uint32_t corner : {0u, 1u, 2u, 0u, 2u, 3u}) mesh.indices.push_back(first + corner);
            mesh.triangle_materials.insert(mesh.triangle_materials.end(), 2, material);
        }
    return mesh;
}

inline std::uint32_t add_mesh(cook::WorldSource& world, scene::MeshSource mesh) {
    world.meshes.push_back({.name = "test mesh", .geometry = std::move(mesh)});
    return static_cast<std::uint32_t>(world.meshes.size() - 1);
}

/// Triangles of random sizes all over a square, in several merged meshes far from the origin, turned and mirrored.
inline cook::WorldSource scattered_triangles(std::uint32_t seed, int triangles, double size_m, const DVec3& center) {
    cook::WorldSource world;
    std::mt19937 random(seed);
    const auto uniform = [&] { return static_cast<double>(random()) / 4294967295.0 - 0.5; };
    const std::uint16_t material = add_plain_material(world);
    for (int m = 0; m < 4; ++m) {
        scene::MeshSource mesh;
        for (int t = 0; t < triangles / 4; ++t) {
            const Vec3 middle(uniform() * size_m, uniform() * 50.0, uniform() * size_m);
            const double size = random() % 50 == 0 ? size_m / 4 : 5.0;
            for (int c = 0; c < 3; ++c) {
                mesh.indices.push_back(static_cast<std::uint32_t>(mesh.positions.size()));
                mesh.positions.push_back(middle + Vec3(uniform() * size, uniform() * size, uniform() * size));
                mesh.attributes.push_back({.normal_oct = {0, 0}, .uv = {0, 0}, .color = 0xFFFFFFFFu});
            }
            mesh.triangle_materials.push_back(material);
        }
        const auto angle = static_cast<float>(m);
        const Mat3 turn(std::cos(angle), 0, std::sin(angle), 0, m % 2 == 0 ? 1 : -1, 0, -std::sin(angle), 0,
                        std::cos(angle));
        const std::uint32_t id = add_mesh(world, std::move(mesh));
        world.placements.push_back({.mesh = id, .position = center, .world_from_mesh = turn});
    }
    return world;
}

}  // namespace ff::test
