#include "engine/effects/registry.h"

namespace ff::effects {
namespace {

Decision decide_fall(float strength, bool by_opengl) {
    if (!(strength > 0.0f)) return {State::off, "none falls"};
    if (by_opengl) return {State::off, "the rasteriser knows none"};
    return {State::active, "it falls"};
}

}  // namespace

Decision decide_rain(const Conditions& conditions) {
    return decide_fall(conditions.environment.weather.rain, conditions.by_opengl);
}

Decision decide_snow(const Conditions& conditions) {
    return decide_fall(conditions.environment.weather.snow, conditions.by_opengl);
}

}  // namespace ff::effects
