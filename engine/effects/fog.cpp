#include "engine/effects/registry.h"

namespace ff::effects {

Decision decide_fog(const Conditions& conditions) {
    if (!(conditions.environment.fog_density_per_m > 0.0f)) return {State::off, "the air is clear"};
    return {State::active, "the scene's air has fog"};
}

}  // namespace ff::effects
