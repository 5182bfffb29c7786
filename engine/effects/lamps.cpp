#include <algorithm>
#include <cmath>

#include "engine/effects/registry.h"

namespace ff::effects {

Decision decide_lamps(const Conditions& conditions) {
    const LampGrid* lamps = conditions.facts.lamps;
    if (lamps == nullptr || lamps->is_empty()) return {State::off, "the scene has none"};
    if (conditions.by_opengl) return {State::off, "the rasteriser knows none"};
    if (!(conditions.lamps_within_m > 0.0f)) return {State::off, "switched off"};
    const double elevation_deg = degrees_of(std::asin(std::clamp(double(conditions.environment.to_sun.y), -1.0, 1.0)));
    if (elevation_deg >= lamps->first_on_below_deg()) return {State::idle, "it is day"};
    if (!lamps->has_lamp_within(conditions.eye, conditions.lamps_within_m)) return {State::idle, "none is near"};
    return {State::active, "the sun is low, and lamps are near"};
}

}  // namespace ff::effects
