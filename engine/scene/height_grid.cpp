// The max-height grid over the scene, for horizon tracing (P0 section 6). A mesh's hierarchy is walked from the top: a
// box over one square answers for all that is in it, so that a distant forest costs a step per tree. Boxes and planes
// only ever raise a square: the grid stays an upper bound.

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>

#include "engine/core/check.h"
#include "engine/core/jobs.h"
#include "engine/scene/instance_bounds.h"
#include "engine/scene/scene_data.h"

namespace ff::scene {
namespace {

constexpr float kNothing = -std::numeric_limits<float>::infinity();

// Squares [x0, x1] x [z0, z1], both ends included.
struct SquareRange {
    int x0, x1, z0, z1;
    [[nodiscard]] bool is_one() const { return x0 == x1 && z0 == z1; }
};

class HeightRaster {
  public:
    HeightRaster(const SceneData& scene, const HeightGrid& grid, std::span<float> level0)
        : scene_(scene), grid_(grid), level0_(level0) {}

    void add(const Instance& instance) {
        const Mesh& mesh = scene_.meshes[instance.mesh];
        if (mesh.node_count != 0) add_node(instance, mesh, 0);
    }

  private:
    [[nodiscard]] double square_x(double x) const { return (x - grid_.low_x) / grid_.square_m; }
    [[nodiscard]] double square_z(double z) const { return (z - grid_.low_z) / grid_.square_m; }

    // A hair more than the box, so that rounding never loses a square.
    [[nodiscard]] SquareRange squares(double x0, double x1, double z0, double z1) const {
        constexpr double hair = 1e-6;
        const double last = double(grid_.size - 1);
        return {int(std::clamp(x0 - hair, 0.0, last)), int(std::clamp(x1 + hair, 0.0, last)),
                int(std::clamp(z0 - hair, 0.0, last)), int(std::clamp(z1 + hair, 0.0, last))};
    }

    // Other workers may raise the same square; the maximum does not depend on who comes first.
    void raise(int x, int z, float height) {
        std::atomic_ref<float> square(level0_[std::size_t(z) * grid_.size + std::size_t(x)]);
        float seen = square.load(std::memory_order_relaxed);
        while (seen < height && !square.compare_exchange_weak(seen, height, std::memory_order_relaxed)) {
        }
    }

    [[nodiscard]] float height_of(double y) const {
        return std::nextafter(float(y - grid_.base_y), std::numeric_limits<float>::infinity());
    }

    void add_node(const Instance& instance, const Mesh& mesh, std::uint32_t id) {
        const BvhNode& node = scene_.mesh_nodes[mesh.first_node + id];
        for (int lane = 0; lane < kBvhWidth; ++lane) {
            const std::uint32_t child = node.child[lane];
            if (child == kBvhEmpty) continue;
            const DBox3 box = world_box(instance, Box3{Vec3(node.low_x[lane], node.low_y[lane], node.low_z[lane]),
                                                       Vec3(node.high_x[lane], node.high_y[lane], node.high_z[lane])});
            const SquareRange range =
                squares(square_x(box.low.x), square_x(box.high.x), square_z(box.low.z), square_z(box.high.z));
            if (range.is_one()) {
                raise(range.x0, range.z0, height_of(box.high.y));
            } else if (!(child & kBvhLeafBit)) {
                add_node(instance, mesh, child);
            } else {
                add_leaf(instance, scene_.mesh_leaves[mesh.first_leaf + (child & ~kBvhLeafBit)]);
            }
        }
    }

    void add_leaf(const Instance& instance, const BvhLeaf& leaf) {
        const DMat3 world_from_mesh(instance.world_from_mesh);
        for (int i = 0; i < leaf.triangle_count; ++i) {
            DVec3 corners[3];  // x, z in squares, y above the base
            for (int c = 0; c < 3; ++c) {
                const int v = leaf.corner[c][i];
                const DVec3 p = instance.position + world_from_mesh * DVec3(leaf.x[v], leaf.y[v], leaf.z[v]);
                corners[c] = DVec3(square_x(p.x), p.y, square_z(p.z));
            }
            add_triangle(corners);
        }
    }

