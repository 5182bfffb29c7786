#pragma once
// Recordings in files.

#include <filesystem>

#include "engine/core/result.h"
#include "engine/scene/sound.h"

namespace ff::cook {

/// Reads a recording that libsndfile knows (WAV, FLAC, Ogg Vorbis ...), several channels mixed into one.
/// Errors (bad input): not such a file, empty, longer than ten minutes, a rate out of [1000, 192000] Hz.
/// @param name  of the clip
[[nodiscard]] Result<scene::SoundClip> read_sound(const std::filesystem::path& path, std::string name);

}  // namespace ff::cook
