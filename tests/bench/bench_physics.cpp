// What the collision world costs a tick: a character that follows a pack's walk, bodies that fall and roll around it,
// bodies that sleep, rays. One worker is all it ever uses; processor time.
// Usage: bench_physics PACK.ffpack:WALK [laps]

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <functional>
#include <glm/geometric.hpp>
#include <string>
#include <vector>

#include "engine/physics/physics_world.h"
#include "tests/bench/cpu_watch.h"
#include "tests/bench/pack_walk.h"
#include "tests/support/worlds.h"

namespace {

using namespace ff;
using physics::BodyId;
using physics::CharacterId;
using physics::PhysicsWorld;
using physics::StepStats;

/// Times of single ticks over all laps, milliseconds.
class Ticks {
  public:
    void add(double ms) { all_.push_back(ms); }
    void print(const char* what, const std::string& note) {
        std::sort(all_.begin(), all_.end());
        const auto at = [&](double part) { return all_[std::size_t(part * double(all_.size() - 1))]; };
        double sum = 0;
        for (const double ms : all_) sum += ms;
        fmt::print("{:<34} {:8.4f} {:8.4f} {:8.4f} {:8.4f}   {}\n", what, at(0.5), sum / double(all_.size()), at(0.99),
                   all_.back(), note);
    }

