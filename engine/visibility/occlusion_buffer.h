#pragma once
// What a view has drawn so far, as a small pyramid of depths in memory that boxes are tested against.
//
// Based on: Greene, Kass, Miller, "Hierarchical Z-Buffer Visibility", SIGGRAPH 1993. Ours: the depths are those of the
// rasteriser itself, read back after the big near occluders; so what is tested needs no proxies, masked leaves hide by
// the pixels that they truly cover, and no second rasteriser's rounding has to be bounded.

#include <span>
#include <vector>

#include "engine/math/bounds.h"
#include "engine/math/camera.h"

namespace ff::visibility {

class OcclusionBuffer {
  public:
    /// Takes in what was drawn.
    /// @param depth         [width * height], top row first: near_plane_m / depth along the view axis, 0 where nothing
    ///                      was drawn (reversed depth, infinite far plane)
    /// @param near_plane_m  > 0
    void build(const PinholeView& view, std::span<const float> depth, float near_plane_m);

    /// Whether every pixel that the box may touch shows something nearer. Conservative: the box is taken at its nearest
    /// corner's depth, a pixel wider on all sides, over whole blocks of pixels; one that reaches the near plane, or is
    /// empty, is not hidden. A box outside the image is.
    [[nodiscard]] bool is_hidden(const DBox3& box) const;

  private:
    static constexpr int kBlockPixels = 4;    ///< a side, of level 0
    static constexpr int kBlocksTested = 16;  ///< a side, at most; else a coarser level is read
    /// Interpolated depths are off by a few units in the last place of the largest term, for slivers by far more.
    static constexpr double kDepthSlack = 1e-3;

    struct Level {
        int width = 0, height = 0;
        std::size_t first = 0;  ///< of farthest_
    };
    void reduce_pixels(std::span<const float> depth);
    void resize(int width, int height);

    DMat3 camera_from_world_{1.0};
    WorldPos position_{0.0};
    double u_step_ = 1, u_first_ = 0, v_step_ = 1, v_first_ = 0;
    int width_ = 0, height_ = 0;
    double near_plane_m_ = 0;
    std::vector<Level> levels_;
    std::vector<float> farthest_;  ///< smallest reversed depth of each block, level by level; 1.3 * pixels / 16 floats
    std::vector<float> row_;       ///< scratch: smallest of kBlockPixels rows, by column
};

}  // namespace ff::visibility
