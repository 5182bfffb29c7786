#include "engine/effects/registry.h"

namespace ff::effects {

Decision decide_atmosphere(const Conditions& conditions) {
    if (!(conditions.environment.atmosphere.turbidity > 0.0f)) return {State::off, "the scene has a painted sky"};
    return {State::active, "the scene's sky is an atmosphere"};
}

}  // namespace ff::effects
