#include "tests/support/worlds.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

namespace ff::test {
namespace {

using scene::MeshSource;
using scene::SceneData;
using scene::VertexAttributes;

std::uint32_t add_vertex(MeshSource& mesh, const Vec3& p, const Vec3& normal, const Vec2& uv) {
    VertexAttributes attributes{.normal_oct = {0, 0}, .uv = uv, .color = 0xFFFFFFFFu};
    scene::encode_normal(normal, attributes.normal_oct);
    mesh.positions.push_back(p);
    mesh.attributes.push_back(attributes);
    return std::uint32_t(mesh.positions.size() - 1);
}

void add_indices(MeshSource& mesh, std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint16_t material) {
    mesh.indices.insert(mesh.indices.end(), {a, b, c});
    mesh.triangle_materials.push_back(material);
}

std::uint32_t add_prepared(SceneData& scene, MeshSource mesh) {
    return scene.add_mesh(scene::prepare_mesh(std::move(mesh), scene.materials));
}

// A quad of n x n quads.
void append_patch(MeshSource& mesh, const Vec3& a, const Vec3& along, const Vec3& up, int n, std::uint16_t material) {
    const Vec3 normal = glm::normalize(glm::cross(along, up));
    const auto first = std::uint32_t(mesh.positions.size());
    for (int j = 0; j <= n; ++j) {
        for (int i = 0; i <= n; ++i) {
            const float s = float(i) / float(n), t = float(j) / float(n);
            // Corners exactly where the neighbouring faces have them.
            const Vec3 p = a + (i == n ? along : along * s) + (j == n ? up : up * t);
            add_vertex(mesh, p, normal, Vec2(s, t));
        }
    }
    const auto row = std::uint32_t(n + 1);
    for (std::uint32_t j = 0; j < std::uint32_t(n); ++j) {
        for (std::uint32_t i = 0; i < std::uint32_t(n); ++i) {
            const std::uint32_t v = first + j * row + i;
            add_indices(mesh, v, v + 1, v + row + 1, material);
            add_indices(mesh, v, v + row + 1, v + row, material);
        }
    }
}

MeshSource make_tree(Random& random, const ForestSettings& forest, std::uint16_t bark, std::uint16_t leaf) {
    MeshSource tree;
    append_box(tree, Vec3(-0.15f, 0.0f, -0.15f), Vec3(0.15f, 3.0f, 0.15f), 1, bark);
    for (int i = 0; i < forest.leaves; ++i) {
        Vec3 offset;
        do {
            offset = random.in_box(Vec3(-1.0f), Vec3(1.0f));
        } while (glm::dot(offset, offset) > 1.0f);
        const Vec3 at = Vec3(0.0f, 4.5f, 0.0f) + offset * Vec3(2.2f, 2.5f, 2.2f);
        const float size = float(random.in(0.1, 0.25)) * (forest.masked ? 3.0f : 1.0f);
        const Vec3 right = random.in_box(Vec3(-1.0f), Vec3(1.0f)) * size,
                   up = random.in_box(Vec3(-1.0f), Vec3(1.0f)) * size;
        if (forest.masked)
            append_quad(tree, at - right - up, at + right - up, at + right + up, at - right + up, leaf);
        else
            append_triangle(tree, at - right, at + right, at + up, leaf);
    }
    return tree;
}

}  // namespace

scene::Material plain_material() {
    return {.base_color = Vec4(0.6f, 0.6f, 0.6f, 1.0f)};
}

std::uint32_t add_leaf_material(SceneData& scene, std::uint32_t size) {
    std::vector<std::uint32_t> texels(std::size_t(size) * size);
    for (std::uint32_t y = 0; y < size; ++y) {
        for (std::uint32_t x = 0; x < size; ++x) {
            const double u = (x + 0.5) / size * 2.0 - 1.0, v = (y + 0.5) / size * 2.0 - 1.0;
            const double lobes = 0.75 + 0.2 * std::cos(5.0 * std::atan2(v, u));
            const std::uint32_t alpha = u * u + v * v < lobes * lobes ? 255u : 0u;
            texels[std::size_t(y) * size + x] = (alpha << 24) | 0x00306020u;
        }
    }
    scene::Material leaf = plain_material();
    leaf.flags = scene::kMaterialAlphaMask | scene::kMaterialDoubleSided;
    leaf.base_color_texture = scene.add_texture(texels, size, size, scene::Wrap::clamp, scene::Wrap::clamp);
    scene.materials.push_back(leaf);
    return std::uint32_t(scene.materials.size() - 1);
}

void append_triangle(MeshSource& mesh, const Vec3& a, const Vec3& b, const Vec3& c, std::uint16_t material) {
    const Vec3 normal = glm::cross(b - a, c - a);
    const std::uint32_t first = add_vertex(mesh, a, normal, Vec2(0.0f, 0.0f));
    add_vertex(mesh, b, normal, Vec2(1.0f, 0.0f));
    add_vertex(mesh, c, normal, Vec2(0.5f, 1.0f));
    add_indices(mesh, first, first + 1, first + 2, material);
}

void append_quad(MeshSource& mesh, const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d, std::uint16_t material) {
    const Vec3 normal = glm::cross(b - a, d - a);
    const std::uint32_t first = add_vertex(mesh, a, normal, Vec2(0.0f, 0.0f));
    add_vertex(mesh, b, normal, Vec2(1.0f, 0.0f));
    add_vertex(mesh, c, normal, Vec2(1.0f, 1.0f));
    add_vertex(mesh, d, normal, Vec2(0.0f, 1.0f));
    add_indices(mesh, first, first + 1, first + 2, material);
    add_indices(mesh, first, first + 2, first + 3, material);
}

void append_box(MeshSource& mesh, const Vec3& low, const Vec3& high, int n, std::uint16_t material) {
    const Vec3 e = high - low;
    const Vec3 x(e.x, 0, 0), y(0, e.y, 0), z(0, 0, e.z);
    append_patch(mesh, low, z, y, n, material);
    append_patch(mesh, low + x, y, z, n, material);
    append_patch(mesh, low, x, z, n, material);
    append_patch(mesh, low + y, z, x, n, material);
    append_patch(mesh, low, y, x, n, material);
    append_patch(mesh, low + z, x, y, n, material);
}

Mat3 turned_and_scaled(double yaw, const Vec3& scale) {
    const float c = float(std::cos(yaw)), s = float(std::sin(yaw));
    return Mat3(Vec3(c, 0, -s) * scale.x, Vec3(0, 1, 0) * scale.y, Vec3(s, 0, c) * scale.z);
}

SceneData make_empty_world() {
    SceneData scene;
    scene.materials.push_back(plain_material());
    scene.finish(16);
    return scene;
}

SceneData make_city(const CitySettings& city, const WorldSettings& world) {
    constexpr double block_m = 40.0;
    constexpr int per_cell = 4;
    const double cell_m = block_m * per_cell;
    SceneData scene;
    scene.materials.push_back(plain_material());
    Random random(world.seed);
    for (int cz = 0; cz < city.cells; ++cz) {
        for (int cx = 0; cx < city.cells; ++cx) {
            MeshSource mesh;
            const auto half = float(0.5 * cell_m);
            append_patch(mesh, Vec3(-half, 0, -half), Vec3(0, 0, 2 * half), Vec3(2 * half, 0, 0), per_cell, 0);
            for (int b = 0; b < per_cell * per_cell; ++b) {
                const double x = (b % per_cell + 0.5) * block_m - half, z = (b / per_cell + 0.5) * block_m - half;
                const double wx = random.in(8, 14), wz = random.in(8, 14), height = random.in(8, 60);
                append_box(mesh, Vec3(float(x - wx), 0, float(z - wz)),
                           Vec3(float(x + wx), float(height), float(z + wz)), city.subdivisions, 0);
            }
            const std::uint32_t id = add_prepared(scene, std::move(mesh));
            const WorldPos at((cx + 0.5 - 0.5 * city.cells) * cell_m, 0.0, (cz + 0.5 - 0.5 * city.cells) * cell_m);
            scene.add_instance(id, world.origin + at, Mat3(1.0f), std::uint32_t(cz * city.cells + cx));
        }
    }
    scene.finish(world.height_grid_size);
    return scene;
}

double terrain_height(double x, double z, double relief_m) {
    return relief_m * (0.5 * std::sin(x * 0.004) * std::cos(z * 0.0031) + 0.3 * std::sin(x * 0.013 + z * 0.009) +
                       0.05 * std::sin(x * 0.07) * std::sin(z * 0.081));
}

SceneData make_terrain(const TerrainSettings& terrain, const WorldSettings& world) {
    constexpr int kCellQuads = 64;
    SceneData scene;
    scene.materials.push_back(plain_material());
    const int quads = std::max(1, int(terrain.size_m / terrain.spacing_m + 0.5));
    std::uint32_t cell = 0;
    for (int z0 = 0; z0 < quads; z0 += kCellQuads) {
        for (int x0 = 0; x0 < quads; x0 += kCellQuads) {
            const int nx = std::min(kCellQuads, quads - x0), nz = std::min(kCellQuads, quads - z0);
            const double low_x = x0 * terrain.spacing_m - 0.5 * terrain.size_m;
            const double low_z = z0 * terrain.spacing_m - 0.5 * terrain.size_m;
            MeshSource mesh;
            for (int j = 0; j <= nz; ++j) {
                for (int i = 0; i <= nx; ++i) {
                    const double x = i * terrain.spacing_m, z = j * terrain.spacing_m;
                    const auto height = [&](double dx, double dz) {
                        return terrain_height(low_x + x + dx, low_z + z + dz, terrain.relief_m);
                    };
                    const Vec3 normal(float(height(-0.5, 0) - height(0.5, 0)), 1.0f,
                                      float(height(0, -0.5) - height(0, 0.5)));
                    add_vertex(mesh, Vec3(float(x), float(height(0, 0)), float(z)), normal,
                               Vec2(float(x) * 0.1f, float(z) * 0.1f));
                }
            }
            const auto row = std::uint32_t(nx + 1);
            for (std::uint32_t j = 0; j < std::uint32_t(nz); ++j) {
                for (std::uint32_t i = 0; i < std::uint32_t(nx); ++i) {
                    const std::uint32_t v = j * row + i;
                    add_indices(mesh, v, v + row, v + row + 1, 0);
                    add_indices(mesh, v, v + row + 1, v + 1, 0);
                }
            }
            const std::uint32_t id = add_prepared(scene, std::move(mesh));
            scene.add_instance(id, world.origin + WorldPos(low_x, 0.0, low_z), Mat3(1.0f), cell++);
        }
    }
    scene.finish(world.height_grid_size);
    return scene;
}

SceneData make_forest(const ForestSettings& forest, const WorldSettings& world) {
    constexpr int kKinds = 4;
    constexpr int kCells = 4;
    SceneData scene;
    scene.materials.push_back(plain_material());
    const auto leaf = forest.masked ? std::uint16_t(add_leaf_material(scene)) : std::uint16_t(0);
    Random random(world.seed);
    std::uint32_t kinds[kKinds];
    for (std::uint32_t& kind : kinds) kind = add_prepared(scene, make_tree(random, forest, 0, leaf));
    const auto half = float(0.5 * forest.size_m);
    MeshSource ground;
    append_patch(ground, Vec3(-half, 0, -half), Vec3(0, 0, 2 * half), Vec3(2 * half, 0, 0), 16, 0);
    scene.add_instance(add_prepared(scene, std::move(ground)), world.origin, Mat3(1.0f), 0);
    for (int i = 0; i < forest.trees; ++i) {
        const double x = random.in(-half, half), z = random.in(-half, half), yaw = random.in(0.0, 2.0 * kPi);
        const auto size = float(random.in(0.7, 1.4));
        const Vec3 scale(random.below(3) == 0 ? -size : size, size, size);
        const auto square = [&](double p) { return std::min(kCells - 1, int((p + half) / forest.size_m * kCells)); };
        scene.add_instance(kinds[random.below(kKinds)], world.origin + WorldPos(x, 0.0, z),
                           turned_and_scaled(yaw, scale), std::uint32_t(1 + square(z) * kCells + square(x)));
    }
    scene.finish(world.height_grid_size);
    return scene;
}

SceneData make_triangle_soup(const SoupSettings& soup, const WorldSettings& world) {
    SceneData scene;
    scene.materials.push_back(plain_material());
    const auto masked = soup.masked ? std::uint16_t(add_leaf_material(scene)) : std::uint16_t(0);
    Random random(world.seed);
    const Vec3 half(float(0.5 * soup.size_m)), edge(float(0.5 * soup.edge_m));
    for (int m = 0; m < soup.meshes; ++m) {
        MeshSource mesh;
        for (int i = 0; i < soup.triangles; ++i) {
            const Vec3 at = random.in_box(-half, half);
            Vec3 p[3];
            for (Vec3& corner : p) corner = at + random.in_box(-edge, edge);
            const std::uint32_t kind = random.below(20);
            if (kind == 0) p[2] = p[0] + (p[1] - p[0]) * float(random.unit());                       // no area
            if (kind == 1) p[2] = p[0] + (p[1] - p[0]) * 0.5f + random.in_box(-edge, edge) * 1e-5f;  // a sliver
            if (kind == 2) p[1] = p[0];
            const auto material = i % 2 == 1 ? masked : std::uint16_t(0);
            append_triangle(mesh, p[0], p[1], p[2], material);
            if (kind == 3) append_triangle(mesh, p[0], p[1], p[2], material);  // the same again
        }
        const std::uint32_t id = add_prepared(scene, std::move(mesh));
        scene.add_instance(id, world.origin, Mat3(1.0f), 0);
        const double yaw = random.in(0.0, 2.0 * kPi);
        const Vec3 scale =
            random.in_box(Vec3(0.5f), Vec3(2.0f)) * Vec3(random.below(2) == 0 ? -1.0f : 1.0f, 1.0f, 1.0f);
        const Vec3 offset = random.in_box(-half, half);
        scene.add_instance(id, world.origin + WorldPos(offset), turned_and_scaled(yaw, scale), 1);
    }
    scene.finish(world.height_grid_size);
    return scene;
}

SceneData make_single_triangle(const Vec3& a, const Vec3& b, const Vec3& c, const WorldSettings& world) {
    SceneData scene;
    scene.materials.push_back(plain_material());
    MeshSource mesh;
    append_triangle(mesh, a, b, c, 0);
    scene.add_instance(add_prepared(scene, std::move(mesh)), world.origin, Mat3(1.0f), 0);
    scene.finish(world.height_grid_size);
    return scene;
}

SceneData make_closed_sphere(double radius_m, int rings, double bump, const WorldSettings& world) {
    SceneData scene;
    scene.materials.push_back(plain_material());
    MeshSource mesh;
    const int columns = 2 * rings;
    // Vertices of a column and its wrap-around are the same ids, so the surface is closed to the bit.
    const auto vertex = [&](int ring, int column) {
        if (ring == 0) return 0u;
        if (ring == rings) return 1u;
        return std::uint32_t(2 + (ring - 1) * columns + column % columns);
    };
    const auto add = [&](double theta, double phi) {
        const double r = radius_m * (1.0 + bump * std::sin(7.0 * theta) * std::cos(5.0 * phi) * std::sin(theta));
        const Vec3 direction(float(std::sin(theta) * std::cos(phi)), float(std::cos(theta)),
                             float(std::sin(theta) * std::sin(phi)));
        add_vertex(mesh, direction * float(r), direction, Vec2(float(phi), float(theta)));
    };
    add(0.0, 0.0);
    add(kPi, 0.0);
    for (int ring = 1; ring < rings; ++ring) {
        for (int column = 0; column < columns; ++column) add(kPi * ring / rings, 2.0 * kPi * column / columns);
    }
    for (int ring = 0; ring < rings; ++ring) {
        for (int column = 0; column < columns; ++column) {
            const std::uint32_t a = vertex(ring, column), b = vertex(ring, column + 1);
            const std::uint32_t c = vertex(ring + 1, column), d = vertex(ring + 1, column + 1);
            if (ring > 0) add_indices(mesh, a, b, c, 0);
            if (ring < rings - 1) add_indices(mesh, b, d, c, 0);
        }
    }
    scene.add_instance(add_prepared(scene, std::move(mesh)), world.origin, Mat3(1.0f), 0);
    scene.finish(world.height_grid_size);
    return scene;
}

Camera random_camera(Random& random, const DBox3& box) {
    Camera camera;
    for (int axis = 0; axis < 3; ++axis) camera.position[axis] = random.in(box.low[axis], box.high[axis]);
    camera.yaw = random.in(-kPi, kPi);
    camera.pitch = random.in(-0.5 * kPi, 0.5 * kPi);
    camera.roll = random.in(-kPi, kPi);
    camera.vertical_fov = radians_of(random.in(30.0, 110.0));
    return camera;
}

}  // namespace ff::test
