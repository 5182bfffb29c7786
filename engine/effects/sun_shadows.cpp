#include "engine/effects/registry.h"

namespace ff::effects {

/// Only what casts pixels knows shadows, and only where there is a sun.
Decision decide_sun_shadows(const Conditions& conditions) {
    const scene::Environment& environment = conditions.environment;
    if (!conditions.sun_shadows.value_or(environment.sun_shadows))
        return {State::off, conditions.sun_shadows ? "switched off" : "the scene asks for none"};
    if (conditions.by_opengl) return {State::off, "the rasteriser knows none"};
    if (environment.sun_radiance == Vec3(0.0f)) return {State::idle, "there is no sunlight"};
    return {State::active, conditions.sun_shadows ? "switched on" : "the scene asks for them"};
}

}  // namespace ff::effects
