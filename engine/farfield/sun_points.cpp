// Pixels to points: which triangles a tile sees, each once; then their places and offsets a register at a time.

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "engine/farfield/sun_points.cpp"
#include <hwy/foreach_target.h>  // must come before highway.h
#include <hwy/highway.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>

#include "engine/farfield/sun_points.h"

HWY_BEFORE_NAMESPACE();
namespace ff::farfield::sun {
namespace HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;
using F = hn::CappedTag<float, 16>;
using VF = hn::Vec<F>;
constexpr F f;
constexpr hn::RebindToSigned<F> si;
constexpr hn::RebindToUnsigned<F> ui;
constexpr int kLanes = int(hn::MaxLanes(f));
constexpr int kPixels = kTileSize * kTileSize;

// The triangles that a tile sees, each once; looked up step by step, since each step waits for memory.
struct Surfaces {
    static constexpr int kSlots = 512;
    int count = 0;
    std::uint32_t instance[kPixels], triangle[kPixels];
    const scene::Instance* placed[kPixels];
    const scene::Mesh* mesh[kPixels];
    const std::uint32_t* indices[kPixels];
    float s[kPixels], t[kPixels], d[kPixels];  // unit normal in light space; zero for a triangle without area
    float offset[kPixels];                     // at depth 0
    std::uint16_t slots[kSlots];               // index + 1; 0: free

    HWY_INLINE Surfaces() { std::fill_n(slots, kSlots, std::uint16_t(0)); }

