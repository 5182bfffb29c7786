#pragma once
// Horizon tracing: per azimuth the elevation above which there is only sky, so that sky pixels never reach a ray
// caster.
//
// Based on: Wimmer, Giegl, Schmalstieg, "Fast Walkthroughs with Image Caches and Ray Casting", VE'99, section 6, and
// Wimmer, PhD thesis 2001, section 4.5. Ours differs: azimuth columns are wedges instead of rays, so that a spire
// thinner than a column is never lost; all columns are found in one traversal of the max-mipmapped height grid instead
// of a walk each; and the map is kept in world azimuths, so that it serves any pitch and roll and outlives turns of the
// head.
//
//   eye o----------------------------- elevation tangent of a square in a column: its height above the eye over
//        \ column c   +---+            the smallest distance of any of its points inside the wedge (the largest
//         \  wedge    | h |            one, where it lies below the eye). The column keeps the maximum.
//          \          +---+

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "engine/farfield/pixel_mask.h"
#include "engine/math/camera.h"
#include "engine/scene/static_scene.h"

namespace ff::farfield {

struct HorizonSettings {
    /// Azimuths of the whole circle, a multiple of 4 in [64, 8192]. Squares beyond a fifth as many squares from the eye
    /// are taken two by two: they are then hardly wider than a column.
    int columns = 1280;
    /// Everything static that is horizontally nearer than this is somebody else's (the near field draws it), and the
    /// horizon is that of the rest. Metres; 0: the horizon of everything.
    float near_distance_m = 0.0f;
    /// 2 or 4: trace only every 2nd or 4th azimuth, in wedges so much wider, and stop one or two levels above the
    /// finest squares. Still never below the true skyline; for frames short of time.
    int subsample = 1;

    /// Within so many grid squares of the eye the scene's own boxes count instead of the squares' heights (where a
    /// scene is given): a square that holds a house would hide the sky of the whole street. 0: never. [0, 16]
    int fine_squares = 3;

    /// Where the eye moves, the skyline is traced for all places around those that it will cross in so many frames if
    /// it goes on as it does, a little too high for each, and then serves them all. 0: for its place alone. [0, 64]
    int frames_ahead = 0;

    friend bool operator==(const HorizonSettings&, const HorizonSettings&) = default;
};

/// Work done; exact and repeatable.
struct HorizonCost {
    std::uint32_t columns = 0;  ///< traced anew
    std::uint32_t squares = 0;  ///< height grid squares of any level whose bound was computed
    std::uint32_t boxes = 0;    ///< boxes and triangles of the scene, likewise
};

/// An interval of azimuth columns, wrapping around; count may be all of them.
struct ColumnRange {
    int first = 0;
    int count = 0;
};

struct HorizonWedges;

/// The skyline around one eye position. Dynamic objects are not in it.
class HorizonMap {
  public:
    /// Sizes the tables; the only place that allocates. FF_CHECKs the ranges of HorizonSettings.
    explicit HorizonMap(const HorizonSettings& settings = {});

    /// Makes the columns that `view` looks at (and a margin) valid for its position, tracing those that are not:
    /// none while only the direction changes within what was traced, all of the view's once the eye moved (or left the
    /// places of HorizonSettings::frames_ahead). By two workers where there are many; their number changes nothing.
    HorizonCost update(const scene::StaticScene& scene, const PinholeView& view);
    /// Makes the given columns valid for an eye.
    HorizonCost update(const scene::StaticScene& scene, const WorldPos& eye, ColumnRange wanted);
    /// The same from a height grid alone.
    HorizonCost update(const scene::HeightGrid& grid, const PinholeView& view);
    HorizonCost update(const scene::HeightGrid& grid, const WorldPos& eye, ColumnRange wanted);
    /// Forgets what was traced: the world changed.
    void invalidate();
    /// Changes knobs between frames; the number of columns stays. Forgets what was traced when anything differs.
    void set_quality(float near_distance_m, int subsample);

    /// Tangent of the skyline's elevation per column; +inf where anything up to straight up may be hit or where the
    /// column was not traced, -inf where there is nothing at all.
    [[nodiscard]] std::span<const float> tangents() const { return {tangents_.data(), std::size_t(settings_.columns)}; }
    [[nodiscard]] const HorizonSettings& settings() const { return settings_; }

  private:
    [[nodiscard]] HorizonWedges wedges(float near_distance) const;
    [[nodiscard]] ColumnRange with_margin(const scene::StaticScene* scene, const scene::HeightGrid& grid,
                                          const PinholeView& view) const;
    [[nodiscard]] bool is_of(const scene::StaticScene* scene, const scene::HeightGrid& grid) const;
    HorizonCost trace(const scene::StaticScene* scene, const scene::HeightGrid& grid, const WorldPos& eye,
                      ColumnRange wanted);
    [[nodiscard]] bool holds_for(const WorldPos& eye) const;
    void move_to(const WorldPos& eye);
    void make_wedges();
    /// Raises traced_ by what `raise_by(tangents, winner, cost)` adds to them, half of the columns on each of two
    /// workers.
    template <class RaiseBy>
    void raise_halves(RaiseBy&& raise_by, HorizonCost& cost);

    HorizonSettings settings_;
    WorldPos eye_{0.0};                      ///< of the last update
    WorldPos middle_{0.0};                   ///< of the places that the skyline holds for
    double roam_m_ = 0.0;                    ///< their greatest horizontal distance from it; 0: it alone
    double climb_m_ = 0.0;                   ///< and their greatest vertical one
    const float* heights_ = nullptr;         ///< of the grid that was traced; null: nothing was
    const scene::BvhNode* boxes_ = nullptr;  ///< of the scene that was traced; null: the grid alone
    ColumnRange valid_;

    // Per traced column (settings.columns / subsample of them), padded: bounds of |x| and |z| of the unit directions in
    // the wedge, a little too wide.
    std::vector<float> max_x_, max_z_, min_x_, min_z_;
    std::vector<float> traced_;               ///< tangents of the traced columns
    std::vector<float> tangents_;             ///< one per column, padded
    std::vector<std::uint32_t> winner_;       ///< level-0 (or finest traced) square that made the traced column
    std::vector<float> border_x_, border_z_;  ///< [columns + 1]: unit directions between the traced columns

    /// Scratch of a worker.
    struct Half {
        std::vector<float> traced;
        std::vector<std::uint32_t> winner;
        HorizonCost cost;
    };
    std::array<Half, 2> halves_;
};

/// Columns that the view's pixels fall in, and a margin of two to each side.
[[nodiscard]] ColumnRange columns_of_view(const PinholeView& view, int columns);

/// Sets in `sky` (resized to the view) the bit of every pixel whose ray certainly meets nothing static: its elevation
/// is above the skyline of its column. The map was last updated for the view's position.
/// @return pixels found to be sky.
std::uint64_t find_sky_pixels(const PinholeView& view, const HorizonMap& map, PixelMask& sky);

/// The plain way, kept to test the fast one against: every square of level 0, in double.
/// @param tangents  [columns], written
void trace_horizon_reference(const scene::HeightGrid& grid, const WorldPos& eye, float near_distance_m,
                             std::span<double> tangents);

}  // namespace ff::farfield
