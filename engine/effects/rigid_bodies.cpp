#include "engine/effects/registry.h"

namespace ff::effects {

Decision decide_rigid_bodies(const Conditions& conditions) {
    const Simulation& bodies = conditions.simulations[EffectId::rigid_bodies];
    if (!bodies.is_called_for) return {State::off, "the scene has none"};
    if (bodies.moving == 0) return {State::idle, "all are at rest, or far away"};
    return {State::active, "some are moving"};
}

}  // namespace ff::effects
