#include "engine/farfield/sun_points.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <glm/geometric.hpp>

namespace ff::farfield::sun {
namespace {

constexpr int kPixels = kTileSize * kTileSize;

// A triangle that some pixel of a tile sees.
struct Surface {
    std::uint32_t instance, triangle;
    const scene::Instance* placed;
    Vec3 normal;  // world, unit; zero for a triangle without area
    float reach_m;
};

// The triangles that a tile sees, each once; looked up step by step, since each step waits for memory.
struct Surfaces {
    static constexpr int kSlots = 512;
    int count = 0;
    Surface surface[kPixels];
    std::uint16_t slots[kSlots];  // index + 1; 0: free

    Surfaces() { std::fill_n(slots, kSlots, std::uint16_t(0)); }

    int find_or_add(std::uint32_t instance, std::uint32_t triangle) {
        std::uint32_t slot = (instance * 0x9E3779B1u ^ triangle * 0x85EBCA77u) >> 23;
        for (;; slot = (slot + 1) % kSlots) {
            if (slots[slot] == 0) {
                surface[count].instance = instance;
                surface[count].triangle = triangle;
                slots[slot] = std::uint16_t(++count);
                return count - 1;
            }
            const Surface& found = surface[slots[slot] - 1];
            if (found.instance == instance && found.triangle == triangle) return slots[slot] - 1;
        }
    }
};

void look_up(const scene::StaticScene& scene, std::span<const scene::Instance> dynamic, Surfaces& surfaces) {
    const std::span<Surface> all(surfaces.surface, std::size_t(surfaces.count));
    const std::size_t static_count = scene.instances.size();
    for (Surface& surface : all) {
        surface.placed = surface.instance < static_count ? &scene.instances[surface.instance]
                                                         : &dynamic[surface.instance - static_count];
        __builtin_prefetch(surface.placed);
        __builtin_prefetch(reinterpret_cast<const char*>(surface.placed) + 64);
    }
    const auto indices_of = [&](const Surface& surface) {
        return &scene.indices[3 * (std::size_t(scene.meshes[surface.placed->mesh].first_triangle) + surface.triangle)];
    };
    for (const Surface& surface : all) {
        __builtin_prefetch(indices_of(surface));
        __builtin_prefetch(indices_of(surface) + 2);
    }
    const auto vertex_of = [&](const Surface& surface, int corner) {
        return &scene.positions[scene.meshes[surface.placed->mesh].first_vertex + indices_of(surface)[corner]];
    };
    for (const Surface& surface : all)
        for (int corner = 0; corner < 3; ++corner) __builtin_prefetch(vertex_of(surface, corner));
    for (Surface& surface : all) {
        const Mat3& m = surface.placed->world_from_mesh;
        const Vec3 a = *vertex_of(surface, 0), b = *vertex_of(surface, 1), c = *vertex_of(surface, 2);
        const Vec3 normal = glm::cross(m * (b - a), m * (c - a));
        const float length = glm::length(normal);
        surface.normal = length > 0.0f ? normal / length : Vec3(0.0f);
        surface.reach_m = reach_of(scene.meshes[surface.placed->mesh], *surface.placed);
    }
}

// Column and row of the i-th pixel of a tile: blocks of 8 x 8, so that a group is a square.
constexpr int column_of(int i) {
    return i / 64 % 2 * 8 + i % 8;
}
constexpr int row_of(int i) {
    return i / 128 * 8 + i / 8 % 8;
}

}  // namespace

void gather_tile(const scene::StaticScene& scene, std::span<const scene::Instance> dynamic, const PinholeView& view,
                 const LightFrame& light, const VisibilityBuffer& visibility, const TileRequest& tile,
                 std::uint8_t* lit, PointPool& pool) {
    Surfaces surfaces;
    std::uint16_t surface_of[kPixels], pixel_of[kPixels];
    int count = 0;
    for (int i = 0; i < kPixels; ++i) {
        const int column = column_of(i), row = row_of(i);
        if (((tile.rows[row] >> column) & 1u) == 0) continue;
        if (tile.x + column >= view.width || tile.y + row >= view.height) continue;
        const std::size_t at = visibility.index(tile.x + column, tile.y + row);
        const std::uint32_t instance = visibility.instance[at];
        if (instance == kSkyInstance || instance == kUnresolved) {
            lit[at] = 255;
            continue;
        }
        surface_of[count] = std::uint16_t(surfaces.find_or_add(instance, visibility.triangle[at]));
        pixel_of[count++] = std::uint16_t(i);
    }
    look_up(scene, dynamic, surfaces);

    const Vec3 s(light.s), t(light.t), d(light.d);
    for (int i = 0; i < count; ++i) {
        const Surface& surface = surfaces.surface[surface_of[i]];
        const int x = tile.x + column_of(pixel_of[i]), y = tile.y + row_of(pixel_of[i]);
        const std::size_t at = visibility.index(x, y);
        const Vec3 direction = view.direction(x, y);
        const Vec3 normal = glm::dot(surface.normal, direction) > 0.0f ? -surface.normal : surface.normal;
        if (!(glm::dot(normal, d) > 0.0f)) {
            lit[at] = 0;
            continue;
        }
        const float depth = visibility.depth[at];
        const Vec3 point = depth * direction + sun_ray_offset(depth, surface.reach_m) * normal;
        const int to = pool.count++;
        pool.s[to] = glm::dot(s, point);
        pool.t[to] = glm::dot(t, point);
        pool.d[to] = glm::dot(d, point);
        pool.footprint[to] = depth * view.pixel_angle();
        pool.own_instance[to] = surface.instance;
        pool.own_triangle[to] = surface.triangle;
        pool.answer[to] = std::uint32_t(at);
    }
}

void gather_point(const SunPoint& point, std::uint32_t answer, const LightFrame& light, std::uint8_t* lit,
                  PointPool& pool) {
    const Vec3 s(light.s), t(light.t), d(light.d);
    const bool has_surface = point.normal != Vec3(0.0f);
    if (has_surface && !(glm::dot(point.normal, d) > 0.0f)) {
        lit[answer] = 0;
        return;
    }
    const Vec3 start = point.position + point.offset_m * point.normal;
    const int to = pool.count++;
    pool.s[to] = glm::dot(s, start);
    pool.t[to] = glm::dot(t, start);
    pool.d[to] = glm::dot(d, start);
    pool.footprint[to] = point.footprint_m;
    pool.own_instance[to] = kSkyInstance;
    pool.own_triangle[to] = 0;
    pool.answer[to] = answer;
}

int make_group(const PointPool& pool, int first, const WorldPos& eye, const LightFrame& light, PointGroup& group) {
    const int count = std::min(PointGroup::kMost, pool.count - first);
    const float s = pool.s[first], t = pool.t[first], d = pool.d[first];
    group.count = count;
    group.centre = eye + light.s * double(s) + light.t * double(t) + light.d * double(d);
    group.left = count < 64 ? (std::uint64_t(1) << count) - 1u : ~std::uint64_t(0);
    for (int i = 0; i < count; ++i) {
        group.s[i] = pool.s[first + i] - s;
        group.t[i] = pool.t[first + i] - t;
        group.d[i] = pool.d[first + i] - d;
    }
    std::copy_n(pool.footprint + first, count, group.footprint);
    std::copy_n(pool.own_instance + first, count, group.own_instance);
    std::copy_n(pool.own_triangle + first, count, group.own_triangle);
    return count;
}

}  // namespace ff::farfield::sun
