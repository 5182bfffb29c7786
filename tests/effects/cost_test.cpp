// What is off costs nothing: memory, rays and time of scenes with and without each effect.

#include <gtest/gtest.h>

#include "engine/core/heap_count.h"
#include "engine/frame/renderer.h"
#include "engine/scenery/scenery.h"
#include "tests/support/town.h"
#include "tests/support/wind.h"
#include "tests/support/worlds.h"
#include "tools/ff/heap_counter.h"

namespace ff::effects {
namespace {

using frame::FrameSettings;
using frame::FrameStats;

constexpr int kWidth = 160, kHeight = 120;

class EffectCosts : public testing::Test {
  protected:
    EffectCosts() { set_heap_counter(tool::heap_allocations); }

    /// Walks a few frames. @return of the last one, work of all of them
    FrameStats walk(const scene::StaticScene& scene, const FrameSettings& settings, int frames = 8) {
        frame::Casters casters(scene);
        frame::Renderer renderer(scene, casters, nullptr, kWidth, kHeight);
        shading::Image image;
        std::array<Work, kEffectCount> sum{};
        FrameStats last;
        for (int f = 0; f < frames; ++f) {
            last = renderer.draw({.position = {0.5, 1.7, 60.0 - 0.1 * f}}, {}, settings, image);
            for (std::size_t e = 0; e < kEffectCount; ++e) {
                sum[e].ms += last.effect_work[e].ms;
                sum[e].allocations += last.effect_work[e].allocations;
                sum[e].rays += last.effect_work[e].rays;
            }
        }
        has_sun_light_ = renderer.history().sun != nullptr;
        has_reflections_ = renderer.history().reflections != nullptr;
        has_shelter_ = renderer.history().shelter != nullptr;
        sky_tables_ = renderer.history().daylight.made();
        last.effect_work = sum;
        return last;
    }

    /// Who is off has done nothing, who is idle no work.
    static void expect_nothing(const FrameStats& stats, EffectId id) {
        EXPECT_NE(stats.effects[id].state, State::active);
        EXPECT_EQ(stats.work(id).ms, 0.0);
        EXPECT_EQ(stats.work(id).allocations, 0u);
        EXPECT_EQ(stats.work(id).rays, 0u);
    }

