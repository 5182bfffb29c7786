// The ray caster of P0 4.2 over regular grids.

#include <glm/matrix.hpp>

#include "engine/core/check.h"
#include "engine/core/jobs.h"
#include "engine/core/stopwatch.h"
#include "engine/farfield/cast_cost_sum.h"
#include "engine/farfield/float_ray.h"
#include "engine/farfield/grid_traversal.h"

namespace ff::farfield {
namespace {

constexpr std::size_t kTilesPerTask = 8;
constexpr std::size_t kRaysPerTask = 256;

class GridCaster final : public RayCaster {
  public:
    GridCaster(const scene::StaticScene& scene, double cells_per_item) {
        const Stopwatch watch;
        world_.scene = scene;
        // Poses change, and none stands in the static scene.
        world_.meshes.resize(scene.meshes.size() - scene.posed_mesh_count);
        parallel_for(world_.meshes.size(), [&](std::size_t m) {
            world_.meshes[m] = grid::make_mesh_grid(scene, scene.meshes[m], cells_per_item);
        });
        world_.top = grid::make_instance_grid(scene, cells_per_item);
        world_.placements.reserve(scene.instances.size());
        for (const scene::Instance& instance : scene.instances) {
            const bool is_turned = instance.world_from_mesh != Mat3(1.0f);
            const Mat3 inverse = is_turned ? Mat3(glm::inverse(DMat3(instance.world_from_mesh))) : Mat3(1.0f);
            world_.placements.push_back({inverse, is_turned});
        }
        build_seconds_ = watch.seconds();
    }

    CastCost cast_tiles(const PinholeView& view, std::span<const TileRequest> tiles, VisibilityBuffer& out) override {
        FF_CHECK(out.width >= view.width && out.height >= view.height, "a buffer of {}x{} for a view of {}x{}",
                 out.width, out.height, view.width, view.height);
        CastCostSum cost;
        parallel_ranges(tiles.size(), kTilesPerTask, [&](std::size_t begin, std::size_t end) {
            cost.add(grid::cast_packets(world_, view, tiles.subspan(begin, end - begin), out));
        });
        return cost.total();
    }

    CastCost cast_rays(std::span<const Ray> rays, std::span<RayHit> hits) override {
        FF_CHECK(hits.size() >= rays.size(), "{} rays, room for {} hits", rays.size(), hits.size());
        CastCostSum cost;
        parallel_ranges(rays.size(), kRaysPerTask, [&](std::size_t begin, std::size_t end) {
            CastCost sum;
            for (std::size_t i = begin; i < end; ++i)
                hits[i] = cast_float_ray(world_.scene.bounds, rays[i], [&](const Ray& ray) {
                    return grid::cast_ray(world_, ray, grid::RayCone{}, sum);
                });
            cost.add(sum);
        });
        return cost.total();
    }

    [[nodiscard]] std::uint64_t memory_bytes() const override {
        std::uint64_t bytes = world_.top.memory_bytes() + world_.placements.size() * sizeof(grid::Placement);
        for (const grid::Grid& g : world_.meshes) bytes += g.memory_bytes() + sizeof(grid::Grid);
        return bytes;
    }
    [[nodiscard]] double build_seconds() const override { return build_seconds_; }

  private:
    grid::GridWorld world_;
    double build_seconds_ = 0.0;
};

}  // namespace

std::unique_ptr<RayCaster> make_grid_caster(const scene::StaticScene& scene, double cells_per_item) {
    FF_CHECK(cells_per_item > 0.0, "{} cells per item", cells_per_item);
    return std::make_unique<GridCaster>(scene, cells_per_item);
}

}  // namespace ff::farfield
