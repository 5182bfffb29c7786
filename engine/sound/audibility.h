#pragma once
// Which of all that sounds is heard: the loudest few.

#include <span>
#include <vector>

#include "engine/sound/sound_source.h"

namespace ff::sound {

/// Sources that may be heard at a time.
inline constexpr std::size_t kMostVoices = 16;
/// Quieter than this, 1/200 or -46 dB, is not heard.
inline constexpr float kLeastGain = 0.005f;

/// How loud a source is at a distance: its gain, times reference over distance beyond the reference. OpenAL's
/// AL_INVERSE_DISTANCE_CLAMPED with a rolloff of 1. 0 for what is not a number.
[[nodiscard]] float heard_gain(const SoundSource& source, double distance_m);

/// The emitters that are heard, at most so many.
/// @param out  indices of emitters, loudest first, equal ones by id; its memory is kept
void choose_voices(std::span<const Emitter> emitters, const WorldPos& ear, std::size_t most,
                   std::vector<std::uint32_t>& out);

}  // namespace ff::sound
