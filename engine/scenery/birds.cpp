#include "engine/scenery/birds.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "engine/scenery/shown_model.h"

namespace ff::scenery {
namespace {

constexpr double kTick = 1.0 / 120.0;                    // seconds
constexpr float kSees = 9.0f, kApart = 2.5f;             // metres
constexpr float kLeastSpeed = 5.0f, kMostSpeed = 11.0f;  // metres a second
constexpr float kMostClimb = 0.6f, kMostBank = 0.9f;     // radians
constexpr float kTurning = 4.0f;                         // a second: how soon a bird lies as it flies

/// The way a bird's neighbours and its place pull it, metres a second squared.
Vec3 pull_on(const Flocks::Seen& flock, std::size_t self, float radius_m) {
    const Vec3 place = flock.places[self];
    Vec3 middle(0.0f), heading(0.0f), away(0.0f);
    float neighbours = 0.0f;
    for (std::size_t i = 0; i < flock.places.size(); ++i) {
        const Vec3 to = flock.places[i] - place;
        const float distance2 = glm::dot(to, to);
        if (distance2 > kSees * kSees || distance2 < 1e-6f) continue;
        middle += to;
        heading += flock.velocities[i];
        neighbours += 1.0f;
        if (distance2 < kApart * kApart) away -= to / distance2;
    }
    Vec3 pull = 6.0f * away;
    if (neighbours > 0.0f) pull += 0.4f * middle / neighbours + 0.5f * (heading / neighbours - flock.velocities[self]);
    const float strayed = glm::length(place);
    if (strayed > radius_m) pull -= 0.15f * place * (1.0f - radius_m / strayed);
    pull.y -= 0.3f * place.y;
    return pull;
}

/// How a bird lies in the air: along its way, leaning into its turn.
glm::quat lie_of(const Vec3& velocity, const Vec3& pull) {
    const float level = std::sqrt(velocity.x * velocity.x + velocity.z * velocity.z);
    const float climb = std::clamp(std::atan2(velocity.y, level), -kMostClimb, kMostClimb);
    const float to_right = level > 1e-3f ? (pull.z * velocity.x - pull.x * velocity.z) / level : 0.0f;
    const float bank = std::clamp(std::atan2(to_right, 9.81f), -kMostBank, kMostBank);
    return turn_of(std::atan2(double(velocity.x), -double(velocity.z))) *
           glm::angleAxis(climb, Vec3(1.0f, 0.0f, 0.0f)) * glm::angleAxis(-bank, Vec3(0.0f, 0.0f, 1.0f));
}

}  // namespace

bool Flocks::is_near(std::uint32_t flock) const {
    const double magnified = std::tan(radians_of(30.0)) / std::tan(0.5 * vertical_fov);
    return glm::distance(homes[flock].position, viewer) <= within_m * magnified + homes[flock].radius_m;
}

BirdStart start_of(const Flocks::Home& home, std::uint32_t number, std::uint32_t birds, std::uint32_t index) {
    const double angle = 2.0 * kPi * number / birds, ring = 0.2 * double(home.radius_m);
    const DVec3 offset(ring * std::cos(angle), 2.0 * std::sin(3.0 * angle), ring * std::sin(angle));
    const Vec3 velocity(float(-7.0 * std::sin(angle)), 0.0f, float(7.0 * std::cos(angle)));
    return {{.position = home.position + offset, .rotation = lie_of(velocity, Vec3(0.0f))}, {velocity, index}};
}

ecs::Access bird_access() {
    ecs::Access access;
    access.write<ecs::LocalTransform, Bird>().write_resource<Flocks>();
    return access;
}

void move_birds(ecs::SystemContext& context) {
    Flocks& flocks = context.resource<Flocks>();
    flocks.flying = 0;
    flocks.seen.resize(flocks.homes.size());
    bool any = false;
    for (std::uint32_t f = 0; f < flocks.homes.size(); ++f) {
        Flocks::Seen& seen = flocks.seen[f];
        seen.places.clear();
        seen.velocities.clear();
        seen.next = 0;
        any |= flocks.is_near(f);
    }
    if (!any) return;
    const auto is_moved = [&](const Bird& bird) {
        return bird.flock < flocks.homes.size() && flocks.is_near(bird.flock);
    };
    context.each<const ecs::LocalTransform, const Bird>([&](const ecs::LocalTransform& at, const Bird& bird) {
        if (!is_moved(bird)) return;
        Flocks::Seen& seen = flocks.seen[bird.flock];
        seen.places.emplace_back(at.position - flocks.homes[bird.flock].position);
        seen.velocities.push_back(bird.velocity_m_s);
    });
    for (std::size_t f = 0; f < flocks.homes.size(); ++f) {
        Flocks::Seen& seen = flocks.seen[f];
        seen.pulls.resize(seen.places.size());
        for (std::size_t i = 0; i < seen.places.size(); ++i) seen.pulls[i] = pull_on(seen, i, flocks.homes[f].radius_m);
    }
    context.each<ecs::LocalTransform, Bird>([&](ecs::LocalTransform& at, Bird& bird) {
        if (!is_moved(bird)) return;
        Flocks::Seen& seen = flocks.seen[bird.flock];
        const Vec3 pull = seen.pulls[seen.next++];
        Vec3 velocity = bird.velocity_m_s + pull * float(kTick);
        const float speed = glm::length(velocity);
        velocity *= std::clamp(speed, kLeastSpeed, kMostSpeed) / std::max(speed, 1e-3f);
        bird.velocity_m_s = velocity;
        at.position += DVec3(velocity) * kTick;
        at.rotation = glm::normalize(glm::slerp(at.rotation, lie_of(velocity, pull), float(kTurning * kTick)));
        ++flocks.flying;
    });
}

void add_bird_system(ecs::Schedule& schedule) {
    schedule.add("birds", bird_access(), move_birds);
}

}  // namespace ff::scenery
