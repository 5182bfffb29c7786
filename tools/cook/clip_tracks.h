#pragma once
// Tracks of a clip as few numbers: keys as they are, or even samples, whichever is smaller.

#include <vector>

#include "engine/scene/animation.h"

namespace ff::cook {

/// How far a track may be from what the source says, at any time.
inline constexpr float kMaxRotationError = 1e-3f;  ///< radians, of each joint against its parent
inline constexpr float kMaxScaleError = 1e-3f;
inline constexpr float kMaxTranslationError = 2e-4f;  ///< of the model's size

/// One channel of a glTF animation, as numbers.
struct SourceTrack {
    std::uint32_t joint = 0;
    scene::TrackPath path = scene::TrackPath::translation;
    scene::Interpolation interpolation = scene::Interpolation::linear;
    std::vector<float> times;   ///< seconds from 0, ascending
    std::vector<float> values;  ///< as Clip::values
};

/// Appends the track to the clip; its keys, or, where that takes fewer numbers and errs by no more than allowed,
/// samples at 15, 30 or 60 a second that are interpolated linearly. A track that never changes becomes one key.
/// @param max_translation_error_m  metres
void add_track(SourceTrack track, float max_translation_error_m, scene::Clip& clip);

}  // namespace ff::cook