    void add_triangle(const DVec3 (&p)[3]) {
        const double low_x = std::min({p[0].x, p[1].x, p[2].x}), high_x = std::max({p[0].x, p[1].x, p[2].x});
        const double low_z = std::min({p[0].z, p[1].z, p[2].z}), high_z = std::max({p[0].z, p[1].z, p[2].z});
        const double top = std::max({p[0].y, p[1].y, p[2].y});
        const SquareRange range = squares(low_x, high_x, low_z, high_z);
        // Height over the plan as y = y0 + dx (x - x0) + dz (z - z0), where the triangle is not upright.
        const DVec3 a = p[1] - p[0], b = p[2] - p[0];
        const double det = a.x * b.z - b.x * a.z;
        const bool upright = std::abs(det) < 1e-9;
        const double dx = upright ? 0.0 : (a.y * b.z - b.y * a.z) / det;
        const double dz = upright ? 0.0 : (a.x * b.y - b.x * a.y) / det;
        for (int z = range.z0; z <= range.z1; ++z) {
            const auto [row_low, row_high] = row_interval(p, z);
            if (row_low > row_high) continue;
            const SquareRange row = squares(row_low, row_high, z, z);
            for (int x = row.x0; x <= row.x1; ++x) {
                double height = top;
                if (!upright) {
                    const double over = p[0].y + dx * (double(x) + (dx > 0) - p[0].x) +
                                        dz * (double(z) + (dz > 0) - p[0].z) + 1e-6 * (std::abs(dx) + std::abs(dz));
                    height = std::min(top, over);
                }
                raise(x, z, height_of(height));
            }
        }
    }

    // The x interval of the triangle within a row of squares.
    [[nodiscard]] static std::pair<double, double> row_interval(const DVec3 (&p)[3], int z) {
        constexpr double hair = 1e-6;
        const double z0 = double(z) - hair, z1 = double(z) + 1.0 + hair;
        double low = std::numeric_limits<double>::infinity(), high = -low;
        const auto include = [&](double x) {
            low = std::min(low, x);
            high = std::max(high, x);
        };
        for (int i = 0; i < 3; ++i) {
            const DVec3 &a = p[i], &b = p[(i + 1) % 3];
            if (a.z >= z0 && a.z <= z1) include(a.x);
            for (const double border : {z0, z1}) {
                if ((a.z < border) != (b.z < border)) include(a.x + (b.x - a.x) * ((border - a.z) / (b.z - a.z)));
            }
        }
        return {low, high};
    }

    const SceneData& scene_;
    const HeightGrid& grid_;
    std::span<float> level0_;
};

}  // namespace

void build_height_grid(const SceneData& scene, std::uint32_t size, HeightGrid& grid, std::vector<float>& heights) {
    FF_CHECK(size >= 16 && size <= 4096 && (size & (size - 1)) == 0, "{} squares a side", size);
    grid = HeightGrid{};
    heights.clear();
    if (scene.bounds.is_empty()) return;
    const DVec3 extent = scene.bounds.extent();
    grid.size = size;
    grid.square_m = std::max({extent.x, extent.z, 1e-3}) / double(size) * (1.0 + 1e-9);
    const DVec3 center = scene.bounds.center();
    grid.low_x = center.x - 0.5 * grid.square_m * double(size);
    grid.low_z = center.z - 0.5 * grid.square_m * double(size);
    grid.base_y = scene.bounds.low.y;

    std::size_t total = 0;
    for (std::uint32_t level_size = size; level_size > 0; level_size /= 2)
        total += std::size_t(level_size) * level_size;
    heights.assign(total, kNothing);
    HeightRaster raster(scene, grid, std::span(heights).first(std::size_t(size) * size));
    parallel_ranges(scene.instances.size(), 16, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) raster.add(scene.instances[i]);
    });

    float* fine = heights.data();
    for (std::size_t fine_size = size; fine_size > 1; fine_size /= 2) {
        float* coarse = fine + fine_size * fine_size;
        const std::size_t half = fine_size / 2;
        for (std::size_t z = 0; z < half; ++z) {
            for (std::size_t x = 0; x < half; ++x) {
                const float* at = fine + 2 * z * fine_size + 2 * x;
                coarse[z * half + x] = std::max(std::max(at[0], at[1]), std::max(at[fine_size], at[fine_size + 1]));
            }
        }
        fine = coarse;
    }
}

}  // namespace ff::scene
