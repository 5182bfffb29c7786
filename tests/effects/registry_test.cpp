// Who decides what an effect does, and why.

#include "engine/effects/registry.h"

#include <gtest/gtest.h>

#include <set>

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

}  // namespace
}  // namespace ff::effects
