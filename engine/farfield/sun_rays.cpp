#include "engine/farfield/sun_rays.h"

#include <cmath>
#include <glm/geometric.hpp>

#include "engine/core/jobs.h"
#include "engine/farfield/cast_cost_sum.h"
#include "engine/farfield/sun_rays_reference.h"
#include "engine/scene/scene_data.h"

namespace ff::farfield {

SunRays::SunRays(const scene::StaticScene& scene) : scene_(scene), moving_(scene) {}

const scene::StaticScene& SunRays::moving(std::span<const scene::Instance> dynamic) {
    moving_.instances = dynamic;
    moving_nodes_.clear();
    if (!dynamic.empty()) scene::build_instance_bvh(dynamic, scene_.origin, moving_nodes_);
    moving_.instance_nodes = moving_nodes_;
    return moving_;
}

CastCost SunRays::cast(const PinholeView& view, const VisibilityBuffer& visibility, std::span<const TileRequest> tiles,
                       std::span<const scene::Instance> dynamic, const Vec3& to_sun, std::uint8_t* lit) {
    const scene::StaticScene& others = moving(dynamic);
    CastCostSum shared;
    parallel_for(tiles.size(), [&](std::size_t i) {
        const TileRequest& tile = tiles[i];
        CastCost cost;
        for (int row = 0; row < kTileSize; ++row)
            for (int column = 0; column < kTileSize; ++column) {
                const int x = tile.x + column, y = tile.y + row;
                if (((tile.rows[row] >> column) & 1u) == 0 || x >= view.width || y >= view.height) continue;
                const SunQuestion question = sun_question_reference(scene_, view, visibility, dynamic, to_sun, x, y);
                bool sees_sun = question.kind == SunQuestion::Kind::sky;
                if (question.kind == SunQuestion::Kind::ray) {
                    ++cost.rays;
                    sees_sun = !is_occluded_reference(scene_, 0, question.ray) &&
                               !is_occluded_reference(others, std::uint32_t(scene_.instances.size()), question.ray);
                }
                lit[visibility.index(x, y)] = sees_sun ? 255 : 0;
            }
        shared.add(cost);
    });
    return shared.total();
}

CastCost SunRays::cast_points(const WorldPos& origin, std::span<const SunPoint> points,
                              std::span<const scene::Instance> dynamic, const Vec3& to_sun, std::uint8_t* lit) {
    const scene::StaticScene& others = moving(dynamic);
    CastCostSum shared;
    parallel_ranges(points.size(), 64, [&](std::size_t begin, std::size_t end) {
        CastCost cost;
        for (std::size_t i = begin; i < end; ++i) {
            const SunPoint& point = points[i];
            lit[i] = 0;
            if (point.normal != Vec3(0.0f) && !(glm::dot(point.normal, to_sun) > 0.0f)) continue;
            ++cost.rays;
            const ShadowRay ray{.origin = origin + DVec3(point.position) + DVec3(point.normal) * double(point.offset_m),
                                .direction = DVec3(to_sun),
                                .footprint_m = point.footprint_m};
            if (!is_occluded_reference(scene_, 0, ray) &&
                !is_occluded_reference(others, std::uint32_t(scene_.instances.size()), ray))
                lit[i] = 255;
        }
        shared.add(cost);
    });
    return shared.total();
}

}  // namespace ff::farfield
