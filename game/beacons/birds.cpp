// Flocks: each bird keeps with its neighbours, apart from them, and near its place.
//
// Based on: Reynolds, "Flocks, Herds, and Schools: A Distributed Behavioral Model", SIGGRAPH 1987.

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "game/beacons/rules.h"
#include "game/beacons/state.h"

namespace ff::beacons {
namespace {

constexpr float kSees = 9.0f, kApart = 2.5f, kHome = 45.0f;  // metres
constexpr float kLeastSpeed = 5.0f, kMostSpeed = 11.0f;      // metres a second

/// The way a bird's neighbours and its place pull it, metres a second squared.
Vec3 pull_on(const Vec3& from_home, const Bird& bird, std::span<const Vec3> places, std::span<const Bird> birds) {
    Vec3 middle(0.0f), heading(0.0f), away(0.0f);
    float neighbours = 0.0f;
    for (std::size_t i = 0; i < birds.size(); ++i) {
        if (birds[i].flock != bird.flock) continue;
        const Vec3 to = places[i] - from_home;
        const float distance = glm::length(to);
        if (distance > kSees || distance < 1e-3f) continue;
        middle += to;
        heading += birds[i].velocity_m_s;
        neighbours += 1.0f;
        if (distance < kApart) away -= to / (distance * distance);
    }
    Vec3 pull = 6.0f * away;
    if (neighbours > 0.0f) pull += 0.4f * middle / neighbours + 0.5f * (heading / neighbours - bird.velocity_m_s);
    const float strayed = glm::length(from_home);
    if (strayed > kHome) pull -= 0.15f * from_home * (1.0f - kHome / strayed);
    pull.y -= 0.3f * from_home.y;
    return pull;
}

void move_birds(ecs::SystemContext& context) {
    context.each_chunk<ecs::LocalTransform, Before, Bird, const Model>(
        [&](std::span<const ecs::Entity>, std::span<ecs::LocalTransform> at, std::span<Before> before,
            std::span<Bird> birds, std::span<const Model> models) {
            constexpr std::size_t kMost = 256;
            const std::size_t count = std::min(birds.size(), kMost);
            std::array<Vec3, kMost> places;
            for (std::size_t i = 0; i < count; ++i) places[i] = Vec3(at[i].position - models[i].placed_at);
            for (std::size_t i = 0; i < count; ++i) {
                Bird& bird = birds[i];
                const Vec3 pull = pull_on(places[i], bird, std::span(places).first(count), birds.first(count));
                Vec3 velocity = bird.velocity_m_s + pull * float(kTick);
                const float speed = glm::length(velocity);
                velocity *= std::clamp(speed, kLeastSpeed, kMostSpeed) / std::max(speed, 1e-3f);
                before[i] = {at[i].position, at[i].rotation};
                bird.velocity_m_s = velocity;
                at[i].position += DVec3(velocity) * kTick;
                at[i].rotation = turn_of(std::atan2(double(velocity.x), -double(velocity.z)));
            }
        });
}

}  // namespace

void add_bird_system(ecs::Schedule& schedule) {
    schedule.add("birds", ecs::Access().write<ecs::LocalTransform, Before, Bird>().read<Model>(), move_birds);
}

}  // namespace ff::beacons
