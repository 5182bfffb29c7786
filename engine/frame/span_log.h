#pragma once
// When a frame's passes and effects ran: what a trace draws. Of fixed size, so that no frame allocates for it.

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace ff::frame {

/// A stretch of time that a pass or an effect took; a pass may run in several. Times as core's steady_ns().
struct Span {
    std::int64_t begin_ns = 0, end_ns = 0;
    std::uint8_t index = 0;  ///< of kPassNames, or of effects::registry()
    bool is_effect = false;
};

class SpanLog {
  public:
    /// Six faces of the panorama with four passes each, and every pass once more.
    static constexpr std::size_t kCapacity = 64;

    /// What no longer fits is counted, not kept.
    void add(const Span& span) {
        if (count_ < kCapacity)
            spans_[count_++] = span;
        else
            ++dropped_;
    }
    /// In the order in which they ended.
    [[nodiscard]] std::span<const Span> spans() const { return {spans_.data(), count_}; }
    [[nodiscard]] std::size_t dropped() const { return dropped_; }

    std::int64_t begin_ns = 0, end_ns = 0;  ///< of the frame

  private:
    std::array<Span, kCapacity> spans_;  // 1.5 KiB
    std::size_t count_ = 0, dropped_ = 0;
};

}  // namespace ff::frame