    bool has_sun_light_ = false, has_shelter_ = false, has_reflections_ = false;
    std::uint64_t sky_tables_ = 0;
};

TEST_F(EffectCosts, a_plain_scene_pays_for_no_effect) {
    scene::SceneData data = test::make_city({.cells = 2});
    const FrameStats stats = walk(data.view(), {.fixed_near_m = 0.0});
    for (const Effect& effect : registry()) expect_nothing(stats, effect.id);
    EXPECT_FALSE(has_sun_light_);
    EXPECT_FALSE(has_shelter_);
    EXPECT_FALSE(has_reflections_);
    EXPECT_EQ(sky_tables_, 0u);
}

TEST_F(EffectCosts, each_effect_alone_is_paid_for_and_no_other) {
    for (const Effect& effect : registry()) {
        scene::SceneData data = test::make_small_town({.glass = effect.id == EffectId::transparency});
        data.environment.fog_density_per_m = effect.id == EffectId::fog ? 1e-4f : 0.0f;
        data.environment.sun_shadows = effect.id == EffectId::sun_shadows;
        data.environment.atmosphere.turbidity = effect.id == EffectId::atmosphere ? 2.0f : 0.0f;
        data.environment.weather.rain = effect.id == EffectId::rain ? 0.5f : 0.0f;
        data.environment.weather.snow = effect.id == EffectId::snow ? 0.5f : 0.0f;
        const std::uint32_t gloss = effect.id == EffectId::water         ? scene::kMaterialWater
                                    : effect.id == EffectId::reflections ? scene::kMaterialMirror
                                                                         : 0u;
        for (scene::Material& material : data.materials)
            if (material.flags & scene::kMaterialSpecular) material.flags |= gloss;
        for (scene::Mesh& mesh : data.meshes)
            if (mesh.material_flags & scene::kMaterialSpecular) mesh.material_flags |= gloss;
        if (effect.id == EffectId::wind) {
            test::let_leaves_sway(data);
            data.environment.weather.wind_m_s = {5.0f, 0.0f};
        }
        if (effect.id == EffectId::lamps)
            data.lamps.push_back({.position = {0.0, 4.0, 50.0}, .on_below_sun_deg = 90.0f});
        Simulations simulations;
        if (effect.id == EffectId::birds || effect.id == EffectId::rigid_bodies)
            simulations[effect.id] = {.is_called_for = true, .moving = 3, .systems = 1, .ms = 0.5};
        // Water mirrors: without rays it has waves alone.
        const std::uint64_t rays = effect.id == EffectId::water ? 0 : FrameSettings{}.reflection_rays;
        const FrameStats stats = walk(data.view(), {.fixed_near_m = 0.0,
                                                    .reflection_rays = rays,
                                                    .reflections_within_m = 1000.0f,
                                                    .hearing = {.is_called_for = effect.id == EffectId::sound,
                                                                .has_device = effect.id == EffectId::sound,
                                                                .voices = effect.id == EffectId::sound ? 1u : 0u},
                                                    .simulations = simulations});
        for (const Effect& other : registry()) {
            if (other.id == effect.id) {
                EXPECT_EQ(stats.effects[other.id].state, State::active) << other.name;
            } else {
                expect_nothing(stats, other.id);
            }
        }
        EXPECT_EQ(has_sun_light_, effect.id == EffectId::sun_shadows);
        EXPECT_EQ(has_reflections_, effect.id == EffectId::reflections);
        EXPECT_EQ(has_shelter_, effect.id == EffectId::rain || effect.id == EffectId::snow);
        EXPECT_EQ(sky_tables_, effect.id == EffectId::atmosphere ? 1u : 0u);
        if (effect.id == EffectId::sun_shadows) {
            EXPECT_GT(stats.work(effect.id).rays, 1000u);
            EXPECT_GT(stats.work(effect.id).ms, 0.0);
        }
        // The same scene with it switched off.
        const FrameStats without = walk(data.view(), {.fixed_near_m = 0.0,
                                                      .reflection_rays = rays,
                                                      .simulations = simulations,
                                                      .without_effects = set_of(effect.id)});
        expect_nothing(without, effect.id);
        EXPECT_EQ(without.effects[effect.id].state, State::off);
    }
}

TEST(SceneryCosts, steady_ticks_take_nothing_from_the_heap) {
    set_heap_counter(tool::heap_allocations);
    scene::SceneData data = test::make_single_triangle(Vec3(-50, 0, -50), Vec3(-50, 0, 50), Vec3(80, 0, 0));
    scene::MeshSource box;
    test::append_box(box, Vec3(-0.5f), Vec3(0.5f), 1, 0);
    const std::uint32_t mesh = data.add_mesh(scene::prepare_mesh(box, data.materials));
    data.finish(64);
    scene::WorldInfo info;
    info.name = "yard";
    info.dynamic_instances = {{.mesh = mesh, .position = {0, 30, 0}}, {.mesh = mesh, .position = {0, 60, 0}}};
    info.flocks = {{{.position = {0, 30, 0}, .first_instance = 0, .instance_count = 1}, 20, 40.0f}};
    // Falls all the time that is watched.
    info.loose_bodies = {{{.position = {0, 60, 0}, .first_instance = 1, .instance_count = 1}, 10.0f}};
    const scene::World world(std::move(data), std::move(info));
    const auto scenery = *scenery::Scenery::make(world);
    const Camera viewer{.position = {0.0, 2.0, 20.0}};
    for (int t = 0; t < 60; ++t) scenery->tick(viewer);
    (void)scenery->take_work();
    for (int t = 0; t < 120; ++t) scenery->tick(viewer);
    const Simulations work = scenery->take_work();
    for (const EffectId id : {EffectId::birds, EffectId::rigid_bodies}) {
        EXPECT_GT(work[id].moving, 0u);
        EXPECT_GT(work[id].ms, 0.0);
        EXPECT_EQ(work[id].allocations, 0u);
    }
    // Through the fall and the landing, and through them again.
    for (const bool again : {false, true}) {
        scenery->reset();
        (void)scenery->take_work();
        for (int t = 0; t < 900; ++t) scenery->tick(viewer);
        const Simulations all = scenery->take_work();
        EXPECT_EQ(all[EffectId::rigid_bodies].moving, 0u) << "it has come to rest";
        if (again) {
            EXPECT_EQ(all[EffectId::rigid_bodies].allocations, 0u);
        }
    }
}

}  // namespace
}  // namespace ff::effects
