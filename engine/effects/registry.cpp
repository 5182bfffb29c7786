#include "engine/effects/registry.h"

#include <algorithm>
#include <array>

namespace ff::effects {
namespace {

constexpr std::array<Effect, kEffectCount> kEffects{{
    {EffectId::atmosphere, "atmosphere", "[sky] model = \"atmosphere\"",
     "a table of the sky for each position of the sun, three exponentials a shaded pixel", "AIR", decide_atmosphere},
    {EffectId::birds, "birds", "[[model]] flock, near the viewer", "a system, an entity and a pose for each bird", "",
     decide_birds},
    {EffectId::fog, "fog", "[sky] fog_density_per_m", "an exponential a shaded pixel", "FOG", decide_fog},
    {EffectId::lamps, "lamps", "[[lamp]], once the sun is low and one is near",
     "a grid over the lamps, light by pixel in tiles within their reach", "", decide_lamps},
    {EffectId::rain, "rain", "[weather] rain",
     "wet ground by pixel, streaks, a ray for each new square metre of shelter", "", decide_rain},
    {EffectId::reflections, "reflections", "[[water]], and glass or metal of a roughness up to 0.2, near the viewer",
     "a buffer and an image of the frame's size, rays by mirrors in their planes", "", decide_reflections},
    {EffectId::rigid_bodies, "rigid_bodies", "[[model]] mass_kg, or bodies of the game, awake and near the viewer",
     "a system, an entity and a hull for each body, contacts with the world's own triangles", "", decide_rigid_bodies},
    {EffectId::snow, "snow", "[weather] snow",
     "snow on the ground by pixel, flakes, a ray for each new square metre of shelter", "", decide_snow},
    {EffectId::sound, "sound", "[[sound]], near the viewer or played by the game",
     "a sound device, its thread, a voice for each of the 16 loudest sources", "", decide_sound},
    {EffectId::sun_shadows, "sun_shadows", "[sun] shadows, while the sun is up",
     "a hierarchy of sun boxes, a byte a pixel, rays towards the sun", "", decide_sun_shadows},
    {EffectId::transparency, "transparency", "blended materials near the viewer",
     "two buffers of the image's size, a search for layers", "BLEND", decide_transparency},
    {EffectId::water, "water", "[[water]] and [terrain] water_m, near the viewer",
     "five trains of waves by pixel of water, which no panorama keeps", "", decide_water},
    {EffectId::wind, "wind", "[weather] wind_m_s and foliage near the viewer",
     "three trains of waves by pixel of foliage, whose tiles no panorama keeps", "SWAYS", decide_wind},
}};

constexpr bool is_in_order() {
    for (std::size_t i = 0; i < kEffects.size(); ++i)
        if (std::size_t(kEffects[i].id) != i) return false;
    return true;
}
static_assert(is_in_order());

}  // namespace

std::span<const Effect> registry() {
    return kEffects;
}

const Effect* find_effect(std::string_view name) {
    const auto at = std::find_if(kEffects.begin(), kEffects.end(), [&](const Effect& e) { return e.name == name; });
    return at == kEffects.end() ? nullptr : &*at;
}

Decisions decide_effects(const Conditions& conditions) {
    Decisions decisions;
    for (const Effect& effect : kEffects) {
        Decision& decision = decisions[effect.id];
        decision = effect.decide(conditions);
        if (decision.state != State::off && (conditions.without & set_of(effect.id)) != 0)
            decision = {State::off, "switched off"};
    }
    return decisions;
}

}  // namespace ff::effects
