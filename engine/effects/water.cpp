#include "engine/effects/registry.h"

namespace ff::effects {

Decision decide_water(const Conditions& conditions) {
    if (conditions.facts.water.empty()) return {State::off, "the scene has no open water"};
    if (conditions.by_opengl) return {State::off, "the rasteriser knows no waves"};
    if (is_any_within(conditions.facts.water, conditions.eye, double(conditions.water_within_m)))
        return {State::active, "open water is near"};
    return {State::idle, "no open water is near"};
}

}  // namespace ff::effects
