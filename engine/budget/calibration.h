#pragma once
// A fixed piece of work of the kind that frames are made of: what it takes says how fast the machine is just now, so
// that a time limit measured on one machine can be held on another, or on the same one beside other work.

#include <cstdint>
#include <vector>

namespace ff::budget {

/// Rays through a grid of triangles that a core's own caches hold: about a millisecond on one core of 2022, spread over
/// as many workers as frames use. It slows down as passes do when other work shares the core. Reads of 32 MiB were
/// tried beside it: what they cost changed by a fifth from run to run (1.45 to 1.78 ms), so they are no part of it. No
/// code of the renderer: a pass that becomes slower must not make the calibration slower, too.
class Calibration {
  public:
    Calibration();

    /// Does the work once. @return the milliseconds that it took, on the clock of work_ns()
    double run();
    /// Of the last run: the same in each, for any number of workers.
    [[nodiscard]] std::uint64_t checksum() const { return checksum_; }

  private:
    struct Triangle {
        float corner[3], edge1[3], edge2[3];
    };
    [[nodiscard]] std::uint64_t walk_rays(std::size_t begin, std::size_t end) const;

    std::vector<Triangle> triangles_;  // two a cell, 288 KiB
    std::vector<std::uint64_t> partial_;
    std::uint64_t checksum_ = 0;
};

}  // namespace ff::budget
