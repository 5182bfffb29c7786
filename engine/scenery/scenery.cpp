#include "engine/scenery/scenery.h"

#include <fmt/format.h>

#include "engine/core/check.h"
#include "engine/core/heap_count.h"
#include "engine/core/work_clock.h"
#include "engine/physics/systems.h"
#include "engine/scenery/birds.h"
#include "engine/scenery/loose_bodies.h"

namespace ff::scenery {
namespace {

/// No two wings beat as one.
constexpr double kBeatApart_s = 0.37;

bool has(effects::EffectSet set, effects::EffectId id) {
    return (set & effects::set_of(id)) != 0;
}

/// What a stretch of time and heap was spent on.
class Spent {
  public:
    explicit Spent(effects::Simulation& on) : on_(on) {}
    ~Spent() {
        on_.ms += 1e-6 * double(work_ns() - begin_ns_);
        on_.allocations += heap_allocation_count() - allocations_;
    }
    Spent(const Spent&) = delete;
    Spent& operator=(const Spent&) = delete;

  private:
    effects::Simulation& on_;
    std::int64_t begin_ns_ = work_ns();
    std::uint64_t allocations_ = heap_allocation_count();
};

}  // namespace

struct Scenery::Impl {
    explicit Impl(const scene::World& shown) : world(shown) {}

    Status add_bodies(double within_m);
    void add_birds(double within_m);
    void reset();

