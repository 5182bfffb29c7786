#pragma once
// What may be heard. Plain data, filled by worlds and games.

#include <cstdint>

#include "engine/math/types.h"

namespace ff::sound {

/// Component of an entity that sounds on and on where it is.
struct SoundSource {
    std::uint32_t clip = 0;    ///< of scene::SoundSet::clips
    float reference_m = 5.0f;  ///< heard at full gain up to here
    float gain = 1.0f;         ///< [0, 1]; 0: silent for now
};

/// Such a source at a moment.
struct Emitter {
    std::uint64_t id = 0;  ///< the same from frame to frame, no two alike
    WorldPos position{0.0};
    SoundSource source;
};

/// Something that is heard once.
struct SoundEvent {
    double at_s = 0.0;  ///< of the game; it is played by the first frame that shows this or a later time
    WorldPos position{0.0};
    SoundSource source;
};

}  // namespace ff::sound
