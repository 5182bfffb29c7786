#pragma once
// What a world sounds like: recordings, and places where they are heard.

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "engine/math/types.h"

namespace ff::scene {

/// A recording: one channel, linear.
struct SoundClip {
    std::string name;               ///< by which a game finds it; unique in a world
    std::uint32_t rate_hz = 44100;  ///< samples a second, [1000, 192000]
    std::vector<std::int16_t> samples;

    friend bool operator==(const SoundClip&, const SoundClip&) = default;
};

/// A place that sounds on and on.
struct SoundSource {
    WorldPos position{0.0};
    std::uint32_t clip = 0;
    float reference_m = 5.0f;  ///< heard at full gain up to here, then by the inverse of the distance. [0.1, 10000]
    float gain = 1.0f;         ///< [0, 1]

    friend bool operator==(const SoundSource&, const SoundSource&) = default;
};

struct SoundSet {
    std::vector<SoundClip> clips;
    std::vector<SoundSource> sources;

    friend bool operator==(const SoundSet&, const SoundSet&) = default;
};

inline constexpr std::uint32_t kNoSound = 0xFFFFFFFFu;
/// The clip of that name, or kNoSound.
[[nodiscard]] inline std::uint32_t find_sound(const SoundSet& sounds, std::string_view name) {
    for (std::size_t i = 0; i < sounds.clips.size(); ++i)
        if (sounds.clips[i].name == name) return std::uint32_t(i);
    return kNoSound;
}

}  // namespace ff::scene
