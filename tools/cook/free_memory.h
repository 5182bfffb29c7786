#pragma once
// A cook holds gigabytes of arrays, in turn: what one step frees, the next one asks for in other sizes. The C library
// would keep the pieces; this hands them back to the system.

#include <atomic>
#include <cstdint>

namespace ff::cook {

/// Counts what is freed and gives it back, a portion at a time.
class FreedMemory {
  public:
    /// @param bytes  just freed by the caller. Threads: any
    void add(std::uint64_t bytes);

  private:
    std::atomic<std::uint64_t> pending_ = 0;
};

}  // namespace ff::cook
