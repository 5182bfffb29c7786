#pragma once
// Temporal reprojection of hits: the last frame's visible points say which primitive each pixel of this frame probably
// sees; one intersection settles it, and what remains is cast.
//
// Based on: Havran, Bittner, Seidel, "Exploiting Temporal Coherence in Ray Casted Walkthroughs", SCCG 2003 (P3).
//
//   POS  the last frame's VisibilityBuffer: a pixel's ray and depth are its point, instance and triangle its object
//   AIP  AuxiliaryBand: the nearest point that landed in each pixel of this frame, for a row of tiles at a time, which
//        a core's own cache holds
//
//   reproject()  where POS lands; points that the checks of P3 4 distrust are left out      reproject_points.cpp
//   verify()     a row of tiles after the other, POS to AIP                                 reproject_splat.cpp
//                and AIP to hits; what fails, and what is due to be sampled anew, is left   reproject_verify.cpp
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
#include <memory>
#include <span>
#include <vector>

#include "engine/core/zero_pages.h"
#include "engine/farfield/pixel_mask.h"
#include "engine/farfield/ray_caster.h"
#include "engine/math/bounds.h"

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
    /// P3 5.3: where points landed all around a pixel that fails, its ray begins before the nearest of them. Off: as in
    /// P3's own tables it gains nothing, and what was not there a frame before may be passed over.
    bool shift_origin = false;

    friend bool operator==(const ReprojectSettings&, const ReprojectSettings&) = default;
};

/// How a pixel's answer came about (P3 Figure 6).
enum class PixelCause : std::uint8_t { verified, background, failed, resampled, abrupt };

/// Pixels by cause; they add up to the image.
struct ReprojectCounts {
    std::uint64_t verified = 0;    ///< seen by one intersection
    std::uint64_t background = 0;  ///< sky that was sky
    std::uint64_t failed = 0;      ///< to be cast: nothing landed here, it was not hit, or something has changed
    std::uint64_t resampled = 0;   ///< to be cast because it is due
    std::uint64_t abrupt = 0;      ///< to be cast because what landed here came too fast
    std::uint64_t primitives = 0;  ///< intersected, each once per tile
};

/// How the auxiliary image plane (AIP) is laid out: pixels row by row, with a border of empty ones, so that neighbours
/// need no test.
struct AuxiliaryLayout {
    static constexpr int kBorder = 16;  ///< columns; rows have a border of 1
    int stride = 0, rows = 0;           ///< in whole tiles, the border included

    AuxiliaryLayout() = default;
    AuxiliaryLayout(int width, int height)
        : stride((width + kTileSize - 1) / kTileSize * kTileSize + 2 * kBorder),
          rows((height + kTileSize - 1) / kTileSize * kTileSize + 2) {}
    [[nodiscard]] std::int32_t index(int x, int y) const { return (y + 1) * stride + x + kBorder; }
};

/// Where the points of the last frame land.
struct ReprojectedPoints {
    static constexpr std::int32_t kOutside = -1;         ///< left out
    static constexpr std::int32_t kAbruptBit = 1 << 30;  ///< comes too fast

    static constexpr int kBandRows = 16;
    /// Old rows [begin, end) that are walked together, all to one side of the epipole.
    struct Band {
        int begin = 0, end = 0;
        bool is_first = false;  ///< of its side
        bool downwards = true;
    };

    AuxiliaryLayout layout;
    ZeroPageVector<std::int32_t> target;                  ///< as the VisibilityBuffer: AuxiliaryLayout::index, kOutside
    std::vector<std::int32_t> first_target, last_target;  ///< per old row: least and greatest; first > last: none
    std::vector<Band> bands;                              ///< in the order of their walk
    /// Per band and column, the way along the walk that its first and its last point have come.
    ZeroPageVector<float> first_way, last_way;
    /// From the new eye, along its view axis, an old pixel's point of old depth d lies at
    /// (x * depth_per_x + y * depth_per_y + depth_constant) * d - depth_step.
    float depth_per_x = 0, depth_per_y = 0, depth_constant = 0, depth_step = 0;

    void resize(const VisibilityBuffer& like);
};

/// Which pixels are due to be cast in a frame (P3 Figure 5): disjoint for `period` frames in a row, all of the image in
/// so many frames.
[[nodiscard]] TileMask resample_mask(const ReprojectSettings& settings, int tile_x, int tile_y,
                                     std::uint64_t frame_number);

/// Reprojects frame after frame of one scene. Scratch is sized at the first frame of a size.
class Reprojection {
  public:
    explicit Reprojection(const scene::StaticScene& scene);
    ~Reprojection();

    /// What lies in the box has changed since the last frame: call it with the old and the new box of whatever changed.
    /// The next verify() leaves exactly those pixels to be cast, of the ones that it would answer otherwise, whose rays
    /// meet the box before or where they end; points in the box are not looked at.
    void invalidate(const DBox3& box);

    /// Finds where the last frame's points land in this frame.
    /// @param last_view  whose frame `last` holds; same size as `view`
    /// @param last       instances that are not the scene's own (moving ones) give no points
    /// @return false where nothing may be reprojected: the eye left the last view frustum
    bool reproject(const PinholeView& last_view, const VisibilityBuffer& last, const PinholeView& view,
                   const ReprojectSettings& settings);

    /// Intersects each pixel with what landed around it, after reproject() returned true.
    /// @param frame  in: `last`, or a copy; out: verified and background pixels of this frame, nothing of meaning
    ///               elsewhere. The two lie in different memory, which changes hands
    /// @param left   tiles of all other pixels, for cast_left_over() with the settings' shift_origin
    ReprojectCounts verify(const PinholeView& view, const ReprojectSettings& settings, std::uint64_t frame_number,
                           VisibilityBuffer& frame, std::vector<TileRequest>& left);

    /// Of the last verify(): pixels by cause.
    struct Causes {
        PixelMask verified, background, failed, resampled, abrupt;
        [[nodiscard]] PixelCause at(int x, int y) const;
    };
    [[nodiscard]] const Causes& causes() const { return causes_; }

  private:
    struct Scratch;

    scene::StaticScene scene_;
    ReprojectedPoints points_;
    VisibilityBuffer last_;
    Causes causes_;
    std::vector<DBox3> changed_;
    std::unique_ptr<Scratch> scratch_;
};

}  // namespace ff::farfield
