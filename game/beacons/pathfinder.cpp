#include "game/beacons/pathfinder.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <optional>
#include <queue>
#include <unordered_map>

namespace ff::beacons {
namespace {

constexpr double kStep = 2.5;         // metres between places
constexpr int kParts = 4;             // of a step, each of which is looked at
constexpr double kRise = 0.7;         // metres up in one of them, and twice that down
constexpr float kBody = 0.4f;         // radius of what has to fit
constexpr double kBodyHeight = 0.95;  // of its middle above the ground
constexpr double kGreed = 1.3;        // how much more a metre towards the goal counts

struct Place {
    std::int32_t x, z;
    friend bool operator==(const Place&, const Place&) = default;
};
struct HashPlace {
    std::size_t operator()(const Place& p) const {
        return std::size_t(std::uint32_t(p.x) * 0x9E3779B1u ^ std::uint32_t(p.z) * 0x85EBCA6Bu);
    }
};
struct Reached {
    WorldPos at{0.0};
    double cost = 0.0;
    Place before{0, 0};
    bool done = false;
};

class Search {
  public:
    Search(const physics::PhysicsWorld& physics, const WorldPos& from, const WorldPos& to)
        : physics_(physics), from_(from), to_(to) {}

    std::vector<WorldPos> run(double reach_m, std::size_t most_places) {
        push({0, 0}, {from_, 0.0, {0, 0}});
        while (!open_.empty() && reached_.size() < most_places) {
            const Place place = open_.top().place;
            open_.pop();
            Reached& here = reached_[place];
            if (here.done) continue;
            here.done = true;
            if (std::hypot(here.at.x - to_.x, here.at.z - to_.z) < reach_m) return way_to(place);
            expand(place, here.at, here.cost);
        }
        return {};
    }

  private:
    struct Entry {
        double bound;
        Place place;
        // Ties by place: the same way on every machine.
        friend bool operator<(const Entry& a, const Entry& b) {
            if (a.bound != b.bound) return a.bound > b.bound;
            return a.place.x != b.place.x ? a.place.x > b.place.x : a.place.z > b.place.z;
        }
    };

    void push(const Place& place, const Reached& reached) {
        reached_[place] = reached;
        open_.push({reached.cost + kGreed * std::hypot(reached.at.x - to_.x, reached.at.z - to_.z), place});
    }

    void expand(const Place& place, const WorldPos at, double cost) {
        for (std::int32_t dz = -1; dz <= 1; ++dz)
            for (std::int32_t dx = -1; dx <= 1; ++dx) {
                if (dx == 0 && dz == 0) continue;
                const Place next{place.x + dx, place.z + dz};
                const double step = kStep * std::hypot(dx, dz);
                const auto known = reached_.find(next);
                if (known != reached_.end() && (known->second.done || known->second.cost <= cost + step)) continue;
                const auto ground = ground_at(next, at);
                if (!ground || !is_free(at, *ground)) continue;
                push(next, {*ground, cost + glm::distance(at, *ground), place});
            }
    }

    /// The ground of a place, where every part of the step there can be walked.
    std::optional<WorldPos> ground_at(const Place& place, const WorldPos& near) const {
        const DVec3 step(from_.x + kStep * place.x - near.x, 0.0, from_.z + kStep * place.z - near.z);
        WorldPos at = near;
        for (int part = 1; part <= kParts; ++part) {
            const WorldPos above = near + step * (double(part) / kParts);
            const auto hit = physics_.cast_ray({above.x, at.y + kRise, above.z}, {0.0f, -1.0f, 0.0f}, 3.0 * kRise);
            if (!hit || hit->normal.y < 0.65f) return std::nullopt;
            at = hit->point;
        }
        return at;
    }

    bool is_free(const WorldPos& from, const WorldPos& to) const {
        const DVec3 up(0.0, kBodyHeight, 0.0), step = to - from;
        return !physics_.cast_sphere(from + up, kBody, Vec3(step), glm::length(step));
    }

    std::vector<WorldPos> way_to(Place place) const {
        std::vector<WorldPos> way;
        for (; !(place == Place{0, 0}); place = reached_.at(place).before) way.push_back(reached_.at(place).at);
        std::reverse(way.begin(), way.end());
        return way;
    }

    const physics::PhysicsWorld& physics_;
    WorldPos from_, to_;
    std::unordered_map<Place, Reached, HashPlace> reached_;
    std::priority_queue<Entry> open_;
};

}  // namespace

std::vector<WorldPos> find_way(const physics::PhysicsWorld& physics, const WorldPos& from, const WorldPos& to,
                               double reach_m, std::size_t most_places) {
    return Search(physics, from, to).run(reach_m, most_places);
}

}  // namespace ff::beacons
