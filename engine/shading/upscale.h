#pragma once

#include <cstdint>
#include <vector>

#include "engine/shading/shading_pass.h"

namespace ff::shading {

/// Enlarges an image bilinearly, pixel centres where they belong: what a frame that had to be drawn smaller is shown
/// by. Keeps its tables from call to call, so a steady frame allocates nothing.
class Upscaler {
  public:
    /// @param from  at least 1 x 1
    /// @param to    its size says how large; written whole. Parallel over rows.
    void run(const Image& from, Image& to);

  private:
    /// Where along one side a pixel of `to` reads: the first of two neighbours, and the second's weight of 256.
    struct Tap {
        std::uint32_t first = 0;
        std::uint32_t weight = 0;
    };
    static void make_taps(int from, int to, std::vector<Tap>& taps);

    std::vector<Tap> columns_, rows_;
};

}  // namespace ff::shading
