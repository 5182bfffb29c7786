#include "engine/physics/character_controller.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "engine/physics/numbers.h"

namespace ff::physics {
namespace {

const DVec3 kUp(0.0, 1.0, 0.0);
constexpr double kOverlap_m = 1e-5;      // less is rounding
constexpr double kBodyOverlap_m = 0.02;  // bodies that lean on a character are for the solver
constexpr double kGroundReach_m = 1e-4;  // what is nearer than this carries
constexpr double kLeastGroundUp = 0.1;   // the foot's side is not stood upon
constexpr double kTiny = 1e-9;

DVec3 level(const DVec3& v) {
    return {v.x, 0.0, v.z};
}

/// The planes that a slide must not go into, and what is left of a direction between them.
class Planes {
  public:
    void add(const DVec3& normal) {
        // A neighbour in the same plane is the same plane: two normals that differ by rounding have no crease.
        for (std::size_t i = 0; i < size_; ++i) {
            if (glm::dot(normals_[i], normal) > 1.0 - 1e-8) {
                normals_[i] = normal;
                return;
            }
        }
        if (size_ < normals_.size()) normals_[size_++] = normal;
    }

    [[nodiscard]] DVec3 clip(const DVec3& v) const {
        if (is_free(v)) return v;
        for (std::size_t i = 0; i < size_; ++i) {
            const DVec3 w = v - normals_[i] * glm::dot(v, normals_[i]);
            if (glm::dot(v, normals_[i]) < 0.0 && is_free(w)) return w;
        }
        for (std::size_t i = 0; i < size_; ++i) {
            for (std::size_t j = i + 1; j < size_; ++j) {
                const DVec3 crease = glm::cross(normals_[i], normals_[j]);
                const double length2 = glm::dot(crease, crease);
                if (length2 < 1e-12) continue;
                const DVec3 w = crease * (glm::dot(v, crease) / length2);
                if (is_free(w)) return w;
            }
        }
        return DVec3(0.0);
    }

