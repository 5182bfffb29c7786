#pragma once
// What a frame knows of an effect: whether it runs, why, and what it costs. Plain data; the table of all effects is
// registry.h.

#include <array>
#include <cstdint>
#include <string_view>

namespace ff::effects {

enum class EffectId : std::uint8_t {
    atmosphere,
    birds,
    fog,
    lamps,
    rain,
    reflections,
    rigid_bodies,
    snow,
    sound,
    sun_shadows,
    transparency,
    water,
    wind
};
inline constexpr std::size_t kEffectCount = 13;

enum class State : std::uint8_t {
    off,     ///< nothing calls for it: no memory, no shader, no system, no ray, no time
    idle,    ///< called for, but not seen or not near: it keeps what it has and takes no time
    active,  ///< part of this frame
};
inline constexpr std::array<std::string_view, 3> kStateNames{"off", "idle", "active"};

/// A frame's decision about one effect. Compared, printed and recorded with the plan.
struct Decision {
    State state = State::off;
    std::string_view reason;  ///< a phrase of static storage

    friend bool operator==(const Decision&, const Decision&) = default;
};

/// The decisions about all effects, by id.
struct Decisions {
    std::array<Decision, kEffectCount> of{};

    [[nodiscard]] Decision& operator[](EffectId id) { return of[std::size_t(id)]; }
    [[nodiscard]] const Decision& operator[](EffectId id) const { return of[std::size_t(id)]; }
    [[nodiscard]] bool is_active(EffectId id) const { return (*this)[id].state == State::active; }
};

/// What a frame is told of sound, which is heard beside it, not drawn: by whoever opened the world and the device.
struct Hearing {
    bool is_called_for = false;  ///< the world has something to be heard
    bool has_device = false;
    std::uint32_t voices = 0;  ///< sources that are heard

    friend bool operator==(const Hearing&, const Hearing&) = default;
};

/// What a frame is told of an effect that is simulated beside it, by whoever ticks it.
struct Simulation {
    bool is_called_for = false;     ///< the world has some of it
    std::uint32_t moving = 0;       ///< things that the last tick moved
    std::uint32_t systems = 0;      ///< scheduled for it
    double ms = 0.0;                ///< of the ticks since the last frame
    std::uint64_t allocations = 0;  ///< likewise, where somebody counts them

    friend bool operator==(const Simulation&, const Simulation&) = default;
};

/// Of the effects that are simulated: birds and rigid_bodies.
struct Simulations {
    std::array<Simulation, 2> of{};

    [[nodiscard]] Simulation& operator[](EffectId id) { return of[id == EffectId::birds ? 0 : 1]; }
    [[nodiscard]] const Simulation& operator[](EffectId id) const { return of[id == EffectId::birds ? 0 : 1]; }

    friend bool operator==(const Simulations&, const Simulations&) = default;
};

/// What an effect did in a frame.
struct Work {
    double ms = 0.0;                ///< of passes that are its own; what it adds to shared ones is found by comparing
    std::uint64_t allocations = 0;  ///< on the heap, where somebody counts them (core/heap_count.h)
    std::uint64_t rays = 0;
    std::uint32_t systems = 0;  ///< of a schedule, for what is simulated
};

/// Effects by id, a bit each.
using EffectSet = std::uint32_t;
[[nodiscard]] constexpr EffectSet set_of(EffectId id) {
    return 1u << unsigned(id);
}

}  // namespace ff::effects
