// What the game asks: what is along a ray, what is near, what can be seen.

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "engine/physics/physics_impl.h"

namespace ff::physics {
namespace {

bool is_finite(const DVec3& v) {
    return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

/// What queries of this thread find on their way, kept so that asking asks for no memory.
struct QueryScratch {
    std::vector<std::uint32_t> slots;
    std::vector<Obstacle> obstacles;
};
QueryScratch& scratch() {
    thread_local QueryScratch mine;
    return mine;
}

Hit hit_of(const Obstacle& o, double distance) {
    return {distance, o.point, Vec3(o.normal), o.body, o.instance, o.triangle};
}

/// The way of a ray that may be endless, cut to where something can be; none where it is no ray.
std::optional<DVec3> way_of(const scene::StaticScene& scene, const BodyStore& bodies, const WorldPos& from,
                            const Vec3& direction, double max_m, double radius_m) {
    const double length = glm::length(DVec3(direction));
    if (!is_finite(from) || !(length > 0.0) || !std::isfinite(length) || !(max_m > 0.0)) return {};
    DBox3 all = scene.bounds;
    all.add(bodies.bounds());
    if (all.is_empty()) return {};
    const DVec3 farthest = glm::max(glm::abs(all.low - from), glm::abs(all.high - from));
    return DVec3(direction) * (std::min(max_m, glm::length(farthest) + radius_m + 1.0) / length);
}

}  // namespace

std::optional<Hit> PhysicsWorld::cast_ray(const WorldPos& from, const Vec3& direction, double max_m,
                                          const QueryFilter& filter) const {
    const auto along = way_of(impl_->scene, impl_->bodies, from, direction, max_m, 0.0);
    if (!along) return {};
    const auto found = ObstacleQuery(impl_->scene, impl_->bodies, scratch().slots).ray(from, *along, filter);
    if (!found) return {};
    return hit_of(*found, found->time * glm::length(*along));
}

std::optional<Hit> PhysicsWorld::cast_sphere(const WorldPos& from, float radius_m, const Vec3& direction, double max_m,
                                             const QueryFilter& filter) const {
    if (!(radius_m >= 0.0f) || !std::isfinite(radius_m)) return {};
    const auto along = way_of(impl_->scene, impl_->bodies, from, direction, max_m, double(radius_m));
    if (!along) return {};
    ObstacleQuery query(impl_->scene, impl_->bodies, scratch().slots);
    std::vector<Obstacle>& within = scratch().obstacles;
    query.near({from, from}, radius_m, 0.0, filter, within);
    const auto deepest = std::min_element(within.begin(), within.end(),
                                          [](const Obstacle& a, const Obstacle& b) { return a.gap < b.gap; });
    if (deepest != within.end()) return hit_of(*deepest, 0.0);
    const auto found = query.sweep({from, from}, radius_m, *along, filter);
    if (!found) return {};
    return hit_of(*found, found->time * glm::length(*along));
}

bool PhysicsWorld::can_see(const WorldPos& from, const WorldPos& to, const QueryFilter& filter) const {
    if (!is_finite(from) || !is_finite(to)) return false;
    const DVec3 along = to - from;
    // What is looked at does not hide itself.
    constexpr double kSurface_m = 1e-3;
    const double length = glm::length(along);
    if (length <= kSurface_m) return true;
    return !ObstacleQuery(impl_->scene, impl_->bodies, scratch().slots)
                .ray(from, along * (1.0 - kSurface_m / length), filter);
}

void PhysicsWorld::bodies_near(const WorldPos& center, float radius_m, std::vector<BodyId>& out) const {
    if (!is_finite(center) || !(radius_m >= 0.0f) || !std::isfinite(radius_m)) return;
    std::vector<Obstacle>& touched = scratch().obstacles;
    ObstacleQuery(impl_->scene, impl_->bodies, scratch().slots)
        .near({center, center}, radius_m, 0.0, {.static_scene = false}, touched);
    const std::size_t first = out.size();
    for (const Obstacle& o : touched)  // a mesh's triangles follow each other
        if (out.size() == first || !(out.back() == o.body)) out.push_back(o.body);
}

}  // namespace ff::physics