  private:
    [[nodiscard]] bool is_free(const DVec3& v) const {
        const double slack = 1e-6 * glm::length(v);
        for (std::size_t i = 0; i < size_; ++i)
            if (glm::dot(v, normals_[i]) < -slack) return false;
        return true;
    }
    std::array<DVec3, 8> normals_;
    std::size_t size_ = 0;
};

/// Speeds up or slows down towards the wish.
DVec3 approach(const DVec3& velocity, const DVec3& wish, double most) {
    const DVec3 change = wish - velocity;
    const double length = glm::length(change);
    return length <= most ? wish : velocity + change * (most / length);
}

}  // namespace

void CharacterController::move(Character& c, double tick_s, std::vector<Push>& pushes) {
    met_.clear();
    crouch_or_rise(c);
    ride(c, tick_s);
    recover(c);

    const DVec3 wish = level(DVec3(c.input.velocity_m_s));
    const double accel = double(c.on_ground ? c.desc.ground_accel_m_s2 : c.desc.air_accel_m_s2) * tick_s;
    const DVec3 flat = approach(level(c.velocity), wish, accel);
    c.velocity = DVec3(flat.x, c.velocity.y, flat.z);

    if (c.on_ground && c.input.jump && c.desc.jump_height_m > 0.0f) {
        // As much faster as half a tick's fall takes, so that the ticks' sum reaches the height.
        const double g = c.desc.gravity_m_s2;
        c.velocity.y = std::sqrt(2.0 * g * double(c.desc.jump_height_m)) + 0.5 * g * tick_s;
        if (const Body* const body = bodies_.find(c.ground))
            c.velocity += carried(body->before, body->frame, c.feet) / tick_s;
        c.on_ground = false;
        c.ground = {};
    }
    if (c.on_ground)
        walk(c, flat * tick_s, tick_s);
    else
        fall(c, tick_s);
    // Past the end of the world it stays there.
    c.feet = glm::clamp(c.feet, DVec3(-kMaxCoordinate_m), DVec3(kMaxCoordinate_m));
    push_bodies(c, wish, tick_s, pushes);
}

void CharacterController::crouch_or_rise(Character& c) {
    if (c.input.crouch) {
        c.crouching = true;
        return;
    }
    if (!c.crouching) return;
    c.crouching = false;
    query_.near(c.capsule(c.feet), c.desc.radius_m, 0.0, {}, near_);
    c.crouching = std::any_of(near_.begin(), near_.end(), [](const Obstacle& o) { return o.gap < -kOverlap_m; });
}

// What it stands on takes it along; what is in the way there holds it.
void CharacterController::ride(Character& c, double tick_s) {
    c.ridden = DVec3(0.0);
    if (!c.on_ground || !c.ground) return;
    const Body* const body = bodies_.find(c.ground);
    if (body == nullptr) {
        c.ground = {};
        return;
    }
    const DVec3 along = carried(body->before, body->frame, c.feet);
    if (along == DVec3(0.0)) return;
    // The body itself has moved already; it would stop its own passenger.
    const auto hit = query_.sweep(c.capsule(c.feet), c.desc.radius_m, along, {.except = c.ground});
    c.ridden = along * (hit ? hit->time : 1.0);
    c.feet += c.ridden;
    // What drops away faster than things fall leaves it behind.
    if (along.y < -double(c.desc.step_height_m) - double(c.desc.gravity_m_s2) * tick_s) c.on_ground = false;
}

void CharacterController::recover(Character& c) {
    constexpr int kRounds = 8;
    constexpr double kCore = 0.05;  // of the radius
    for (int round = 0; round < kRounds; ++round) {
        query_.near(c.capsule(c.feet), c.desc.radius_m, 0.0, {}, near_);
        const Obstacle* worst = nullptr;
        for (const Obstacle& o : near_) {
            const Body* const body = bodies_.find(o.body);
            const double slack = body != nullptr && body->is_dynamic() ? kBodyOverlap_m : kOverlap_m;
            if (o.gap < -slack && (worst == nullptr || o.gap < worst->gap)) worst = &o;
        }
        if (worst == nullptr) return;
        // Out of one thing, but not through another: its core must not cross what it does not cross yet.
        const DVec3 out = worst->normal * (-worst->gap + 0.5 * kTouchGap);
        const auto hit = query_.sweep(c.capsule(c.feet), kCore * double(c.desc.radius_m), out, {.bodies = false}, true);
        c.feet += out * (hit ? hit->time : 1.0);
    }
}

CharacterController::Slide CharacterController::slide(const Character& c, DVec3 feet, DVec3 along, bool walking) {
    constexpr int kBends = 10;
    const double steepest = std::cos(double(c.desc.max_slope_rad));
    Slide out;
    Planes planes;
    DVec3 last_wall(0.0);
    const DVec3 wanted = along;
    for (int bend = 0; bend < kBends && glm::dot(along, along) > kTiny * kTiny; ++bend) {
        const auto hit = query_.sweep(c.capsule(feet), c.desc.radius_m, along, {});
        if (!hit) {
            feet += along;
            break;
        }
        out.hit = true;
        feet += along * hit->time;
        along *= 1.0 - hit->time;
        if (hit->body) met_.push_back(*hit);

        DVec3 normal = hit->normal;
        if (normal.y < steepest) {
            // Too steep to be walked: it must not lift who goes against it. Met again, it is taken as it is.
            const DVec3 upright = level(normal);
            const DVec3 turned = along - normal * glm::dot(along, normal);
            const bool lifts = turned.y > std::max(along.y, 0.0) + kTiny;
            if (normal.y > 0.0 && (walking || lifts) && glm::dot(last_wall, normal) < 1.0 - 1e-6 &&
                glm::dot(upright, upright) > 1e-6) {
                last_wall = normal;
                normal = glm::normalize(upright);
            }
        }
        planes.add(normal);
        along = planes.clip(along);
        // Never back: in a corner that would be a jitter.
        if (glm::dot(along, wanted) <= 0.0) break;
    }
    out.feet = feet;
    return out;
}

CharacterController::Ground CharacterController::ground_at(const Character& c, const DVec3& feet) {
    const double steepest = std::cos(double(c.desc.max_slope_rad));
    query_.near(c.capsule(feet), c.desc.radius_m, kGroundReach_m, {}, near_);
    Ground out;
    double best = -1.0;
    const double highest = feet.y + double(std::max(c.desc.step_height_m, 0.05f));
    for (const Obstacle& o : near_) {
        if (o.normal.y < kLeastGroundUp || o.point.y > highest) continue;
        if (o.face_up < steepest && o.normal.y < steepest) continue;
        // Of several, the one that is most below.
        if (o.normal.y <= best) continue;
        best = o.normal.y;
        out = {true, o.normal.y >= steepest ? o.normal : kUp, o.body, o.point};
    }
    if (out.found) return out;
    // Between two slopes that are both too steep it goes no deeper: that is a place to stand.
    for (std::size_t i = 0; i < near_.size(); ++i) {
        for (std::size_t j = i + 1; j < near_.size(); ++j) {
            const DVec3 &a = near_[i].normal, &b = near_[j].normal;
            if (a.y < kLeastGroundUp || b.y < kLeastGroundUp || glm::dot(level(a), level(b)) >= 0.0) continue;
            const DVec3 crease = glm::cross(a, b);
            const double length = glm::length(crease);
            // Along the crease it still slides where that is too steep.
            if (length < 1e-9 || std::abs(crease.y) / length > std::sin(double(c.desc.max_slope_rad))) continue;
            return {true, kUp, near_[i].body, near_[i].point};
        }
    }
    return out;
}

CharacterController::Ground CharacterController::follow_down(const Character& c, double depth, DVec3& feet) {
    const DVec3 down(0.0, -depth, 0.0);
    const auto hit = query_.sweep(c.capsule(feet), c.desc.radius_m, down, {});
    if (!hit) return {};
    const DVec3 reached = feet + down * hit->time;
    const Ground ground = ground_at(c, reached);
    if (ground.found) feet = reached;
    return ground;
}

bool CharacterController::step_up(const Character& c, const DVec3& along, const DVec3& reached, DVec3& feet) {
    if (c.desc.step_height_m <= 0.0f) return false;
    const DVec3 ahead = glm::normalize(along);
    const DVec3 up(0.0, double(c.desc.step_height_m), 0.0);
    const auto ceiling = query_.sweep(c.capsule(c.feet), c.desc.radius_m, up, {});
    const DVec3 risen = up * (ceiling ? ceiling->time : 1.0);
    DVec3 at = slide(c, c.feet + risen, along, true).feet;
    if (glm::dot(at - reached, ahead) <= 1e-3 * glm::length(along)) return false;  // no farther than without
    const Ground ground = follow_down(c, risen.y + double(c.desc.step_height_m), at);
    // By what it would stand on, not by its feet: the round foot is still beside a high step's edge.
    if (!ground.found || ground.point.y - c.feet.y > double(c.desc.step_height_m) + kGroundReach_m) return false;
    feet = at;
    return true;
}

void CharacterController::walk(Character& c, const DVec3& along, double tick_s) {
    const DVec3 start = c.feet;
    DVec3 feet = start;
    if (along != DVec3(0.0)) {
        // Along the ground, with the wished speed in the plan.
        const DVec3& n = c.ground_normal;
        const DVec3 tilted(along.x, n.y > 0.0 ? -(n.x * along.x + n.z * along.z) / n.y : 0.0, along.z);
        const Slide plain = slide(c, start, tilted, true);
        feet = plain.feet;
        DVec3 stepped;
        if (plain.hit && glm::length(level(feet - start)) < 0.999 * glm::length(along) &&
            step_up(c, along, feet, stepped))
            feet = stepped;
    }
    Ground ground = follow_down(c, double(c.desc.step_height_m) + kGroundReach_m, feet);
    c.feet = feet;
    if (along != DVec3(0.0)) {
        // What was stopped has no speed to keep; a step up or down is none either.
        const DVec3 moved = level(feet - start);
        const double longest = glm::length(along), length = glm::length(moved);
        c.velocity = moved * (length > longest ? longest / (length * tick_s) : 1.0 / tick_s);
    }
    c.velocity.y = 0.0;
    if (const Body* const body = bodies_.find(c.ground); body != nullptr && !ground.found)
        c.velocity += carried(body->before, body->frame, start) / tick_s;  // off the edge, it keeps that motion
    c.on_ground = ground.found;
    c.ground = ground.body;
    c.ground_normal = ground.normal;
}

void CharacterController::fall(Character& c, double tick_s) {
    c.velocity.y = std::max(c.velocity.y - double(c.desc.gravity_m_s2) * tick_s, -double(c.desc.max_fall_m_s));
    const DVec3 start = c.feet;
    const bool falling = c.velocity.y < 0.0;
    const double wanted = glm::length(c.velocity) * tick_s;
    const Slide moved = slide(c, start, c.velocity * tick_s, false);
    c.feet = moved.feet;
    if (moved.hit) {
        const DVec3 gone = (c.feet - start) / tick_s;
        // Against a ceiling it stops rising, on a slope it turns along; it is never made faster.
        const double before = glm::length(c.velocity), now = glm::length(gone);
        c.velocity = now > before ? gone * (before / now) : gone;
    }
    const Ground ground = c.velocity.y <= 0.0 || moved.hit ? ground_at(c, c.feet) : Ground{};
    // How fast the ground falls away under a level motion: who rises faster than that has left it.
    const double along_ground = -glm::dot(level(c.velocity), ground.normal) / std::max(ground.normal.y, 0.1);
    c.on_ground = ground.found && c.velocity.y <= kTiny + std::max(0.0, along_ground);
    // Wedged in, by whatever: what cannot fall stands, and may step or jump out.
    if (!ground.found && falling && glm::length(c.feet - start) < 0.01 * wanted) c.on_ground = true;
    c.ground = c.on_ground ? ground.body : BodyId{};
    c.ground_normal = c.on_ground ? ground.normal : kUp;
    if (c.on_ground) c.velocity.y = 0.0;
}

void CharacterController::push_bodies(const Character& c, const DVec3& wished, double tick_s,
                                      std::vector<Push>& pushes) {
    const double most = double(c.desc.push_force_n) * tick_s;
    for (std::size_t i = 0; i < met_.size(); ++i) {
        const Obstacle& o = met_[i];
        const bool again = std::any_of(met_.begin(), met_.begin() + std::ptrdiff_t(i),
                                       [&](const Obstacle& earlier) { return earlier.body == o.body; });
        const Body* const body = bodies_.find(o.body);
        if (again || body == nullptr || !body->is_dynamic() || o.body == c.ground) continue;
        const DVec3 into = -level(o.normal);
        const double length = glm::length(into);
        if (length < 0.3) continue;  // rather above or below it
        const DVec3 ahead = into / length;
        const double closing = glm::dot(wished - DVec3(body->velocity), ahead);
        if (closing <= 0.0) continue;
        const double impulse = std::min(most, double(body->desc.mass_kg) * closing);
        pushes.push_back({o.body, Vec3(ahead * impulse), o.point});
    }
    const Body* const floor = bodies_.find(c.ground);
    if (c.on_ground && floor != nullptr && floor->is_dynamic() && !floor->asleep)
        pushes.push_back({c.ground, Vec3(0.0f, -c.desc.mass_kg * c.desc.gravity_m_s2 * float(tick_s), 0.0f), c.feet});
}

}  // namespace ff::physics
