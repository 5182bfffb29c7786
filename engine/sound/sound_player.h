#pragma once
// Plays what is heard through OpenAL.

#include <cstdint>
#include <memory>
#include <span>

#include "engine/core/result.h"
#include "engine/math/camera.h"
#include "engine/scene/sound.h"
#include "engine/sound/sound_source.h"

namespace ff::sound {

/// An open device with a world's recordings. One at a time: OpenAL knows one current context. Move-only.
class SoundPlayer {
  public:
    /// Opens the usual device. Errors (failure): there is none, as on a machine without sound.
    static Result<SoundPlayer> open(const scene::SoundSet& sounds);
    /// A device that nobody hears: render() gives its samples. Errors (failure): this OpenAL has no loopback.
    static Result<SoundPlayer> open_loopback(const scene::SoundSet& sounds, int rate_hz);
    SoundPlayer(SoundPlayer&&) noexcept;
    SoundPlayer& operator=(SoundPlayer&&) noexcept;
    ~SoundPlayer();

    /// Takes up where the viewer is and what sounds; plays each event once that came since the last update.
    /// The world's own sources are heard beside `emitters`. Steady calls allocate nothing.
    /// @param emitters  ids below 2^63
    /// @param time_s    of the game. Going back, as after a load, plays no event twice.
    /// @param volume    of all, [0, 1]
    void update(const Camera& ear, std::span<const Emitter> emitters, std::span<const SoundEvent> events, double time_s,
                float volume);
    /// Ends all that sounds.
    void silence();

    /// Sources that are heard since the last update.
    [[nodiscard]] std::uint32_t voices() const;

    /// Loopback only: the next samples of two channels, left and right in turn.
    void render(std::span<std::int16_t> samples);

  private:
    struct Impl;
    explicit SoundPlayer(std::unique_ptr<Impl> impl);
    std::unique_ptr<Impl> impl_;
};

}  // namespace ff::sound
