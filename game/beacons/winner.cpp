#include "game/beacons/winner.h"

#include <cmath>
#include <glm/geometric.hpp>

#include "game/beacons/pathfinder.h"
#include "game/beacons/rules.h"

namespace ff::beacons {
namespace {

constexpr int kLookTicks = kTicks / 2;  ///< between two looks at where it got
constexpr double kStuck = 0.8;          ///< metres in that time
constexpr double kDetourStart = 0.9;    ///< radians away from the goal, growing

class Winner final : public host::AutoPlayer {
  public:
    explicit Winner(State& state) : s_(state) {}

    loop::UserCommand next() override {
        loop::UserCommand command;
        const WorldPos feet = s_.registry.get<ecs::LocalTransform>(s_.level.player)->position;
        const ecs::Entity goal = nearest_unlit(feet);
        if (!goal) return command;
        const DVec3 to = s_.registry.get<ecs::LocalTransform>(goal)->position - feet;
        const double distance = std::hypot(to.x, to.z);
        if (tick_++ % kLookTicks == 0) look_whether_stuck(feet);
        const bool at_goal = distance < 0.7 * kKindleReach;
        const DVec3 step = next_step(goal, feet) - feet;
        double yaw = at_goal ? std::atan2(to.x, -to.z) : std::atan2(step.x, -step.z);
        if (detour_left_ > 0 && !at_goal) {
            --detour_left_;
            yaw += detour_;
        }
        command.yaw_urad = std::int32_t(std::lround(std::remainder(yaw, 2.0 * kPi) * 1e6));
        command.pitch_urad = std::int32_t(std::lround(1e6 * std::atan2(to.y + 2.0, std::max(1.0, distance))));
        if (at_goal) {
            command.buttons = 1u << kUse;
        } else {
            command.move_ahead = loop::UserCommand::kFull;
            command.buttons = 1u << kRun;
            if (jumps_) command.buttons |= 1u << kJump;
            // A look through the spyglass from time to time, on the way.
            if (tick_ % (40 * kTicks) < 2 * kTicks) command.buttons |= 1u << kSpyglass;
        }
        return command;
    }

  private:
    /// The next point of the way to a goal; found anew for another goal, or where it has been left.
    WorldPos next_step(ecs::Entity goal, const WorldPos& feet) {
        const WorldPos to = s_.registry.get<ecs::LocalTransform>(goal)->position;
        const auto ahead = [&](const WorldPos& point) { return std::hypot(point.x - feet.x, point.z - feet.z); };
        if (goal != goal_ || seeks_anew_) {
            way_ = find_way(s_.physics, feet, to, 0.6 * kKindleReach);
            at_ = 0;
            goal_ = goal;
            seeks_anew_ = false;
        }
        while (at_ + 1 < way_.size() && ahead(way_[at_]) < 1.2) ++at_;
        return at_ < way_.size() ? way_[at_] : to;
    }

    ecs::Entity nearest_unlit(const WorldPos& feet) const {
        ecs::Entity nearest;
        double least = 1e300;
        for (const ecs::Entity entity : s_.level.beacons) {
            if (s_.registry.get<Beacon>(entity)->lit) continue;
            const double distance = glm::distance(s_.registry.get<ecs::LocalTransform>(entity)->position, feet);
            if (distance < least) least = distance, nearest = entity;
        }
        return nearest;
    }

    /// Walks aside, this way and that, farther each time, until it gets on.
    void look_whether_stuck(const WorldPos& feet) {
        const bool stuck = glm::distance(feet, last_) < kStuck;
        last_ = feet;
        jumps_ = stuck;
        if (!stuck) {
            if (detour_left_ == 0) tries_ = 0;
            return;
        }
        ++tries_;
        seeks_anew_ = tries_ % 4 == 0;
        const double side = tries_ % 2 == 0 ? 1.0 : -1.0;
        detour_ = side * std::min(2.6, kDetourStart + 0.25 * tries_);
        detour_left_ = kTicks / 2 * std::min(12, tries_);
    }

    State& s_;
    std::uint64_t tick_ = 0;
    WorldPos last_{0.0};
    double detour_ = 0.0;
    int detour_left_ = 0, tries_ = 0;
    bool jumps_ = false;
    std::vector<WorldPos> way_;
    std::size_t at_ = 0;
    ecs::Entity goal_;
    bool seeks_anew_ = false;
};

}  // namespace

std::unique_ptr<host::AutoPlayer> make_winner(State& state) {
    return std::make_unique<Winner>(state);
}

}  // namespace ff::beacons