  private:
    std::vector<double> all_;
};

double timed(const std::function<void()>& run) {
    const bench::CpuWatch watch;
    run();
    return watch.milliseconds();
}

WorldPos ground_below(const PhysicsWorld& world, const WorldPos& p) {
    const auto hit = world.cast_ray(p + DVec3(0, 1, 0), {0, -1, 0}, 1e4);
    return hit ? hit->point : p;
}

/// Runs after the walk's camera; where it is left behind (through houses, over water) it is put back.
void walk_along(const scene::World& world, const scene::Walk& walk, int laps) {
    Ticks ticks;
    std::uint64_t triangles = 0, count = 0, put_back = 0;
    for (int lap = 0; lap < laps; ++lap) {
        PhysicsWorld physics(world.scene());
        const CharacterId id =
            *physics.add_character({.position = ground_below(physics, walk.frames[0].position), .step_height_m = 0.5f});
        const int last = int(double(walk.frames.size() - 1) / walk.rate_hz * 120.0);
        for (int tick = 0; tick < last; ++tick) {
            const auto frame = std::size_t(double(tick + 12) / 120.0 * walk.rate_hz);
            const WorldPos goal = walk.frames[std::min(frame, walk.frames.size() - 1)].position;
            DVec3 to = goal - physics.character(id).position;
            to.y = 0;
            if (glm::length(to) > 8.0) {
                (void)bool(physics.set_position(id, ground_below(physics, goal)));
                ++put_back;
            }
            (void)bool(physics.set_input(id, {.velocity_m_s = Vec3(to * 10.0)}));
            StepStats stats;
            ticks.add(timed([&] { stats = physics.step(); }));
            triangles += stats.triangles_tested;
            ++count;
        }
    }
    ticks.print("a walking character", fmt::format("{:.0f} triangles a tick, put back {} times of {}",
                                                   double(triangles) / double(count), put_back, count));
}

/// Flings a character about at a kilometre a tick: each sweep may cross the whole town.
void fling(const scene::World& world, const scene::Walk& walk, int laps) {
    Ticks ticks;
    for (int lap = 0; lap < laps; ++lap) {
        PhysicsWorld physics(world.scene());
        test::Random random(std::uint32_t(lap + 1));
        const CharacterId id = *physics.add_character(
            {.position = walk.frames[0].position, .ground_accel_m_s2 = 1e9f, .air_accel_m_s2 = 1e9f});
        for (int i = 0; i < 400; ++i) {
            const WorldPos start = walk.frames[random.below(std::uint32_t(walk.frames.size()))].position;
            (void)bool(physics.set_position(id, ground_below(physics, start)));
            const double angle = random.in(0, 2 * kPi);
            (void)bool(physics.set_input(
                id, {.velocity_m_s = {float(120e3 * std::cos(angle)), 0, float(120e3 * std::sin(angle))}}));
            for (int tick = 0; tick < 4; ++tick) ticks.add(timed([&] { physics.step(); }));
        }
    }
    ticks.print("a character at 1 km a tick", "");
}

/// Drops bodies around a place and times the ticks in which most of them are awake.
void drop_bodies(const scene::World& world, const scene::Walk& walk, int bodies, bool piled, int laps) {
    Ticks ticks;
    std::uint64_t contacts = 0, triangles = 0, stepped = 0, count = 0;
    for (int lap = 0; lap < laps; ++lap) {
        PhysicsWorld physics(world.scene());
        test::Random random(std::uint32_t(lap + 1));
        const WorldPos center = walk.frames[walk.frames.size() / 3].position;
        (void)*physics.add_character({.position = ground_below(physics, center)});
        std::vector<BodyId> all;
        for (int i = 0; i < bodies; ++i) {
            physics::BodyDesc desc;
            const Vec3 size = random.in_box(Vec3(0.2f), Vec3(0.5f));
            if (i % 3 == 0) desc.shape = physics::box_shape(size);
            if (i % 3 == 1) desc.shape = physics::sphere_shape(size.x);
            if (i % 3 == 2) desc.shape = physics::capsule_shape(size.x, size.y);
            const double spread = piled ? 2.0 : 25.0;
            const WorldPos p = center + DVec3(random.in(-spread, spread), 0, random.in(-spread, spread));
            desc.pose.position = ground_below(physics, p) + DVec3(0, 1.0 + (piled ? 0.15 * i : 0.0), 0);
            desc.spin_rad_s = random.in_box(Vec3(-3), Vec3(3));
            all.push_back(*physics.add_body(desc));
        }
        for (int tick = 0; tick < 480; ++tick) {
            // Nobody is let sleep: it is the active ones that are measured.
            if (tick % 40 == 0)
                for (const BodyId id : all)
                    (void)bool(physics.apply_impulse(id, random.in_box({-4, 0, -4}, {4, 8, 4}),
                                                     physics.body(id).pose.position));
            StepStats stats;
            ticks.add(timed([&] { stats = physics.step(); }));
            contacts += stats.contact_points;
            triangles += stats.triangles_tested;
            stepped += stats.bodies_stepped;
            ++count;
        }
    }
    const double n = double(count);
    ticks.print(fmt::format("{} bodies, {}", bodies, piled ? "in a pile" : "strewn").c_str(),
                fmt::format("{:.0f} awake, {:.0f} contacts, {:.0f} triangles a tick", double(stepped) / n,
                            double(contacts) / n, double(triangles) / n));
}

void sleep_bodies(const scene::World& world, const scene::Walk& walk, int bodies) {
    PhysicsWorld physics(world.scene());
    test::Random random(1);
    const WorldPos center = walk.frames[0].position;
    for (int i = 0; i < bodies; ++i) {
        physics::BodyDesc desc{.asleep = true};
        desc.pose.position = center + DVec3(random.in(-500, 500), 200, random.in(-500, 500));
        (void)*physics.add_body(desc);
    }
    constexpr int kTicks = 10000;
    const double none = timed([&] {
        for (int i = 0; i < kTicks; ++i) physics.step();
    });
    fmt::print("{:<34} {:8.3f} us a tick\n", fmt::format("{} sleeping bodies", bodies), 1e3 * none / kTicks);
    std::vector<std::byte> state;
    const double save = timed([&] { state = physics.state(); });
    const double hash = timed([&] { (void)physics.hash(); });
    fmt::print("{:<34} {:8.3f} ms, {} bytes; hash {:.3f} ms\n", "their state", save, state.size(), hash);
}

void cast_rays(const scene::World& world, const scene::Walk& walk) {
    const PhysicsWorld physics(world.scene());
    for (const double reach : {3.0, 100.0, 5000.0}) {
        test::Random random(1);
        constexpr int kRays = 20000;
        int seen = 0;
        const double ms = timed([&] {
            for (int i = 0; i < kRays; ++i) {
                const WorldPos from = walk.frames[random.below(std::uint32_t(walk.frames.size()))].position;
                const double angle = random.in(0, 2 * kPi);
                seen +=
                    physics.can_see(from, from + reach * DVec3(std::cos(angle), random.in(-0.1, 0.1), std::sin(angle)));
            }
        });
        fmt::print("{:<34} {:8.3f} us each, {:.0f}% see\n", fmt::format("lines of sight of {:.0f} m", reach),
                   1e3 * ms / kRays, 100.0 * seen / kRays);
    }
}

}  // namespace

int main(int argc, char** argv) {
    const std::string where = argc > 1 ? argv[1] : "";
    const std::size_t colon = where.rfind(':');
    if (colon == std::string::npos) {
        fmt::print(stderr, "usage: bench_physics PACK.ffpack:WALK [laps]\n");
        return 2;
    }
    const int laps = argc > 2 ? std::max(1, std::atoi(argv[2])) : 3;
    auto opened = bench::open_pack_walk(where.substr(0, colon), where.substr(colon + 1));
    if (!opened) {
        fmt::print(stderr, "{}\n", opened.error().message);
        return 3;
    }
    const scene::World& world = *opened->world;
    fmt::print("{:<34} {:>8} {:>8} {:>8} {:>8}   ms a tick\n", where, "median", "mean", "p99", "worst");
    walk_along(world, *opened->walk, laps);
    fling(world, *opened->walk, laps);
    drop_bodies(world, *opened->walk, 100, false, laps);
    drop_bodies(world, *opened->walk, 100, true, laps);
    drop_bodies(world, *opened->walk, 10, true, laps);
    sleep_bodies(world, *opened->walk, 10000);
    cast_rays(world, *opened->walk);
    return 0;
}
