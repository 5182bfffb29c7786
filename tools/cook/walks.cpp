#include "tools/cook/walks.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "engine/scene/walk.h"
#include "tools/cook/walks_aerial.h"
#include "tools/cook/walks_cache.h"
#include "tools/cook/walks_frames.h"
#include "tools/cook/walks_route.h"

namespace ff::cook {
namespace {

constexpr double kRate_hz = 30.0;
constexpr int kStreetFrames = 400, kOrbitFrames = 120, kFlyoverFrames = 400, kTurnFrames = 180, kSprintFrames = 200;
// A jog: 40 m in the 13 s of `street`, enough to see a corner and what lies behind it. A stroll would end before it.
constexpr double kStreetSpeed_m_s = 3.0;
constexpr double kSprintSpeed_m_s = 10.0;
constexpr double kFlySpeed_m_s = 25.0;
// Of the 256 m that a ground map reaches, a route of 120 m and the room around it are left.
constexpr double kSameSurroundings_m = 100.0;

double way_m(int frames, double speed_m_s) {
    return (frames - 1) * speed_m_s / kRate_hz;
}

bool has_walk(const WorldSource& world, const char* name) {
    return std::any_of(world.walks.begin(), world.walks.end(), [&](const SourceWalk& w) { return w.name == name; });
}

void add_walk(WorldSource& world, const char* name, std::vector<WalkFrame> frames) {
    if (has_walk(world, name)) return;
    round_frames(frames);
    world.walks.push_back({.name = name, .rate_hz = kRate_hz, .frames = std::move(frames)});
}

std::vector<WalkFrame> turn_on_the_spot(const DVec3& eye, double yaw_deg, double pitch_deg) {
    std::vector<WalkFrame> frames(kTurnFrames);
    for (std::size_t f = 0; f < frames.size(); ++f)
        frames[f] = {.position = eye, .yaw_deg = yaw_deg + double(f) * 360.0 / kTurnFrames, .pitch_deg = pitch_deg};
    return frames;
}

void add_walks_on_ground(WorldSource& world, const GroundMap& map, std::uint32_t node, const SceneCircle& circle) {
    const WalkRoute route = plan_route(map, node);
    const double start =
        find_corner_start(route, way_m(kStreetFrames, kStreetSpeed_m_s), way_m(kSprintFrames, kSprintSpeed_m_s));
    add_walk(world, "street", walk_along(route, start, kStreetSpeed_m_s, 3.0, kStreetFrames));
    add_walk(world, "sprint", walk_along(route, start, kSprintSpeed_m_s, 6.0, kSprintFrames));
    add_walk(world, "flyover", fly_over(map, node, world.spawn_yaw_deg, circle, kFlyoverFrames));
}

void add_walks_around_object(WorldSource& world, const ObjectView& view) {
    add_walk(world, "street", walk_around(view, kStreetSpeed_m_s, 0.0, kStreetFrames));
    add_walk(world, "sprint", walk_around(view, kSprintSpeed_m_s, 0.0, kSprintFrames));
    const double rise = std::min(100.0, view.distance_m);
    add_walk(world, "flyover", walk_around(view, kFlySpeed_m_s - 0.24 * rise, rise, kFlyoverFrames));
}

// The free ground around a place.
struct Surroundings {
    PointXZ center;
    DensityMap density;
    GroundMap map;
};

Surroundings look_around(const StaticTriangles& triangles, std::optional<PointXZ> place) {
    Surroundings around;
    around.density = make_density_map(triangles, place);
    around.center = place.value_or(densest_place(around.density));
    around.map = make_ground_map(triangles, around.density, around.center);
    return around;
}

void choose_spawn(WorldSource& world, const StaticTriangles& triangles, const Surroundings& around) {
    const std::uint32_t node = find_spawn_node(around.map, around.density);
    if (node == GroundNode::kNone) {
        // To the south of the object, looking at it.
        const ObjectView view = object_view(triangles.bounds());
        world.spawn_position = DVec3(view.center.x, view.eye_y - kEyeHeight_m, view.center.z + view.distance_m);
        world.spawn_yaw_deg = 0.0;
        return;
    }
    const PointXZ at = around.map.middle_of(around.map.nodes[node]);
    const double y = around.map.nodes[node].y + around.map.base_y;
    world.spawn_position = DVec3(at.x, std::round(y * 1e6) / 1e6, at.z);
    world.spawn_yaw_deg = free_ways(around.map, node).longest_deg;
}

void make_standard_walks(WorldSource& world, const StaticTriangles& triangles, const Surroundings& around) {
    std::uint32_t node = find_node_near(around.map, world.spawn_position);
    if (node == GroundNode::kNone) node = find_spawn_node(around.map, around.density);
    const SceneCircle circle = scene_circle(triangles, around.density, world.spawn_position.y);
    const DVec3 eye = world.spawn_position + DVec3(0.0, kEyeHeight_m, 0.0);
    double pitch_deg = 0.0;
    if (node != GroundNode::kNone) {
        add_walks_on_ground(world, around.map, node, circle);
    } else {
        const ObjectView view = object_view(triangles.bounds());
        add_walks_around_object(world, view);
        const DVec3 d = view.center - eye;
        pitch_deg = std::clamp(degrees_of(std::atan2(d.y, std::hypot(d.x, d.z))), -60.0, 0.0);
    }
    add_walk(world, "orbit", orbit(circle, around.density, kOrbitFrames));
    add_walk(world, "turn", turn_on_the_spot(eye, world.spawn_yaw_deg, pitch_deg));
}

void find_spawn_and_walks(WorldSource& world, bool has_spawn) {
    constexpr const char* kNames[] = {"street", "orbit", "flyover", "turn", "sprint"};
    const bool has_walks =
        std::all_of(std::begin(kNames), std::end(kNames), [&](const char* name) { return has_walk(world, name); });
    if (has_spawn && has_walks) return;
    const StaticTriangles triangles(world);
    std::optional<Surroundings> around;
    if (!has_spawn && !triangles.bounds().is_empty()) {
        around = look_around(triangles, std::nullopt);
        choose_spawn(world, triangles, *around);
    }
    if (has_walks) return;
    const PointXZ spawn{world.spawn_position.x, world.spawn_position.z};
    // What was seen when the spawn point was chosen serves its walks, unless they would run out of it.
    if (!around || std::hypot(spawn.x - around->center.x, spawn.z - around->center.z) > kSameSurroundings_m)
        around = look_around(triangles, spawn);
    make_standard_walks(world, triangles, *around);
}

}  // namespace

void add_spawn_and_walks(WorldSource& world, bool has_spawn, CookCache& cache) {
    if (!cache.enabled()) return find_spawn_and_walks(world, has_spawn);
    const CacheKey key = walks_key(world, has_spawn);
    if (find_walks(key, cache, world)) return;
    find_spawn_and_walks(world, has_spawn);
    store_walks(key, world, cache);
}

Result<SourceWalk> read_walk_file(const std::filesystem::path& path, const std::string& name) {
    Result<scene::Walk> loaded = scene::load_walk(path);
    if (!loaded) return loaded.error();
    SourceWalk walk{.name = name, .fov_deg = loaded->fov_deg, .rate_hz = loaded->rate_hz};
    walk.frames.reserve(loaded->frames.size());
    for (const scene::WalkFrame& frame : loaded->frames)
        walk.frames.push_back({frame.position, frame.yaw_deg, frame.pitch_deg, frame.roll_deg});
    return walk;
}

}  // namespace ff::cook
