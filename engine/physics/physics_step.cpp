// One tick: kinematic bodies go where they are told, characters walk between them, then the dynamic bodies near a
// character fall, touch, are solved island by island, and move.

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <numeric>

#include "engine/physics/numbers.h"
#include "engine/physics/physics_impl.h"

namespace ff::physics {
namespace {

// A body slower than this for so long sleeps, once all that it touches is as slow.
constexpr float kStillSpeed_m_s = 0.1f, kStillSpin_rad_s = 0.15f, kStill_s = 0.5f;
// An awake body that only leans on a sleeping one does not wake it.
constexpr float kWakingSpeed_m_s = 0.25f;

/// The rotation after turning by `spin` for a time. Without sines, which another C library rounds otherwise: the
/// tangent of the half angle by its series, off by less than 1e-4 of the angle up to 0.6 rad a tick.
glm::quat turned(const glm::quat& q, const Vec3& spin, float seconds) {
    const Vec3 half = spin * (0.5f * seconds);
    const float h2 = glm::dot(half, half);
    if (!(h2 > 0.0f)) return q;
    return glm::normalize(glm::quat(1.0f, half * (1.0f + h2 / 3.0f + h2 * h2 * (2.0f / 15.0f))) * q);
}

/// The spin that turns one rotation into another within a time; good to 1% up to a right angle.
Vec3 spin_between(const glm::quat& from, const glm::quat& to, float seconds) {
    glm::quat d = to * glm::conjugate(from);
    if (d.w < 0.0f) d = -d;
    const Vec3 tangent = Vec3(d.x, d.y, d.z) / std::max(d.w, 0.1f);
    return tangent * (2.0f / (seconds * (1.0f + 0.28f * glm::dot(tangent, tangent))));
}

float rolling_lever(const Body& body) {
    return body.desc.rolling_resistance * float(body.geometry->radius_m);
}

Vec3 limited(const Vec3& v, float most) {
    const float length = glm::length(v);
    return length > most ? v * (most / length) : v;
}

}  // namespace

StepStats PhysicsWorld::step(std::span<const WorldPos> viewers) {
    Impl& s = *impl_;
    StepStats stats;
    s.controller.query().reset_count();
    s.finder.reset_count();
    s.moved.clear();

    s.move_kinematic();
    s.move_characters(stats);
    s.choose_active(viewers, stats);
    s.find_contacts(stats);
    s.solve_islands(stats);

    ++s.tick;
    stats.bodies_stepped = std::uint32_t(s.active.size());
    stats.bodies_asleep = s.asleep_count;
    stats.triangles_tested = std::uint32_t(s.controller.query().triangles_tested() + s.finder.triangles_tested());
    return stats;
}

void PhysicsWorld::Impl::move_kinematic() {
    const float dt = float(settings.tick_s);
    for (const std::uint32_t slot : kinematic) {
        Body& body = bodies[slot];
        const bool moved_before = !(body.before == body.frame);
        body.before = body.frame;
        if (!body.has_target || body.target == body.frame) {
            body.has_target = false;
            if (moved_before) body.velocity = body.spin = Vec3(0.0f);
            continue;
        }
        body.velocity = Vec3((body.target.position - body.frame.position) / settings.tick_s);
        body.spin = spin_between(body.frame.rotation, body.target.rotation, dt);
        body.frame = body.target;
        body.has_target = false;
        DBox3 passed = body.bounds;
        bodies.update_bounds(slot);
        passed.add(body.bounds);
        wake_near(passed);
    }
}

void PhysicsWorld::Impl::move_characters(StepStats& stats) {
    pushes.clear();
    for (Character& c : characters) {
        if (!c.alive) continue;
        ++stats.characters;
        const bool was_on_ground = c.on_ground;
        const BodyId was_on = c.ground;
        controller.move(c, settings.tick_s, pushes);
        // Whoever lands on a sleeping body, or leaves it, wakes it.
        if (c.on_ground != was_on_ground || !(c.ground == was_on))
            for (const BodyId id : {was_on, c.ground})
                if (bodies.find(id) != nullptr) wake(id.index);
    }
    for (const Push& push : pushes) {
        Body& body = bodies[push.body.index];
        wake(push.body.index);
        const DMat3 turn = matrix_of(body.frame.rotation);
        const DVec3 torque = glm::cross(push.at - body.frame.position, DVec3(push.impulse_n_s));
        body.velocity += push.impulse_n_s / body.desc.mass_kg;
        body.spin += Vec3(turn * ((torque * turn) / DVec3(inertia_of(body))));
    }
}

void PhysicsWorld::Impl::choose_active(std::span<const WorldPos> viewers, StepStats& stats) {
    active.clear();
    placed.clear();
    solver_bodies.clear();
    const bool anyone = stats.characters > 0 || !viewers.empty();
    for (const std::uint32_t slot : awake) {
        Body& body = bodies[slot];
        bool in_range = !anyone;
        for (std::size_t c = 0; c < characters.size() && !in_range; ++c)
            in_range = characters[c].alive && distance_to(body.bounds, characters[c].feet) <= settings.active_range_m;
        for (std::size_t v = 0; v < viewers.size() && !in_range; ++v)
            in_range = distance_to(body.bounds, viewers[v]) <= settings.active_range_m;
        if (in_range) {
            activate(slot);
        } else {
            body.before = body.frame;
            ++stats.bodies_held;
        }
    }
}

/// A body's place among the solver's. Until it is found to be active it is one that contacts do not move.
std::uint32_t PhysicsWorld::Impl::place_of(std::uint32_t slot) {
    Body& body = bodies[slot];
    if (body.place >= 0) return std::uint32_t(body.place);
    body.place = std::int32_t(solver_bodies.size());
    SolverBody out;
    out.position = body.frame.position;
    out.rotation = body.frame.rotation;
    if (!body.is_dynamic()) {
        out.velocity = body.velocity;
        out.spin = body.spin;
    }
    solver_bodies.push_back(out);
    placed.push_back(slot);
    return std::uint32_t(body.place);
}

void PhysicsWorld::Impl::activate(std::uint32_t slot) {
    const float dt = float(settings.tick_s);
    SolverBody& mine = solver_bodies[place_of(slot)];
    Body& body = bodies[slot];
    body.active_at = std::int32_t(active.size());
    active.push_back(slot);
    mine.mass_kg = body.desc.mass_kg;
    mine.inertia = inertia_of(body);
    mine.velocity = limited(
        (body.velocity + settings.gravity_m_s2 * dt) * std::max(0.0f, 1.0f - body.desc.linear_damping * dt), 1e6f);
    mine.spin = limited(body.spin * std::max(0.0f, 1.0f - body.desc.angular_damping * dt), 1e3f);
}

void PhysicsWorld::Impl::add_pair(const SolverPair& pair) {
    // What bounces has to get there first: a contact that only keeps a gap from closing takes the speed away before.
    if (pair.restitution > 0.0f) std::erase_if(found, [](const Contact& c) { return c.distance > 0.001f; });
    if (found.empty()) return;
    pairs.push_back(pair);
    pairs.back().first_contact = std::uint32_t(contacts.size());
    pairs.back().contact_count = std::uint32_t(found.size());
    contacts.insert(contacts.end(), found.begin(), found.end());
}

void PhysicsWorld::Impl::find_contacts(StepStats& stats) {
    pairs.clear();
    contacts.clear();
    // The list grows while it is walked: what is hit wakes.
    for (std::size_t at = 0; at < active.size(); ++at) {
        const std::uint32_t slot = active[at];
        const Body& body = bodies[slot];
        const std::uint32_t place = place_of(slot);
        finder.with_scene(*body.geometry, body.frame, body.bounds, found);
        add_pair({.a = place,
                  .friction = body.desc.friction,
                  .restitution = body.desc.restitution,
                  .rolling_m = rolling_lever(body)});
        touch_bodies(slot, place);
        touch_characters(slot, place);
    }
    stats.contact_points = std::uint32_t(contacts.size());
}

void PhysicsWorld::Impl::touch_bodies(std::uint32_t slot, std::uint32_t place) {
    const Body& body = bodies[slot];
    bodies.find({body.bounds.center(), DVec3(0.0), body.bounds.extent() * 0.5 + DVec3(kContactReach_m)}, near);
    for (const std::uint32_t other_slot : near) {
        const Body& other = bodies[other_slot];
        // Each pair once, by the one that comes first.
        if (other_slot == slot || (other.active_at >= 0 && other.active_at < body.active_at)) continue;
        finder.between(*body.geometry, body.frame, body.bounds, *other.geometry, other.frame, found);
        if (found.empty()) continue;
        if (other.is_dynamic() && other.asleep && glm::length(body.velocity) > kWakingSpeed_m_s &&
            std::any_of(found.begin(), found.end(), [](const Contact& c) { return c.distance < 0.005f; })) {
            wake(other_slot);
            activate(other_slot);
        }
        add_pair({.a = place,
                  .b = place_of(other_slot),
                  .friction = body.desc.friction * other.desc.friction,
                  .restitution = body.desc.restitution * other.desc.restitution,
                  .rolling_m = std::max(rolling_lever(body), rolling_lever(other))});
    }
}

// A character is as hard to move as a wall; it has stopped at the body already, and pushed it by its own strength.
void PhysicsWorld::Impl::touch_characters(std::uint32_t slot, std::uint32_t place) {
    const Body& body = bodies[slot];
    for (Character& c : characters) {
        // What it stands on carries its weight as an impulse; feet do not hold a thing in place.
        if (!c.alive || c.ground == bodies.id_of(slot)) continue;
        if (distance_to(body.bounds, c.feet + DVec3(0.0, 0.5 * c.height(), 0.0)) > c.height()) continue;
        const Frame frame{c.feet + DVec3(0.0, 0.5 * c.height(), 0.0), {1.0f, 0.0f, 0.0f, 0.0f}};
        const Geometry& geometry = c.crouching ? *c.crouched : *c.standing;
        finder.between(*body.geometry, body.frame, body.bounds, geometry, frame, found);
        if (found.empty()) continue;
        if (c.place < 0) {
            c.place = std::int32_t(solver_bodies.size());
            SolverBody out;
            out.position = frame.position;
            out.velocity = limited(Vec3(c.ridden / settings.tick_s), 1e3f);
            solver_bodies.push_back(out);
        }
        add_pair({.a = place, .b = std::uint32_t(c.place)});
    }
}

void PhysicsWorld::Impl::solve_islands(StepStats& stats) {
    // Union of the bodies that contacts can move, by places; the lowest names the island.
    parent.resize(solver_bodies.size());
    std::iota(parent.begin(), parent.end(), 0u);
    const auto root_of = [&](std::uint32_t place) {
        while (parent[place] != place) place = parent[place] = parent[parent[place]];
        return place;
    };
    const auto is_moved = [&](std::uint32_t place) { return solver_bodies[place].mass_kg > 0.0f; };
    for (const SolverPair& pair : pairs) {
        if (pair.b == SolverPair::kScene || !is_moved(pair.b)) continue;
        const std::uint32_t a = root_of(pair.a), b = root_of(pair.b);
        parent[std::max(a, b)] = std::min(a, b);
    }
    // Members and pairs by island, each in its own order: a counting sort of two lists.
    const auto group = [&](std::size_t count, auto&& key_of, std::vector<std::uint32_t>& begin,
                           std::vector<std::uint32_t>& order) {
        begin.assign(solver_bodies.size() + 1, 0);
        order.resize(count);
        for (std::uint32_t i = 0; i < count; ++i) ++begin[key_of(i) + 1];
        for (std::size_t i = 1; i < begin.size(); ++i) begin[i] += begin[i - 1];
        for (std::uint32_t i = 0; i < count; ++i) order[begin[key_of(i)]++] = i;
        for (std::size_t i = begin.size() - 1; i > 0; --i) begin[i] = begin[i - 1];
        begin[0] = 0;
    };
    group(
        active.size(), [&](std::uint32_t i) { return root_of(place_of(active[i])); }, body_begin, body_order);
    group(
        pairs.size(), [&](std::uint32_t i) { return root_of(pairs[i].a); }, pair_begin, pair_order);

    for (std::uint32_t root = 0; root < solver_bodies.size(); ++root) {
        if (body_begin[root] == body_begin[root + 1]) continue;
        ++stats.islands;
        members.clear();
        island.clear();
        for (std::uint32_t i = body_begin[root]; i < body_begin[root + 1]; ++i) {
            island.push_back(active[body_order[i]]);
            members.push_back(place_of(active[body_order[i]]));
        }
        island_pairs.clear();
        for (std::uint32_t i = pair_begin[root]; i < pair_begin[root + 1]; ++i)
            island_pairs.push_back(pairs[pair_order[i]]);
        if (!island_pairs.empty()) solver.solve(solver_bodies, members, island_pairs, contacts);
        for (const std::uint32_t slot : island) integrate(slot);
        let_sleep();
    }
    for (const std::uint32_t slot : active) moved.push_back(bodies.id_of(slot));
    std::sort(moved.begin(), moved.end(), [](const BodyId& a, const BodyId& b) { return a.index < b.index; });

    for (const std::uint32_t slot : placed) bodies[slot].place = bodies[slot].active_at = -1;
    for (Character& c : characters) c.place = -1;
}

void PhysicsWorld::Impl::integrate(std::uint32_t slot) {
    Body& body = bodies[slot];
    const SolverBody& solved = solver_bodies[std::size_t(body.place)];
    const float dt = float(settings.tick_s);
    body.velocity = solved.velocity;
    body.spin = solved.spin;
    body.before = body.frame;
    DVec3 along = DVec3(body.velocity) * settings.tick_s;
    // A fast one goes only as far as the ball inside it is free; what it then touches stops it in the next tick.
    const double ball = 0.7 * body.geometry->inner_radius_m;
    if (glm::dot(along, along) > ball * ball) {
        const Segment center{body.frame.position, body.frame.position};
        const auto hit = controller.query().sweep(center, ball, along, {.except = bodies.id_of(slot)});
        if (hit) along *= hit->time;
    }
    body.frame.position += along + solved.shift;
    body.frame.rotation = turned(solved.turned ? solved.rotation : body.frame.rotation, body.spin, dt);
    // Past the end of the world it stays there.
    body.frame.position = glm::clamp(body.frame.position, DVec3(-kMaxCoordinate_m), DVec3(kMaxCoordinate_m));
    bodies.update_bounds(slot);

    const bool still = glm::length(body.velocity) < kStillSpeed_m_s && glm::length(body.spin) < kStillSpin_rad_s;
    body.still_s = still ? body.still_s + dt : 0.0f;
}

// An island sleeps as a whole: one that goes on would only wake the others again.
void PhysicsWorld::Impl::let_sleep() {
    for (const std::uint32_t slot : island)
        if (bodies[slot].still_s < kStill_s) return;
    for (const std::uint32_t slot : island) fall_asleep(slot);
}

}  // namespace ff::physics
