#include "engine/effects/registry.h"

namespace ff::effects {

Decision decide_birds(const Conditions& conditions) {
    const Simulation& birds = conditions.simulations[EffectId::birds];
    if (!birds.is_called_for) return {State::off, "the scene has none"};
    if (birds.moving == 0) return {State::idle, "no flock is near"};
    return {State::active, "a flock is near"};
}

}  // namespace ff::effects
