#include "engine/physics/physics_world.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "engine/core/check.h"
#include "engine/physics/numbers.h"
#include "engine/physics/physics_impl.h"

namespace ff::physics {
namespace {

Error not_alive(const char* what, std::uint32_t index, std::uint32_t generation) {
    return usage_error(fmt::format("{} {}/{} is not alive", what, index, generation));
}

}  // namespace

Status check_body(BodyDesc& desc) {
    FF_TRY(check_pose(desc.pose));
    FF_TRY(check_vector("velocity_m_s", desc.velocity_m_s, kMaxSpeed_m_s));
    FF_TRY(check_vector("spin_rad_s", desc.spin_rad_s, 1e4));
    FF_TRY(check_range("mass_kg", desc.mass_kg, 1e-3, 1e6));
    FF_TRY(check_range("friction", desc.friction, 0.0, 10.0));
    FF_TRY(check_range("restitution", desc.restitution, 0.0, 1.0));
    FF_TRY(check_range("rolling_resistance", desc.rolling_resistance, 0.0, 1.0));
    FF_TRY(check_range("linear_damping", desc.linear_damping, 0.0, 1.0));
    FF_TRY(check_range("angular_damping", desc.angular_damping, 0.0, 1.0));
    if (desc.motion != Motion::dynamic && desc.motion != Motion::kinematic)
        return usage_error(fmt::format("motion {}; expected dynamic or kinematic", int(desc.motion)));
    if (desc.motion == Motion::dynamic && desc.shape.kind == ShapeKind::mesh)
        return usage_error("a dynamic body of shape mesh; expected a hull, a box, a sphere or a capsule");
    return {};
}

Status check_character(const CharacterDesc& desc) {
    FF_TRY(check_vector("position", desc.position, kMaxCoordinate_m));
    FF_TRY(check_range("radius_m", desc.radius_m, 0.05, 5.0));
    FF_TRY(check_range("height_m", desc.height_m, 2.0 * double(desc.radius_m), 20.0));
    FF_TRY(check_range("crouch_height_m", desc.crouch_height_m, 2.0 * double(desc.radius_m), double(desc.height_m)));
    FF_TRY(check_range("step_height_m", desc.step_height_m, 0.0, 0.5 * double(desc.height_m)));
    FF_TRY(check_range("max_slope_rad", desc.max_slope_rad, 0.0, 1.5));
    FF_TRY(check_range("gravity_m_s2", desc.gravity_m_s2, 0.0, 1000.0));
    FF_TRY(check_range("jump_height_m", desc.jump_height_m, 0.0, 100.0));
    FF_TRY(check_range("ground_accel_m_s2", desc.ground_accel_m_s2, 0.0, 1e9));
    FF_TRY(check_range("air_accel_m_s2", desc.air_accel_m_s2, 0.0, 1e9));
    FF_TRY(check_range("max_fall_m_s", desc.max_fall_m_s, 0.0, 1e6));
    FF_TRY(check_range("push_force_n", desc.push_force_n, 0.0, 1e6));
    return check_range("mass_kg", desc.mass_kg, 0.0, 1e4);
}

Status check_input(const CharacterInput& input) {
    return check_vector("velocity_m_s", input.velocity_m_s, kMaxSpeed_m_s);
}

PhysicsWorld::Impl::Impl(const scene::StaticScene& scene_, const PhysicsSettings& settings_)
    : scene(scene_),
      settings(settings_),
      bodies(scene_),
      controller(scene_, bodies),
      finder(scene_),
      solver(settings_.tick_s, settings_.solver_iterations) {
    FF_CHECK(settings.tick_s >= 1e-4 && settings.tick_s <= 0.1, "tick of {} s", settings.tick_s);
    FF_CHECK(check_vector("gravity", settings.gravity_m_s2, 1000.0), "gravity out of range");
    FF_CHECK(settings.solver_iterations >= 3 && settings.solver_iterations <= 200, "{} iterations",
             settings.solver_iterations);
    FF_CHECK(settings.active_range_m > 0.0, "active range of {} m", settings.active_range_m);
}

PhysicsWorld::PhysicsWorld(const scene::StaticScene& scene, const PhysicsSettings& settings)
    : impl_(std::make_unique<Impl>(scene, settings)) {}
PhysicsWorld::~PhysicsWorld() = default;

std::uint64_t PhysicsWorld::tick() const {
    return impl_->tick;
}
const PhysicsSettings& PhysicsWorld::settings() const {
    return impl_->settings;
}
std::span<const BodyId> PhysicsWorld::moved_bodies() const {
    return impl_->moved;
}

// Bodies

Character* PhysicsWorld::Impl::find(CharacterId id) {
    if (id.index >= characters.size()) return nullptr;
    Character& c = characters[id.index];
    return c.alive && c.generation == id.generation ? &c : nullptr;
}

void PhysicsWorld::Impl::list_bodies() {
    awake.clear();
    kinematic.clear();
    asleep_count = 0;
    asleep_sum = 0;
    for (std::uint32_t slot = 0; slot < bodies.slot_count(); ++slot) {
        const Body& body = bodies[slot];
        if (!body.alive) continue;
        if (!body.is_dynamic())
            kinematic.push_back(slot);
        else if (body.asleep)
            count_asleep(slot, true);
        else
            awake.push_back(slot);
    }
}

void PhysicsWorld::Impl::count_asleep(std::uint32_t slot, bool sleeps) {
    asleep_count += sleeps ? 1u : ~0u;
    asleep_sum += sleeps ? hash_of(slot) : std::uint64_t(0) - hash_of(slot);
}

void PhysicsWorld::Impl::wake(std::uint32_t slot) {
    Body& body = bodies[slot];
    if (!body.is_dynamic() || !body.asleep) {
        body.still_s = 0.0f;
        return;
    }
    count_asleep(slot, false);
    body.asleep = false;
    body.still_s = 0.0f;
    awake.insert(std::lower_bound(awake.begin(), awake.end(), slot), slot);
}

void PhysicsWorld::Impl::fall_asleep(std::uint32_t slot) {
    Body& body = bodies[slot];
    body.asleep = true;
    body.velocity = body.spin = Vec3(0.0f);
    body.before = body.frame;
    count_asleep(slot, true);
    awake.erase(std::lower_bound(awake.begin(), awake.end(), slot));
}

void PhysicsWorld::Impl::wake_near(const DBox3& box) {
    bodies.find({box.center(), DVec3(0.0), box.extent() * 0.5 + DVec3(2.0 * kContactReach_m)}, near);
    for (const std::uint32_t slot : near) wake(slot);
}

Result<BodyId> PhysicsWorld::add_body(const BodyDesc& given) {
    Impl& s = *impl_;
    BodyDesc desc = given;
    FF_TRY(check_body(desc));
    FF_ASSIGN(std::shared_ptr<const Geometry> geometry, s.bodies.geometry_of(desc.shape));
    Body body;
    body.geometry = std::move(geometry);
    body.frame = body.before = body.target = frame_of(*body.geometry, desc.pose);
    if (desc.motion == Motion::dynamic) {
        body.velocity = desc.velocity_m_s;
        body.spin = desc.spin_rad_s;
        body.asleep = desc.asleep;
        if (body.asleep) body.velocity = body.spin = Vec3(0.0f);
    }
    body.desc = desc;
    const std::uint32_t slot = s.bodies.add(std::move(body));
    std::vector<std::uint32_t>& list = desc.motion == Motion::kinematic ? s.kinematic : s.awake;
    if (s.bodies[slot].asleep)
        s.count_asleep(slot, true);
    else
        list.insert(std::lower_bound(list.begin(), list.end(), slot), slot);
    return s.bodies.id_of(slot);
}

bool PhysicsWorld::remove_body(BodyId id) {
    Impl& s = *impl_;
    const Body* const body = s.bodies.find(id);
    if (body == nullptr) return false;
    const DBox3 bounds = body->bounds;
    if (body->is_dynamic() && body->asleep) {
        s.count_asleep(id.index, false);
    } else {
        std::vector<std::uint32_t>& list = body->is_dynamic() ? s.awake : s.kinematic;
        list.erase(std::lower_bound(list.begin(), list.end(), id.index));
    }
    s.bodies.remove(id.index);
    std::erase(s.moved, id);
    s.wake_near(bounds);
    return true;
}

bool PhysicsWorld::is_alive(BodyId id) const {
    return impl_->bodies.find(id) != nullptr;
}

BodyState PhysicsWorld::body(BodyId id) const {
    const Body* const body = impl_->bodies.find(id);
    FF_CHECK(body != nullptr, "body {}/{} is not alive", id.index, id.generation);
    return {pose_of(*body->geometry, body->frame), body->velocity, body->spin, body->asleep, body->desc.user};
}

Status PhysicsWorld::set_pose(BodyId id, const Pose& given) {
    Impl& s = *impl_;
    Pose pose = given;
    FF_TRY(check_pose(pose));
    Body* const body = s.bodies.find(id);
    if (body == nullptr) return not_alive("body", id.index, id.generation);
    s.wake(id.index);
    const DBox3 left = body->bounds;
    body->frame = body->before = body->target = frame_of(*body->geometry, pose);
    body->has_target = false;
    s.bodies.update_bounds(id.index);
    s.wake_near(left);
    s.wake_near(body->bounds);
    return {};
}

Status PhysicsWorld::set_velocity(BodyId id, const Vec3& velocity, const Vec3& spin) {
    FF_TRY(check_vector("velocity_m_s", velocity, kMaxSpeed_m_s));
    FF_TRY(check_vector("spin_rad_s", spin, 1e4));
    Body* const body = impl_->bodies.find(id);
    if (body == nullptr) return not_alive("body", id.index, id.generation);
    if (!body->is_dynamic()) return usage_error("a velocity for a kinematic body; move_kinematic moves it");
    impl_->wake(id.index);
    body->velocity = velocity;
    body->spin = spin;
    return {};
}

Status PhysicsWorld::apply_impulse(BodyId id, const Vec3& impulse, const WorldPos& at) {
    FF_TRY(check_vector("impulse_n_s", impulse, 1e9));
    FF_TRY(check_vector("at", at, kMaxCoordinate_m));
    Body* const body = impl_->bodies.find(id);
    if (body == nullptr) return not_alive("body", id.index, id.generation);
    if (!body->is_dynamic()) return usage_error("an impulse for a kinematic body; move_kinematic moves it");
    impl_->wake(id.index);
    const DMat3 turn = matrix_of(body->frame.rotation);
    const DVec3 torque = glm::cross(at - body->frame.position, DVec3(impulse));
    const DVec3 spin = turn * ((torque * turn) / DVec3(inertia_of(*body)));
    const auto limited = [](const Vec3& v, float most) { return glm::clamp(v, Vec3(-most), Vec3(most)); };
    body->velocity = limited(body->velocity + impulse / body->desc.mass_kg, kMaxSpeed_m_s);
    body->spin = limited(body->spin + Vec3(spin), 1e4f);
    return {};
}

Status PhysicsWorld::move_kinematic(BodyId id, const Pose& given) {
    Pose target = given;
    FF_TRY(check_pose(target));
    Body* const body = impl_->bodies.find(id);
    if (body == nullptr) return not_alive("body", id.index, id.generation);
    if (body->is_dynamic()) return usage_error("move_kinematic of a dynamic body; set_velocity or apply_impulse");
    body->target = frame_of(*body->geometry, target);
    body->has_target = true;
    return {};
}

// Characters

Status PhysicsWorld::Impl::give_shapes(Character& c) {
    const auto capsule = [&](float height) {
        const float r = c.desc.radius_m;
        return bodies.geometry_of(capsule_shape(r, std::max(0.0f, 0.5f * height - r)));
    };
    FF_ASSIGN(c.standing, capsule(c.desc.height_m));
    FF_ASSIGN(c.crouched, capsule(c.desc.crouch_height_m));
    return {};
}

Result<CharacterId> PhysicsWorld::add_character(const CharacterDesc& desc) {
    FF_TRY(check_character(desc));
    Impl& s = *impl_;
    Character made;
    made.desc = desc;
    FF_TRY(s.give_shapes(made));
    std::uint32_t slot = std::uint32_t(s.characters.size());
    if (s.free_characters.empty()) {
        s.characters.emplace_back();
        s.characters[slot].generation = 1;
    } else {
        slot = s.free_characters.back();
        s.free_characters.pop_back();
    }
    made.generation = s.characters[slot].generation;
    made.alive = true;
    made.feet = desc.position;
    s.characters[slot] = made;
    return CharacterId{slot, made.generation};
}

bool PhysicsWorld::remove_character(CharacterId id) {
    Character* const c = impl_->find(id);
    if (c == nullptr) return false;
    const std::uint32_t next = c->generation + 1;
    *c = Character{};
    c->generation = next == 0 ? 1 : next;
    impl_->free_characters.push_back(id.index);
    return true;
}

bool PhysicsWorld::is_alive(CharacterId id) const {
    return impl_->find(id) != nullptr;
}

Status PhysicsWorld::set_input(CharacterId id, const CharacterInput& input) {
    FF_TRY(check_input(input));
    Character* const c = impl_->find(id);
    if (c == nullptr) return not_alive("character", id.index, id.generation);
    c->input = input;
    return {};
}

Status PhysicsWorld::set_position(CharacterId id, const WorldPos& feet) {
    FF_TRY(check_vector("feet", feet, kMaxCoordinate_m));
    Character* const c = impl_->find(id);
    if (c == nullptr) return not_alive("character", id.index, id.generation);
    c->feet = feet;
    c->velocity = DVec3(0.0);
    c->on_ground = false;
    c->ground = {};
    return {};
}

CharacterState PhysicsWorld::character(CharacterId id) const {
    const Character* const c = impl_->find(id);
    FF_CHECK(c != nullptr, "character {}/{} is not alive", id.index, id.generation);
    return {c->feet,      Vec3(c->velocity), Vec3(c->ground_normal), c->ground,
            c->on_ground, c->crouching,      float(c->height()),     c->desc.user};
}

}  // namespace ff::physics
