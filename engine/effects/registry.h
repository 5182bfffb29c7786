#pragma once
// The effects there are: what calls for each, what it needs, and who decides. An effect is one file and one row here.

#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "engine/effects/effect.h"
#include "engine/effects/lamp_grid.h"
#include "engine/farfield/layer_index.h"
#include "engine/scene/static_scene.h"

namespace ff::effects {

/// What a scene holds that effects ask for, found once when it is opened; borrows.
struct SceneFacts {
    const farfield::LayerIndex* layer_index = nullptr;  ///< where blended triangles are; nullptr: nowhere
    const LampGrid* lamps = nullptr;                    ///< nullptr: there are none
    std::span<const DBox3> water;                       ///< around what holds open water
    std::span<const DBox3> mirrors;                     ///< around what holds other mirrors
    bool has_foliage = false;                           ///< something sways in wind
};

/// Boxes around the instances that hold a material with one of these flags.
[[nodiscard]] std::vector<DBox3> find_material(const scene::StaticScene& scene, std::uint32_t flags);
/// Whether one of the boxes is nearer to the eye.
[[nodiscard]] bool is_any_within(std::span<const DBox3> boxes, const WorldPos& eye, double within_m);

/// What decisions read: the scene, this frame's light and air, the viewer, and what the user wants.
struct Conditions {
    const scene::StaticScene& scene;
    const scene::Environment& environment;  ///< of this frame
    const SceneFacts& facts;
    std::span<const scene::Instance> dynamic;
    WorldPos eye{0.0};
    bool by_opengl = false;           ///< the rasteriser draws and shades all of the picture
    bool reprojects = false;          ///< pixels keep the last frame's primitives
    std::optional<bool> sun_shadows;  ///< wanted whatever the scene says
    float blend_within_m = 0.0f;
    float lamps_within_m = 0.0f;
    std::uint64_t reflection_rays = 0;
    float reflections_within_m = 0.0f;
    float water_within_m = 0.0f;
    float wind_within_m = 0.0f;
    Hearing hearing;
    Simulations simulations;
    EffectSet without = 0;  ///< switched off by the user
};

/// One effect.
struct Effect {
    EffectId id;
    std::string_view name;       ///< lower case, underscores
    std::string_view called_by;  ///< what calls for it, in words
    std::string_view needs;      ///< what it takes while it is active
    std::string_view shader;     ///< define of the rasteriser's programs that have it; empty: none
    Decision (*decide)(const Conditions&);
};

/// All effects, by id.
[[nodiscard]] std::span<const Effect> registry();

[[nodiscard]] const Effect* find_effect(std::string_view name);

/// Decides every effect of a frame; reads only what it is given, allocates nothing.
[[nodiscard]] Decisions decide_effects(const Conditions& conditions);

// The rows' own rules, one file each.
[[nodiscard]] Decision decide_atmosphere(const Conditions& conditions);
[[nodiscard]] Decision decide_birds(const Conditions& conditions);
[[nodiscard]] Decision decide_fog(const Conditions& conditions);
[[nodiscard]] Decision decide_lamps(const Conditions& conditions);
[[nodiscard]] Decision decide_rain(const Conditions& conditions);
[[nodiscard]] Decision decide_reflections(const Conditions& conditions);
[[nodiscard]] Decision decide_rigid_bodies(const Conditions& conditions);
[[nodiscard]] Decision decide_snow(const Conditions& conditions);
[[nodiscard]] Decision decide_sound(const Conditions& conditions);
[[nodiscard]] Decision decide_sun_shadows(const Conditions& conditions);
[[nodiscard]] Decision decide_transparency(const Conditions& conditions);
[[nodiscard]] Decision decide_water(const Conditions& conditions);
[[nodiscard]] Decision decide_wind(const Conditions& conditions);

}  // namespace ff::effects
