#pragma once

#include <chrono>

namespace ff {

/// Wall time since it was made or restarted. Profiling only: time that decides anything comes in as an argument.
class Stopwatch {
  public:
    [[nodiscard]] double seconds() const { return std::chrono::duration<double>(Clock::now() - start_).count(); }
    [[nodiscard]] double milliseconds() const { return 1e3 * seconds(); }
    void restart() { start_ = Clock::now(); }

  private:
    using Clock = std::chrono::steady_clock;
    Clock::time_point start_ = Clock::now();
};

}  // namespace ff