    HWY_INLINE int find_or_add(std::uint32_t of_instance, std::uint32_t of_triangle) {
        std::uint32_t slot = (of_instance * 0x9E3779B1u ^ of_triangle * 0x85EBCA77u) >> 23;
        for (;; slot = (slot + 1) % kSlots) {
            const int found = int(slots[slot]) - 1;
            if (found < 0) break;
            if (instance[found] == of_instance && triangle[found] == of_triangle) return found;
        }
        instance[count] = of_instance;
        triangle[count] = of_triangle;
        slots[slot] = std::uint16_t(count + 1);
        return count++;
    }
};

HWY_INLINE void look_up(const scene::StaticScene& scene, std::span<const scene::Instance> dynamic,
                        const LightFrame& light, Surfaces& all) {
    const std::size_t static_count = scene.instances.size();
    for (int i = 0; i < all.count; ++i) {
        all.placed[i] = all.instance[i] < static_count ? &scene.instances[all.instance[i]]
                                                       : &dynamic[all.instance[i] - static_count];
        __builtin_prefetch(all.placed[i]);
        __builtin_prefetch(reinterpret_cast<const char*>(all.placed[i]) + 64);
    }
    for (int i = 0; i < all.count; ++i) {
        all.mesh[i] = &scene.meshes[all.placed[i]->mesh];
        __builtin_prefetch(all.mesh[i]);
    }
    for (int i = 0; i < all.count; ++i) {
        all.indices[i] = &scene.indices[3 * (std::size_t(all.mesh[i]->first_triangle) + all.triangle[i])];
        __builtin_prefetch(all.indices[i]);
        __builtin_prefetch(all.indices[i] + 2);
    }
    const auto vertex_of = [&](int i, int corner) {
        return &scene.positions[all.mesh[i]->first_vertex + all.indices[i][corner]];
    };
    for (int i = 0; i < all.count; ++i)
        for (int corner = 0; corner < 3; ++corner) __builtin_prefetch(vertex_of(i, corner));
    const Vec3 s(light.s), t(light.t), d(light.d);
    for (int i = 0; i < all.count; ++i) {
        const Mat3& m = all.placed[i]->world_from_mesh;
        const Vec3 a = *vertex_of(i, 0), b = *vertex_of(i, 1), c = *vertex_of(i, 2);
        const Vec3 normal = glm::cross(m * (b - a), m * (c - a));
        const float squared = glm::dot(normal, normal);
        const float per_length = squared > 0.0f ? 1.0f / std::sqrt(squared) : 0.0f;
        all.s[i] = glm::dot(normal, s) * per_length;
        all.t[i] = glm::dot(normal, t) * per_length;
        all.d[i] = glm::dot(normal, d) * per_length;
        all.offset[i] = sun_ray_offset(0.0f, reach_of(*all.mesh[i], *all.placed[i]));
    }
}

// The pixels of a tile that see something, in blocks of 8 x 8, so that a group is a square.
struct Pixels {
    int count = 0;
    alignas(64) float x[kPixels], y[kPixels], depth[kPixels];
    alignas(64) std::int32_t surface[kPixels];
    alignas(64) std::uint32_t at[kPixels];
};

using E = hn::CappedTag<float, 8>;
constexpr E ef;
constexpr hn::RebindToSigned<E> ei;
constexpr hn::RebindToUnsigned<E> eu;
constexpr int kEightLanes = int(hn::MaxLanes(ef));

// Whether eight numbers are all this one.
HWY_INLINE bool is_everywhere(const std::uint32_t* eight, std::uint32_t number) {
    bool is_all = true;
    for (int i = 0; i < 8; i += kEightLanes)
        is_all &= hn::AllTrue(eu, hn::Eq(hn::LoadU(eu, eight + i), hn::Set(eu, number)));
    return is_all;
}

HWY_INLINE void find_pixels(const PinholeView& view, const VisibilityBuffer& visibility, const TileRequest& tile,
                            std::uint8_t* lit, Surfaces& surfaces, Pixels& pixels) {
    const int columns = std::min(kTileSize, view.width - int(tile.x));
    const int rows = std::min(kTileSize, view.height - int(tile.y));
    if (columns <= 0 || rows <= 0) return;
    // All at once: what is decided pixel by pixel would wait for each by itself.
    alignas(64) std::uint32_t instances[kPixels], triangles[kPixels];
    alignas(64) float depths[kPixels];
    for (int row = 0; row < rows; ++row) {
        if (tile.rows[row] == 0) continue;
        const std::size_t at = visibility.index(tile.x, tile.y + row);
        for (int i = 0; i < kTileSize; i += kLanes) {
            const int to = row * kTileSize + i;
            hn::Store(hn::LoadU(ui, visibility.instance.data() + at + i), ui, instances + to);
            hn::Store(hn::LoadU(ui, visibility.triangle.data() + at + i), ui, triangles + to);
            hn::Store(hn::LoadU(f, visibility.depth.data() + at + i), f, depths + to);
        }
    }
    std::uint32_t last_instance = kSkyInstance, last_triangle = 0;
    int last = 0;
    for (int block = 0; block < 4; ++block) {
        const int first_column = block % 2 * 8, first_row = block / 2 * 8;
        for (int row = first_row; row < std::min(first_row + 8, rows); ++row) {
            std::uint32_t bits = tile.rows[row] & ((1u << columns) - 1u) & 0xFFu << first_column;
            const std::size_t row_at = visibility.index(tile.x, tile.y + row);
            // Mostly a row sees one triangle.
            const std::size_t eight_at = row_at + std::size_t(first_column);
            if (bits == 0xFFu << first_column && last_instance < kUnresolved &&
                is_everywhere(instances + row * kTileSize + first_column, last_instance) &&
                is_everywhere(triangles + row * kTileSize + first_column, last_triangle)) {
                for (int i = 0; i < 8; i += kEightLanes) {
                    const int to = pixels.count + i;
                    hn::StoreU(hn::Iota(ef, float(tile.x + first_column + i)), ef, pixels.x + to);
                    hn::StoreU(hn::Set(ef, float(tile.y + row)), ef, pixels.y + to);
                    hn::StoreU(hn::LoadU(ef, depths + row * kTileSize + first_column + i), ef, pixels.depth + to);
                    hn::StoreU(hn::Set(ei, last), ei, pixels.surface + to);
                    hn::StoreU(hn::Iota(eu, std::uint32_t(eight_at) + std::uint32_t(i)), eu, pixels.at + to);
                }
                pixels.count += 8;
                std::fill_n(lit + eight_at, 8, std::uint8_t(0));
                continue;
            }
            for (; bits != 0; bits &= bits - 1) {
                const int column = std::countr_zero(bits);
                const std::size_t at = row_at + std::size_t(column);
                const int from = row * kTileSize + column;
                const std::uint32_t instance = instances[from], triangle = triangles[from];
                if (instance != last_instance || triangle != last_triangle) {
                    last_instance = instance;
                    last_triangle = triangle;
                    if (instance < kUnresolved) last = surfaces.find_or_add(instance, triangle);
                }
                // Those that get a ray are answered once more.
                lit[at] = instance >= kUnresolved ? 255 : 0;
                if (instance >= kUnresolved) continue;
                const int to = pixels.count++;
                pixels.x[to] = float(tile.x + column);
                pixels.y[to] = float(tile.y + row);
                pixels.depth[to] = depths[from];
                pixels.surface[to] = last;
                pixels.at[to] = std::uint32_t(at);
            }
        }
    }
}

// Of the points stored from `first` on, leaves those whose bits are set.
HWY_INLINE void keep(PointPool& pool, int first, std::uint32_t bits) {
    int to = first;
    for (; bits != 0; bits &= bits - 1, ++to) {
        const int from = first + std::countr_zero(bits);
        pool.s[to] = pool.s[from], pool.t[to] = pool.t[from], pool.d[to] = pool.d[from];
        pool.footprint[to] = pool.footprint[from];
        pool.own_instance[to] = pool.own_instance[from], pool.own_triangle[to] = pool.own_triangle[from];
        pool.answer[to] = pool.answer[from];
    }
    pool.count = to;
}

}  // namespace

