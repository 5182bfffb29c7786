#pragma once
// The bytes of a recording that its writer and its reader share; recording.h shows the whole.

#include <cstdint>
#include <string_view>

namespace ff::replay {

inline constexpr std::string_view kMagic = "FFREPLAY";

enum class RecordKind : std::uint8_t { tick = 1, state = 2, marker = 3, check = 4, end = 5 };

/// Which fields of a tick's command follow: those that changed, as signed differences.
enum TickField : std::uint8_t { kMoveField = 1, kYawField = 2, kPitchField = 4, kButtonsField = 8, kAllFields = 15 };

/// A checksum after so many ticks.
inline constexpr int kCheckTicks = 120;

/// Small numbers of either sign as small ones without: 0, -1, 1, -2 ...
[[nodiscard]] constexpr std::uint64_t fold_sign(std::int64_t value) {
    return (std::uint64_t(value) << 1) ^ std::uint64_t(value >> 63);
}
[[nodiscard]] constexpr std::int64_t unfold_sign(std::uint64_t value) {
    return std::int64_t(value >> 1) ^ -std::int64_t(value & 1);
}

}  // namespace ff::replay
