#include "engine/effects/registry.h"

namespace ff::effects {

Decision decide_sound(const Conditions& conditions) {
    const Hearing& hearing = conditions.hearing;
    if (!hearing.is_called_for) return {State::off, "the scene has none"};
    if (!hearing.has_device) return {State::idle, "no device"};
    if (hearing.voices == 0) return {State::idle, "nothing is within hearing"};
    return {State::active, "something is within hearing"};
}

}  // namespace ff::effects
