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

    /// The same step by step: boxes one by one, then tiles one by one.
    void begin(const PinholeView& view);
    void add(const DBox3& bounds);
    [[nodiscard]] bool has(const farfield::TileRequest& tile) const;

  private:
    PinholeView view_;
    DMat3 camera_from_world_{1.0};
    int columns_ = 0, rows_ = 0;
    std::vector<std::uint8_t> touched_;  // by row, then column
    std::vector<farfield::TileRequest> found_;
};

}  // namespace ff::frame
