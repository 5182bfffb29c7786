#pragma once
// Temporal reprojection of hits: the last frame's visible points say which primitive each pixel of this frame probably
// sees; one intersection settles it, and what remains is cast.
//
// Based on: Havran, Bittner, Seidel, "Exploiting Temporal Coherence in Ray Casted Walkthroughs", SCCG 2003 (P3).
//
//   POS  the last frame's VisibilityBuffer: a pixel's ray and depth are its point, instance and triangle its object
//   AIP  AuxiliaryImage: the nearest point that landed in each pixel of this frame
//
//   reproject()  POS to AIP; points that the checks of P3 4 distrust are left out     reproject_points.cpp, _splat.cpp
//   verify()     AIP to hits; what fails, and what is due to be sampled anew, is left  reproject_verify.cpp
//
// It is an approximation: one intersection proves that a primitive is hit, not that nothing nearer is. Things thinner
// than a pixel may be missed for up to `resample_period` frames, as may things that come from behind others where no
// check sees it. Modes that must be exact do not use it.
//
// Ours differs from P3: all primitives that landed in a tile or next to it are intersected, and the nearest hit stays,
// so that silhouettes need no second chance; a vote counts the points around that lie on the hit's surface instead of
// on its very triangle (Vote); the order along epipolar lines is tested along rows and columns of the old image, in the
// old orientation, so that it holds for any rotation; counts are gathered, not splatted.

#include <cstdint>
#include <span>
#include <vector>

#include "engine/core/zero_pages.h"
#include "engine/farfield/pixel_mask.h"
#include "engine/farfield/ray_caster.h"

namespace ff::farfield {

/// Whose points count for a pixel (P3 3.3).
enum class Vote {
    surface,    ///< those of the hit's primitive, or about as far away as the hit
    primitive,  ///< those of the hit's primitive alone, as in P3
    any,        ///< all
};

/// Defaults are P3's where it names one.
struct ReprojectSettings {
    int min_count = 5;  ///< m_cnt: so many of the 3 x 3 pixels around need a point that votes for the hit. [0, 9]
    Vote vote = Vote::surface;
    float surface_share = 0.05f;  ///< depths within this share of each other are one surface. [0, 1]
    /// P3 4.1: nothing is reprojected when the eye has left the last frame's view frustum.
    bool check_view_frustum = true;
    bool check_occlusion = true;  ///< P3 4.2: points that others overtook are left out
    int resample_period = 9;      ///< P3 4.3, N: each pixel is cast at least once in so many frames; 0: never. [0, 64]
    /// Pixels are due in blocks of this side, a power of two in [1, 32]; 1: singly, as in P3. 32: what a beam serves.
    int resample_block_px = 32;
    bool check_abrupt = true;    ///< P3 4.3.1: points that come too fast are left out
    int abrupt_frames = 4;       ///< its N: a step must not exceed depth / 2 / N. [1, 64]
    bool use_background = true;  ///< P3 5.2: sky is reprojected like everything else

    friend bool operator==(const ReprojectSettings&, const ReprojectSettings&) = default;
};

/// How a pixel's answer came about (P3 Figure 6).
enum class PixelCause : std::uint8_t { verified, background, failed, resampled, abrupt };

/// Pixels by cause; they add up to the image.
struct ReprojectCounts {
    std::uint64_t verified = 0;    ///< seen by one intersection
    std::uint64_t background = 0;  ///< sky that was sky
    std::uint64_t failed = 0;      ///< to be cast: nothing landed here, or it was not hit
    std::uint64_t resampled = 0;   ///< to be cast because it is due
    std::uint64_t abrupt = 0;      ///< to be cast because what landed here came too fast
    std::uint64_t primitives = 0;  ///< intersected, each once per tile
};

/// The auxiliary image plane: what landed where. With a border of empty pixels, so that neighbours need no test.
struct AuxiliaryImage {
    static constexpr int kBorder = 16;                     ///< columns; rows have a border of 1
    static constexpr std::uint32_t kEmpty = kUnresolved;   ///< nothing landed here
    static constexpr std::uint32_t kAbrupt = 0xFFFFFFFDu;  ///< only points that came too fast
    int width = 0, height = 0, stride = 0, rows = 0;
    ZeroPageVector<std::uint32_t> instance;  ///< or kSkyInstance, kEmpty, kAbrupt
    ZeroPageVector<std::uint32_t> triangle;
    ZeroPageVector<float> depth;  ///< from the new eye, along its view axis

    void resize(int new_width, int new_height);
    [[nodiscard]] std::size_t index(int x, int y) const {
        return std::size_t(y + 1) * std::size_t(stride) + std::size_t(x + kBorder);
    }
};

/// Where the points of the last frame land, laid out as the VisibilityBuffer.
struct ReprojectedPoints {
    static constexpr std::int32_t kOutside = -1;          ///< left out
    static constexpr std::int32_t kAbruptBit = 1 << 30;   ///< comes too fast
    ZeroPageVector<std::int32_t> target;                  ///< index into the AuxiliaryImage, or kOutside
    ZeroPageVector<float> depth;                          ///< from the new eye, along its view axis; +inf for sky
    ZeroPageVector<float> down;                           ///< tangent from the new eye in the old orientation
    std::vector<std::int32_t> first_target, last_target;  ///< per old row: least and greatest; first > last: none

    void resize(const VisibilityBuffer& like);
};

/// Which pixels are due to be cast in a frame (P3 Figure 5): disjoint for `period` frames in a row, all of the image in
/// so many frames.
[[nodiscard]] TileMask resample_mask(const ReprojectSettings& settings, int tile_x, int tile_y,
                                     std::uint64_t frame_number);

/// Reprojects frame after frame of one scene. Scratch is sized at the first frame of a size.
class Reprojection {
  public:
    explicit Reprojection(const scene::StaticScene& scene) : scene_(scene) {}

    /// Lets the last frame's points land in this frame's pixels.
    /// @param last_view  whose frame `last` holds; same size as `view`
    /// @param last       instances that are not the scene's own (moving ones) give no points
    /// @return false where nothing may be reprojected: the eye left the last view frustum
    bool reproject(const PinholeView& last_view, const VisibilityBuffer& last, const PinholeView& view,
                   const ReprojectSettings& settings);

    /// Intersects each pixel with what landed around it, after reproject() returned true.
    /// @param out   may be the buffer that was `last`. Pixels that are verified or background are written
    /// @param left  tiles of all other pixels
    ReprojectCounts verify(const PinholeView& view, const ReprojectSettings& settings, std::uint64_t frame_number,
                           VisibilityBuffer& out, std::vector<TileRequest>& left);

    /// Of the last verify(): pixels by cause.
    struct Causes {
        PixelMask verified, background, failed, resampled, abrupt;
        [[nodiscard]] PixelCause at(int x, int y) const;
    };
    [[nodiscard]] const Causes& causes() const { return causes_; }
    [[nodiscard]] const AuxiliaryImage& auxiliary() const { return auxiliary_; }

  private:
    scene::StaticScene scene_;
    ReprojectedPoints points_;
    AuxiliaryImage auxiliary_;
    Causes causes_;
};

}  // namespace ff::farfield