    const scene::World& world;
    ecs::Registry registry;
    ecs::Schedule birds, bodies;
    std::unique_ptr<physics::PhysicsWorld> physics;
    std::vector<ecs::Entity> bird_entities, body_entities;
    std::vector<BirdStart> bird_starts;
    std::vector<ecs::LocalTransform> body_starts;
    std::vector<std::byte> physics_start;
    std::uint64_t ticks = 0;
    effects::Simulations work;
};

Status Scenery::Impl::add_bodies(double within_m) {
    physics =
        std::make_unique<physics::PhysicsWorld>(world.scene(), physics::PhysicsSettings{.active_range_m = within_m});
    const std::vector<scene::LooseBody>& all = world.info().loose_bodies;
    for (std::size_t i = 0; i < all.size(); ++i) {
        const LooseBodyStart start = start_of(world, all[i]);
        body_starts.push_back({.position = start.desc.pose.position, .rotation = start.desc.pose.rotation});
        const ecs::Entity entity = registry.create(body_starts.back(), start.model);
        if (const auto body = physics::attach_body(registry, *physics, entity, start.desc); !body)
            return bad_input(fmt::format("{}: loose body {}: {}", world.info().name, i, body.error().message));
        body_entities.push_back(entity);
    }
    physics_start = physics->state();
    registry.resource<physics::PhysicsTick>().world = physics.get();
    physics::add_physics_system(bodies);
    work[effects::EffectId::rigid_bodies].systems = 1;
    return {};
}

void Scenery::Impl::add_birds(double within_m) {
    Flocks& flocks = registry.resource<Flocks>();
    flocks.within_m = within_m;
    for (const scene::Flock& flock : world.info().flocks) {
        const auto index = std::uint32_t(flocks.homes.size());
        flocks.homes.push_back({flock.model.position, flock.radius_m});
        for (std::uint32_t i = 0; i < flock.birds; ++i) {
            const BirdStart& start = bird_starts.emplace_back(start_of(flocks.homes[index], i, flock.birds, index));
            bird_entities.push_back(registry.create(start.at, start.bird, model_of(flock.model)));
        }
    }
    add_bird_system(birds);
    work[effects::EffectId::birds].systems = 1;
}

void Scenery::Impl::reset() {
    ticks = 0;
    for (std::size_t i = 0; i < bird_entities.size(); ++i) {
        *registry.get<ecs::LocalTransform>(bird_entities[i]) = bird_starts[i].at;
        *registry.get<Bird>(bird_entities[i]) = bird_starts[i].bird;
    }
    for (std::size_t i = 0; i < body_entities.size(); ++i)
        *registry.get<ecs::LocalTransform>(body_entities[i]) = body_starts[i];
    if (physics) {
        const Status restored = physics->set_state(physics_start);
        FF_CHECK(bool(restored), "a world refuses its own state: {}", restored.error().message);
    }
    for (effects::Simulation& simulation : work.of)
        simulation.moving = 0, simulation.ms = 0.0, simulation.allocations = 0;
}

Scenery::Scenery(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Scenery::~Scenery() = default;

Result<std::unique_ptr<Scenery>> Scenery::make(const scene::World& world, const ScenerySettings& settings,
                                               effects::EffectSet without) {
    auto impl = std::make_unique<Impl>(world);
    const scene::WorldInfo& info = world.info();
    impl->work[effects::EffectId::birds].is_called_for = !info.flocks.empty();
    impl->work[effects::EffectId::rigid_bodies].is_called_for = !info.loose_bodies.empty();
    if (!info.flocks.empty() && !has(without, effects::EffectId::birds)) impl->add_birds(settings.birds_within_m);
    if (!info.loose_bodies.empty() && !has(without, effects::EffectId::rigid_bodies))
        FF_TRY(impl->add_bodies(settings.bodies_within_m));
    return std::unique_ptr<Scenery>(new Scenery(std::move(impl)));
}

void Scenery::reset() {
    impl_->reset();
}

void Scenery::tick(const Camera& viewer) {
    Impl& s = *impl_;
    ++s.ticks;
    if (!s.bird_entities.empty()) {
        effects::Simulation& work = s.work[effects::EffectId::birds];
        const Spent spent(work);
        Flocks& flocks = s.registry.resource<Flocks>();
        flocks.viewer = viewer.position;
        flocks.vertical_fov = viewer.vertical_fov;
        s.birds.run(s.registry);
        work.moving = flocks.flying;
    }
    if (s.physics) {
        effects::Simulation& work = s.work[effects::EffectId::rigid_bodies];
        const Spent spent(work);
        auto& tick = s.registry.resource<physics::PhysicsTick>();
        tick.viewer = viewer.position;
        s.bodies.run(s.registry);
        work.moving = tick.stats.bodies_stepped;
    }
}

std::uint64_t Scenery::ticks() const {
    return impl_->ticks;
}

void Scenery::show(std::vector<scene::Instance>& instances, std::vector<animation::ModelState>& models,
                   effects::EffectSet without) const {
    Impl& s = *impl_;
    const double seconds = double(s.ticks) / kTicksPerSecond;
    const auto show_one = [&](ecs::Entity entity, double time_s) {
        const auto& at = *s.registry.get<ecs::LocalTransform>(entity);
        show_model(s.world, *s.registry.get<ShownModel>(entity), at.position, at.rotation, time_s, instances, models);
    };
    for (std::size_t i = 0; i < s.bird_entities.size() && !has(without, effects::EffectId::birds); ++i)
        if (s.registry.resource<Flocks>().is_near(s.registry.get<Bird>(s.bird_entities[i])->flock))
            show_one(s.bird_entities[i], seconds + kBeatApart_s * double(i));
    if (s.physics && !has(without, effects::EffectId::rigid_bodies)) {
        for (const ecs::Entity entity : s.body_entities) show_one(entity, seconds);
        return;
    }
    for (const scene::LooseBody& body : s.world.info().loose_bodies) {
        const ShownModel model = model_of(body.model);
        show_model(s.world, model, model.placed_at, model.placed_turn, seconds, instances, models);
    }
}

effects::Simulations Scenery::take_work() {
    const effects::Simulations taken = impl_->work;
    for (effects::Simulation& simulation : impl_->work.of) simulation.ms = 0.0, simulation.allocations = 0;
    return taken;
}

}  // namespace ff::scenery
