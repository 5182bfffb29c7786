#include "engine/farfield/beam_caster.h"

#include <algorithm>
#include <bit>
#include <glm/matrix.hpp>
#include <limits>

#include "engine/core/check.h"
#include "engine/core/jobs.h"
#include "engine/farfield/cast_cost_sum.h"
#include "engine/farfield/float_ray.h"
#include "engine/farfield/tile_regroup.h"

namespace ff::farfield {
namespace beam {

BeamView::BeamView(const PinholeView& pinhole)
    : view(pinhole),
      camera_from_world(glm::inverse(DMat3(pinhole.world_from_camera))),
      pixel_angle(pinhole.pixel_angle()),
      sway(in_axes(pinhole.sway, pinhole.world_from_camera)) {}

AlphaRays BeamView::alpha_rays(int x, int y) const {
    constexpr float kMiddle = 0.5f * kBeamSize;
    return {.pixel_angle = pixel_angle,
            .u_step = view.u_step,
            .u_middle = (float(x) + kMiddle) * view.u_step + view.u_first,
            .v_step = view.v_step,
            .v_middle = (float(y) + kMiddle) * view.v_step + view.v_first,
            .blend_within_m = view.blend_within_m,
            .sway = sway};
}

DMat3 BeamView::tile_from_world(int x, int y) const {
    // u = (px + 0.5) u_step + u_first, px = X + x + 15.5; the view axis is -z.
    const double scale_x = 1.0 / double(view.u_step), scale_y = 1.0 / double(view.v_step);
    const double offset_x = -double(view.u_first) * scale_x - 0.5 * kBeamSize - x;
    const double offset_y = -double(view.v_first) * scale_y - 0.5 * kBeamSize - y;
    const DMat3 tile_from_camera(DVec3(scale_x, 0, 0), DVec3(0, scale_y, 0), DVec3(-offset_x, -offset_y, -1));
    return tile_from_camera * camera_from_world;
}

float least_depth(const PinholeView& view, const BeamRequest& request, const VisibilityBuffer& out) {
    float least = std::numeric_limits<float>::infinity();
    for (const TileRequest* tile : request.quarters) {
        if (tile == nullptr) continue;
        for (int j = 0; j < kTileSize; ++j)
            for (std::uint32_t left = row_inside(*tile, j, view.width, view.height); left != 0; left &= left - 1)
                least = std::min(least, out.depth[out.index(tile->x + std::countr_zero(left), tile->y + j)]);
    }
    return least;
}

BeamRequest beam_request_of(const TileRequest& tile) {
    const auto first_of = [](std::uint16_t pixel) { return std::uint16_t(pixel / kBeamSize * kBeamSize); };
    BeamRequest request{first_of(tile.x), first_of(tile.y), {}};
    request.quarters[std::size_t(tile.y / kTileSize % 2 * 2 + tile.x / kTileSize % 2)] = &tile;
    return request;
}

namespace {

std::size_t squares_across(int pixels) {
    return std::size_t(pixels + kBeamSize - 1) / std::size_t(kBeamSize);
}

}  // namespace

void BeamRequests::reserve(int width, int height) {
    const std::size_t squares = squares_across(width) * squares_across(height);
    requests_.reserve(squares);
    of_square_.reserve(squares);
}

std::span<const BeamRequest> BeamRequests::gather(const PinholeView& view, std::span<const TileRequest> tiles) {
    const std::size_t columns = squares_across(view.width);
    of_square_.assign(columns * squares_across(view.height), 0);
    requests_.clear();
    for (const TileRequest& tile : tiles) {
        if (tile.x >= view.width || tile.y >= view.height) continue;
        std::uint32_t& of_square = of_square_[tile.y / kBeamSize * columns + tile.x / kBeamSize];
        const std::size_t quarter = std::size_t(tile.y / kTileSize % 2 * 2 + tile.x / kTileSize % 2);
        if (of_square == 0 || requests_[of_square - 1].quarters[quarter] != nullptr) {
            requests_.push_back(beam_request_of(tile));
            of_square = std::uint32_t(requests_.size());
        }
        requests_[of_square - 1].quarters[quarter] = &tile;
    }
    return requests_;
}

}  // namespace beam

namespace {

class BeamCaster final : public RayCaster {
  public:
    BeamCaster(const scene::StaticScene& scene, bool is_live)
        : copy_(is_live ? scene::StaticScene{} : scene), scene_(is_live ? scene : copy_) {}

    CastCost cast_tiles(const PinholeView& view, std::span<const TileRequest> tiles, VisibilityBuffer& out) override {
        return cast(view, tiles, false, out);
    }
    CastCost cast_tiles_beyond(const PinholeView& view, std::span<const TileRequest> tiles,
                               VisibilityBuffer& out) override {
        return cast(view, tiles, true, out);
    }

    CastCost cast_rays(std::span<const Ray> rays, std::span<RayHit> hits) override {
        FF_CHECK(rays.size() == hits.size(), "{} rays, {} hits", rays.size(), hits.size());
        CastCostSum shared;
        parallel_ranges(rays.size(), 64, [&](std::size_t begin, std::size_t end) {
            CastCost cost;
            for (std::size_t i = begin; i < end; ++i)
                hits[i] = cast_float_ray(scene_.bounds, rays[i],
                                         [&](const Ray& ray) { return beam::cast_ray(scene_, ray, cost); });
            shared.add(cost);
        });
        return shared.total();
    }

    // The trees are the pack's own: nothing is built.
    [[nodiscard]] std::uint64_t memory_bytes() const override {
        return scene_.mesh_nodes.size_bytes() + scene_.mesh_leaves.size_bytes() + scene_.instance_nodes.size_bytes();
    }
    [[nodiscard]] double build_seconds() const override { return 0.0; }

  private:
    CastCost cast(const PinholeView& view, std::span<const TileRequest> tiles, bool beyond, VisibilityBuffer& out) {
        FF_CHECK(out.width >= view.width && out.height >= view.height, "view {} x {}, buffer {} x {}", view.width,
                 view.height, out.width, out.height);
        const beam::BeamView beam_view(view);
        CastCostSum shared;
        const std::span<const beam::BeamRequest> requests = requests_.gather(view, tiles);
        parallel_ranges(requests.size(), uneven_grain(requests.size(), 4), [&](std::size_t begin, std::size_t end) {
            CastCost cost;
            for (std::size_t i = begin; i < end; ++i) {
                beam::BeamRequest request = requests[i];
                if (beyond) request.begin = beam::least_depth(view, request, out);
                beam::cast_tile(scene_, beam_view, request, out, cost);
            }
            shared.add(cost);
        });
        return shared.total();
    }

    scene::StaticScene copy_;
    const scene::StaticScene& scene_;
    beam::BeamRequests requests_;
};

}  // namespace

std::unique_ptr<RayCaster> make_beam_caster(const scene::StaticScene& scene) {
    return std::make_unique<BeamCaster>(scene, false);
}

std::unique_ptr<RayCaster> make_live_beam_caster(const scene::StaticScene& scene) {
    return std::make_unique<BeamCaster>(scene, true);
}

}  // namespace ff::farfield