void GatherTile(const scene::StaticScene& scene, std::span<const scene::Instance> dynamic, const PinholeView& view,
                const LightFrame& light, const VisibilityBuffer& visibility, const TileRequest& tile, std::uint8_t* lit,
                PointPool& pool) {
    Surfaces surfaces;
    Pixels pixels;
    find_pixels(view, visibility, tile, lit, surfaces, pixels);
    look_up(scene, dynamic, light, surfaces);

    const DMat3 world_from_camera(view.world_from_camera);
    Vec3 light_from_camera[3];  // rows
    for (int column = 0; column < 3; ++column) {
        light_from_camera[0][column] = float(glm::dot(light.s, world_from_camera[column]));
        light_from_camera[1][column] = float(glm::dot(light.t, world_from_camera[column]));
        light_from_camera[2][column] = float(glm::dot(light.d, world_from_camera[column]));
    }
    const float per_depth = sun_ray_offset(1.0f, 0.0f);
    for (int i = 0; i < pixels.count; i += kLanes) {
        const auto valid = hn::FirstN(f, std::size_t(pixels.count - i));
        const VF half = hn::Set(f, 0.5f), depth = hn::Load(f, pixels.depth + i);
        const VF u =
            hn::MulAdd(hn::Add(hn::Load(f, pixels.x + i), half), hn::Set(f, view.u_step), hn::Set(f, view.u_first));
        const VF v =
            hn::MulAdd(hn::Add(hn::Load(f, pixels.y + i), half), hn::Set(f, view.v_step), hn::Set(f, view.v_first));
        const auto surface = hn::IfThenElseZero(hn::RebindMask(si, valid), hn::Load(si, pixels.surface + i));
        const auto along = [&](const Vec3& row) {
            return hn::MulAdd(hn::Set(f, row.x), u, hn::MulSub(hn::Set(f, row.y), v, hn::Set(f, row.z)));
        };
        const VF s = along(light_from_camera[0]), t = along(light_from_camera[1]), d = along(light_from_camera[2]);
        VF normal_s = hn::GatherIndex(f, surfaces.s, surface), normal_t = hn::GatherIndex(f, surfaces.t, surface);
        VF normal_d = hn::GatherIndex(f, surfaces.d, surface);
        // The side that faces the viewer.
        const VF away = hn::MulAdd(normal_s, s, hn::MulAdd(normal_t, t, hn::Mul(normal_d, d)));
        const VF flip = hn::IfThenElseZero(hn::Gt(away, hn::Zero(f)), hn::Set(f, -0.0f));
        normal_s = hn::Xor(normal_s, flip), normal_t = hn::Xor(normal_t, flip), normal_d = hn::Xor(normal_d, flip);
        const auto has_place = hn::Lt(depth, hn::Set(f, std::numeric_limits<float>::max()));
        const auto sunny = hn::And(hn::And(valid, has_place), hn::Gt(normal_d, hn::Zero(f)));
        const VF offset = hn::MulAdd(hn::Set(f, per_depth), depth, hn::GatherIndex(f, surfaces.offset, surface));
        const int to = pool.count;
        hn::StoreU(hn::MulAdd(depth, s, hn::Mul(offset, normal_s)), f, pool.s + to);
        hn::StoreU(hn::MulAdd(depth, t, hn::Mul(offset, normal_t)), f, pool.t + to);
        hn::StoreU(hn::MulAdd(depth, d, hn::Mul(offset, normal_d)), f, pool.d + to);
        hn::StoreU(hn::Mul(depth, hn::Set(f, view.pixel_angle())), f, pool.footprint + to);
        hn::StoreU(hn::GatherIndex(ui, surfaces.instance, surface), ui, pool.own_instance + to);
        hn::StoreU(hn::GatherIndex(ui, surfaces.triangle, surface), ui, pool.own_triangle + to);
        hn::StoreU(hn::Load(ui, pixels.at + i), ui, pool.answer + to);
        std::uint8_t bytes[8] = {};
        hn::StoreMaskBits(f, sunny, bytes);
        const std::uint32_t bits = kLanes > 8 ? std::uint32_t(bytes[0] | bytes[1] << 8) : bytes[0];
        if (bits == (1u << kLanes) - 1u)
            pool.count += kLanes;
        else
            keep(pool, to, bits);
    }
}

}  // namespace HWY_NAMESPACE
}  // namespace ff::farfield::sun
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace ff::farfield::sun {
HWY_EXPORT(GatherTile);

void gather_tile(const scene::StaticScene& scene, std::span<const scene::Instance> dynamic, const PinholeView& view,
                 const LightFrame& light, const VisibilityBuffer& visibility, const TileRequest& tile,
                 std::uint8_t* lit, PointPool& pool) {
    HWY_DYNAMIC_DISPATCH(GatherTile)(scene, dynamic, view, light, visibility, tile, lit, pool);
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
    // A group's origin is one of its points: none may be without a place.
    if (!std::isfinite(start.x + start.y + start.z)) {
        lit[answer] = 255;
        return;
    }
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
    std::fill(group.s + count, std::end(group.s), group.s[count - 1]);
    std::fill(group.t + count, std::end(group.t), group.t[count - 1]);
    std::fill(group.d + count, std::end(group.d), group.d[count - 1]);
    std::copy_n(pool.footprint + first, count, group.footprint);
    std::copy_n(pool.own_instance + first, count, group.own_instance);
    std::copy_n(pool.own_triangle + first, count, group.own_triangle);
    return count;
}

}  // namespace ff::farfield::sun
#endif
