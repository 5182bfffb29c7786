#pragma once
// A fingerprint of everything that the next tick depends on, taken each tick: two runs of the same commands that differ
// in it have parted, and its lanes say at which entity.

#include <array>
#include <bit>
#include <cstdint>
#include <optional>
#include <type_traits>

#include "engine/ecs/entity.h"

namespace ff::replay {

/// One tick's fingerprint.
struct StateDigest {
    /// Entities are sorted into lanes by their index modulo two numbers without a common factor, so that a pair of
    /// differing lanes names one of 992.
    static constexpr int kFirstModulus = 31, kSecondModulus = 32;
    static constexpr int kLanes = kFirstModulus + kSecondModulus;

    std::uint64_t all = 0;
    std::array<std::uint8_t, kLanes> lanes{};

    friend bool operator==(const StateDigest&, const StateDigest&) = default;
};

/// Index of the entity in which two digests differ; nothing where they agree, or where no single one explains it.
/// Right where one entity of fewer than kFirstModulus * kSecondModulus differs, but for one chance in 128.
[[nodiscard]] std::optional<std::uint32_t> differing_entity(const StateDigest& a, const StateDigest& b);

/// Takes the values of a state, bit by bit: 0.0 and -0.0 differ. Values are numbers and enums one by one, never
/// structs, whose padding is anything.
class StateHash {
  public:
    /// What follows belongs to this entity; before the first call, to none.
    void entity(ecs::Entity e);
    template <class T>
    void add(T value) {
        static_assert(std::is_arithmetic_v<T> || std::is_enum_v<T>, "numbers and enums, one by one");
        if constexpr (std::is_same_v<T, double>)
            mix(std::bit_cast<std::uint64_t>(value));
        else if constexpr (std::is_same_v<T, float>)
            mix(std::bit_cast<std::uint32_t>(value));
        else
            mix(std::uint64_t(value));
    }
    /// The values of a vector or quaternion.
    template <class... T>
    requires(sizeof...(T) > 1) void add(T... values) { (add(values), ...); }

    [[nodiscard]] StateDigest digest();

  private:
    void mix(std::uint64_t value);
    void close_entity();

    StateDigest digest_;
    std::uint64_t of_entity_ = 0;
    std::optional<std::uint32_t> index_;
};

}  // namespace ff::replay
