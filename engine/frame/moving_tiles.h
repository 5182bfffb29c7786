#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "engine/farfield/ray_caster.h"
#include "engine/math/camera.h"
#include "engine/scene/static_scene.h"

namespace ff::frame {

/// Which tiles of a view instances may show in: those that the boxes' outlines touch.
class MovingTiles {
  public:
    /// @param tiles  of the view, each at multiples of farfield::kTileSize
    /// @return those of them that some instance's box may be seen in, in their order; good until the next call.
    ///         Conservative. Steady calls allocate nothing.
    std::span<const farfield::TileRequest> find(const PinholeView& view, std::span<const scene::Instance> instances,
                                                std::span<const farfield::TileRequest> tiles);

  private:
    std::vector<std::uint8_t> touched_;  // by row, then column
    std::vector<farfield::TileRequest> found_;
};

}  // namespace ff::frame
