#pragma once

#include <ctime>

namespace ff::bench {

/// Processor time of the whole process: what stays comparable on a machine that others use too.
class CpuWatch {
  public:
    void restart() { start_ = now(); }
    [[nodiscard]] double seconds() const { return now() - start_; }
    [[nodiscard]] double milliseconds() const { return 1e3 * seconds(); }

  private:
    static double now() {
        timespec t{};
        clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
        return double(t.tv_sec) + 1e-9 * double(t.tv_nsec);
    }
    double start_ = now();
};

}  // namespace ff::bench
