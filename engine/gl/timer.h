#pragma once

#include <array>
#include <optional>

#include "engine/gl/object.h"

namespace ff::gl {

namespace detail {
void delete_query(GLuint id);
}

/// GPU time of one pass, without stalling: results come a few frames late. begin/end pairs do not nest.
class Timer {
  public:
    Timer() = default;
    static Timer make();

    void begin();
    void end();
    /// The newest result that has arrived since the last call, milliseconds.
    std::optional<double> poll_ms();

  private:
    static constexpr unsigned kInFlight = 4;
    std::array<Object<detail::delete_query>, kInFlight> queries_;
    unsigned begun_ = 0, read_ = 0;
};

}  // namespace ff::gl
