// Who decides what an effect does, and why.

#include "engine/effects/registry.h"

#include <gtest/gtest.h>

#include <set>

#include "engine/effects/wind.h"
#include "tests/support/wind.h"
#include "tests/support/worlds.h"

namespace ff::effects {
namespace {

/// A city, and what a test changes of it.
struct Place {
    scene::SceneData data = test::make_city({.cells = 1});
    scene::StaticScene scene = data.view();
    farfield::LayerIndex layer_index = farfield::make_layer_index(scene);
    SceneFacts facts{.layer_index = &layer_index};
    Conditions conditions{.scene = scene, .environment = scene.environment, .facts = facts, .blend_within_m = 60.0f};
};

TEST(EffectRegistry, every_effect_has_a_name_of_its_own_and_says_what_calls_for_it) {
    std::set<std::string_view> names;
    for (const Effect& effect : registry()) {
        EXPECT_TRUE(names.insert(effect.name).second) << effect.name;
        EXPECT_FALSE(effect.called_by.empty());
        EXPECT_FALSE(effect.needs.empty());
        EXPECT_EQ(find_effect(effect.name), &effect);
    }
    EXPECT_EQ(names.size(), kEffectCount);
    EXPECT_EQ(find_effect("confetti"), nullptr);
}

TEST(EffectRegistry, a_plain_scene_calls_for_nothing) {
    const Place place;
    const Decisions decisions = decide_effects(place.conditions);
    for (const Effect& effect : registry()) {
        EXPECT_EQ(decisions[effect.id].state, State::off) << effect.name;
        EXPECT_FALSE(decisions[effect.id].reason.empty()) << effect.name;
    }
}

TEST(EffectRegistry, fog_in_the_air_is_active_and_can_be_switched_off) {
    Place place;
    place.scene.environment.fog_density_per_m = 1e-4f;
    EXPECT_EQ(decide_effects(place.conditions)[EffectId::fog].state, State::active);
    place.conditions.without = set_of(EffectId::fog);
    EXPECT_EQ(decide_effects(place.conditions)[EffectId::fog], (Decision{State::off, "switched off"}));
}

TEST(EffectRegistry, sun_shadows_follow_the_scene_the_user_and_the_sun) {
    Place place;
    const auto state = [&] { return decide_effects(place.conditions)[EffectId::sun_shadows].state; };
    place.conditions.sun_shadows = true;
    EXPECT_EQ(state(), State::active);
    place.conditions.sun_shadows.reset();
    place.scene.environment.sun_shadows = true;
    EXPECT_EQ(state(), State::active);
    place.scene.environment.sun_radiance = Vec3(0.0f);
    EXPECT_EQ(state(), State::idle) << "they come back with the sun";
    place.scene.environment.sun_radiance = Vec3(1.0f);
    place.conditions.by_opengl = true;
    EXPECT_EQ(state(), State::off);
    place.conditions.by_opengl = false;
    place.conditions.sun_shadows = false;
    EXPECT_EQ(state(), State::off);
}

TEST(EffectRegistry, transparency_is_idle_where_nothing_see_through_is_near) {
    scene::SceneData data = test::make_single_triangle({-1, 0, 0}, {1, 0, 0}, {0, 2, 0});
    data.materials[0].flags |= scene::kMaterialBlend;
    data.materials[0].base_color.a = 0.5f;
    data.meshes[0].material_flags |= scene::kMaterialBlend;
    const scene::StaticScene scene = data.view();
    const farfield::LayerIndex layer_index = farfield::make_layer_index(scene);
    const SceneFacts facts{.layer_index = &layer_index};
    Conditions conditions{.scene = scene, .environment = scene.environment, .facts = facts, .blend_within_m = 60.0f};
    const auto state = [&] { return decide_effects(conditions)[EffectId::transparency].state; };
    conditions.eye = {0.0, 1.7, 20.0};
    EXPECT_EQ(state(), State::active);
    conditions.eye = {0.0, 1.7, 200.0};
    EXPECT_EQ(state(), State::idle);
    conditions.blend_within_m = 0.0f;
    EXPECT_EQ(state(), State::off) << "shown by coverage";
}

TEST(EffectRegistry, sound_needs_something_to_be_heard_a_device_and_an_ear_nearby) {
    Place place;
    const auto decide = [&] { return decide_effects(place.conditions)[EffectId::sound]; };
    EXPECT_EQ(decide().state, State::off);
    place.conditions.hearing.is_called_for = true;
    EXPECT_EQ(decide(), (Decision{State::idle, "no device"}));
    place.conditions.hearing.has_device = true;
    EXPECT_EQ(decide().state, State::idle);
    place.conditions.hearing.voices = 2;
    EXPECT_EQ(decide().state, State::active);
}

TEST(EffectRegistry, water_is_idle_beyond_its_distance_and_still_mirrors_there) {
    Place place;
    const std::vector<DBox3> water{{DVec3(-10.0, -1.0, -10.0), DVec3(10.0, 0.0, 10.0)}};
    place.facts.water = water;
    place.conditions.reflection_rays = 6'000;
    place.conditions.eye = {0.0, 2.0, 110.0};
    const auto state = [&](EffectId id) { return decide_effects(place.conditions)[id].state; };
    place.conditions.water_within_m = 101.0f;
    EXPECT_EQ(state(EffectId::water), State::active);
    place.conditions.water_within_m = 99.0f;
    EXPECT_EQ(state(EffectId::water), State::idle);
    EXPECT_EQ(state(EffectId::reflections), State::active) << "waves are one thing, what water mirrors another";
    place.conditions.water_within_m = 0.0f;
    EXPECT_EQ(state(EffectId::water), State::idle);
    place.conditions.by_opengl = true;
    EXPECT_EQ(state(EffectId::water), State::off);
}

TEST(EffectRegistry, wind_needs_air_that_moves_and_foliage_near_the_viewer) {
    scene::SceneData data = test::make_forest({.trees = 10, .size_m = 20.0, .leaves = 10});
    scene::StaticScene scene = data.view();
    SceneFacts facts{.has_foliage = has_foliage(scene)};
    Conditions conditions{
        .scene = scene, .environment = scene.environment, .facts = facts, .eye = {0, 2, 15}, .wind_within_m = 60.0f};
    const auto decide = [&] { return decide_effects(conditions)[EffectId::wind]; };
    scene.environment.weather.wind_m_s = {4.0f, 0.0f};
    EXPECT_EQ(decide(), (Decision{State::off, "nothing in the scene sways"})) << "masked is not yet foliage";
    test::let_leaves_sway(data);
    facts.has_foliage = has_foliage(scene);
    EXPECT_EQ(decide().state, State::active);
    conditions.eye.z = 200.0;
    EXPECT_EQ(decide().state, State::idle);
    conditions.eye.z = 15.0;
    conditions.reprojects = true;
    EXPECT_EQ(decide().state, State::off);
    conditions.reprojects = false;
    conditions.wind_within_m = 0.0f;
    EXPECT_EQ(decide(), (Decision{State::off, "switched off"}));
    conditions.wind_within_m = 60.0f;
    scene.environment.weather.wind_m_s = {0.0f, 0.05f};
    EXPECT_EQ(decide(), (Decision{State::off, "the air is still"}));
}

TEST(Wind, moves_leaves_by_its_strength_and_the_same_at_every_visit) {
    const scene::Weather breeze{.wind_m_s = {0.0f, 4.0f}}, storm{.wind_m_s = {0.0f, 40.0f}};
    EXPECT_TRUE(make_leaf_sway({}, {}, 1.0, 60.0f).is_none());
    EXPECT_FLOAT_EQ(make_leaf_sway({}, breeze, 1.0, 60.0f).amplitude_m, 0.04f);
    EXPECT_FLOAT_EQ(make_leaf_sway({}, storm, 1.0, 60.0f).amplitude_m, 0.1f) << "no leaf flies away";
    // Whoever looks: a leaf moves the same seen from two eyes, far from the origin, too. Phases are floats about an
    // eye.
    const WorldPos leaf(3.0e6, 5.0, -2.0e6);
    for (const double time_s : {0.0, 17.25, 86400.0}) {
        const WorldPos a = leaf - DVec3(2.0, 1.0, 3.0), b = leaf + DVec3(1.5, -0.5, 3.0);
        const LeafSway from_a = make_leaf_sway(a, breeze, time_s, 1000.0f),
                       from_b = make_leaf_sway(b, breeze, time_s, 1000.0f);
        const Vec2 uv(0.4f, 0.6f), s = leaf_shift(from_a, uv, 1.0f, Vec3(leaf - a)),
                                   t = leaf_shift(from_b, uv, 1.0f, Vec3(leaf - b));
        EXPECT_NEAR(s.x, t.x, 1e-5f);
        EXPECT_NEAR(s.y, t.y, 1e-5f);
    }
}

TEST(Wind, never_shifts_a_picture_out_of_its_card) {
    test::Random random(5);
    for (int i = 0; i < 20000; ++i) {
        const Vec2 uv(float(random.unit()), float(random.unit()));
        const Vec3 p = random.in_box(Vec3(-50.0f), Vec3(50.0f));
        const Vec2 to = uv + leaf_shift(test::storm(float(random.in(0.0, 100.0))), uv, float(random.in(0.0, 100.0)), p);
        EXPECT_TRUE(to.x >= 0.0f && to.x <= 1.0f && to.y >= 0.0f && to.y <= 1.0f) << uv.x << ", " << uv.y;
    }
}

}  // namespace
}  // namespace ff::effects
