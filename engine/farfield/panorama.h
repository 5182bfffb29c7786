#pragma once
// The panoramic image cache (P0 5.1, 5.2; P1 4.4): what was cast and shaded once is used again while it still looks
// right from where the viewer stands now.
//
// The map is a cube of six faces around the viewer, so he may look up and down and tilt his head. Each texel holds a
// colour, what it shows (instance, triangle), how far that is, and the confidence record of the frame that cast it;
// the record knows where the viewer stood. From that follows a texel's error without any reference: its parallax in
// pixels, P0's "additional information about the distance to the intersection point" and P1 6.4's wish.
//
//   a frame:   begin_frame(position)
//              plan_fill(...)  -> texels to cast, per face   caster + shading write them, commit_fill(...)
//              lookup(...)     -> colours, and pixels left   caster + shading answer them, store(...)
//
// Filling casts whole tiles of the map at the texels' own centres: a face is a PinholeView like any other. The screen
// is then resampled from a regular grid, which is exact where a triangle is smooth and, at the few pixels whose texels
// disagree visibly, answered by a ray of the pixel's own. That is the way for a viewer who turns. Storing enters
// pixels that were cast for the screen at the texel their direction falls into, as P0 does; that leaves holes in a map
// finer than the screen but costs no rays of its own: the way for a viewer who walks.
//
// Threads: one caller; every function runs parallel inside, and the number of workers never changes a result.
// Steady frames allocate nothing: every buffer grows to its largest use once.

#include <array>
#include <cstdint>
#include <limits>
#include <memory>
#include <span>
#include <vector>

#include "engine/farfield/pixel_mask.h"
#include "engine/farfield/visibility_buffer.h"
#include "engine/math/bounds.h"
#include "engine/math/camera.h"
#include "engine/scene/static_scene.h"

namespace ff::farfield {

/// How good a texel still is.
enum class ConfidenceMeasure {
    parallax,  ///< pixels by which its content is off, predicted from the distance of what it shows
    distance,  ///< P0: metres that the viewer moved since
};

/// What happens at pixels whose 2 x 2 texels show different things in visibly different colours, or that have strong
/// contrast nearby.
enum class EdgeRule {
    blend,   ///< mixed like any other: soft silhouettes, no rays
    cast,    ///< a ray of the pixel's own, budget permitting
    verify,  ///< cast, but where the four show just two things these are left for verify_edges
};

struct PanoramaSettings {
    /// Texels a side of a face, a multiple of 16 in [64, 2048]; 18 bytes a texel, six faces. Powers of two put all rows
    /// of a tile into the same few sets of the first-level cache.
    int face_size = 1040;
    double record_distance_m = 1e-3;  ///< moves shorter than this go on with the same confidence record
    int edge_contrast = 24;           ///< of 255: difference between neighbours below which blending is not seen
    /// Of 255: where the 4 x 4 texels around differ by more, the pixel is cast whatever its own four show. What falls
    /// between texels, a hole in foliage, is seldom alone, and a missed one would be as bright.
    int strong_contrast = 128;
    int few_pixels = 48;  ///< EdgeRule::verify: a pixel tile with no more pixels to cast, and those edges, casts none
};

struct PanoramaLimits {
    ConfidenceMeasure measure = ConfidenceMeasure::parallax;
    float max_parallax_px = 0.7f;  ///< a texel above it is cast again; for ConfidenceMeasure::parallax
    float max_distance_m = 0.05f;  ///< likewise for ConfidenceMeasure::distance
    EdgeRule edges = EdgeRule::cast;
    std::uint64_t ray_budget = std::numeric_limits<std::uint64_t>::max();  ///< pixels (texels) to cast at most
};

/// What one lookup did. Exact and repeatable. reused + stale + cast + unanswered = wanted.
struct PanoramaStats {
    std::uint64_t wanted = 0;
    std::uint64_t reused = 0;      ///< from texels within the limit
    std::uint64_t stale = 0;       ///< from texels beyond it, for want of budget
    std::uint64_t cast = 0;        ///< to be cast by the caller: never seen, beyond the limit, or an edge
    std::uint64_t edges = 0;       ///< of those, the edges
    std::uint64_t unanswered = 0;  ///< never seen and no budget: left as they were
    float parallax_p99_px = 0;     ///< over reused and stale pixels; the upper end of a bin 12% wide
    float parallax_max_px = 0;
};

/// Whose instance and triangle a lookup writes.
enum class PanoramaNames {
    all,
    marked,  ///< of pixels that look at marked texels and of all in PanoramaTarget::whole, with their depths
    none,
};

/// Where a panorama's pixels go. All arrays are laid out as the VisibilityBuffer is.
struct PanoramaTarget {
    VisibilityBuffer* visibility = nullptr;  ///< optional: colours alone take half of the time
    std::uint32_t* colors = nullptr;         ///< RGBA8, as shading::Image::pixels
    int color_stride = 0;                    ///< pixels a row, whole tiles
    bool depths = true;                      ///< of all reused pixels
    PanoramaNames names = PanoramaNames::all;
    std::span<const std::uint8_t> whole = {};  ///< optional, by tile of the view: not 0 where all names are wanted
    PixelMask* named = nullptr;  ///< optional, of the view's size: set to the pixels whose names were written
};

class Panorama {
  public:
    explicit Panorama(const PanoramaSettings& settings = {});
    ~Panorama();
    Panorama(const Panorama&) = delete;
    Panorama& operator=(const Panorama&) = delete;

    /// A face size that gives texels of about 0.8 pixels at the image centre, [64, 2048].
    /// @param density  so many times as many texels a side, > 0
    [[nodiscard]] static int face_size_for(const PinholeView& view, float density = 1.0f);
    /// Whether such a map would show in a view: its texels are more than one and a half times as wide as face_size_for
    /// means them to be, as through a spyglass, or on a screen of more pixels than the largest map has.
    [[nodiscard]] static bool is_too_coarse(int face_size, const PinholeView& view, float density = 1.0f);

    /// Starts a frame: makes a new confidence record once the viewer has moved more than record_distance_m.
    void begin_frame(const WorldPos& position);
    /// Forgets everything.
    void clear();
    /// Takes all of the map's memory at once, some 20 bytes a texel: otherwise frames take it bit by bit as they fill
    /// the map, and stutter.
    void populate();

    /// Chooses the texels to cast so that lookup() of the same pixels finds them all: never seen first, then the
    /// worst tiles, every n-th among equals.
    /// @param wanted  the pixels that nothing else answers, by tiles of the view; none beyond its width and height
    /// @return texels chosen, at most limits.ray_budget
    std::uint64_t plan_fill(const PinholeView& view, std::span<const TileRequest> wanted, const PanoramaLimits& limits);
    /// Whether the last plan_fill() left nothing out for want of budget.
    [[nodiscard]] bool is_fill_complete() const;
    /// Chooses the next of the known texels instead, whole tiles from the `next`-th of the map on, to be cast and
    /// shaded anew by the same steps: what they show is right, but their light is not any more.
    /// @param texels  at most so many
    /// @param next    0 for a new round; moves on
    /// @return whether the round is complete
    bool plan_refresh(std::uint64_t texels, std::uint32_t& next);
    /// The texels of one face (0..5) that plan_fill chose; for face_view() and map().
    [[nodiscard]] std::span<const TileRequest> fill_requests(int face) const;
    /// All six faces lie below each other in one buffer of face_size x 6 face_size texels; this view's pixels are the
    /// rows from face * face_size on. It stands where the current confidence record does.
    [[nodiscard]] PinholeView face_view(int face) const;
    /// Casters write the requested texels here.
    [[nodiscard]] VisibilityBuffer& map();
    /// Enters the texels that were cast into map() and shaded.
    /// @param colors  face_size x 6 face_size texels, `stride` a row
    /// @param marks   optional: per request of the face, which texels of its tile are marked (PanoramaNames); else all
    void commit_fill(int face, std::span<const std::uint32_t> colors, int stride, std::span<const TileMask> marks = {});

    /// Answers the wanted pixels from the map as far as it can.
    /// @param wanted   as for plan_fill
    /// @param to_cast  replaced by the pixels that the caller has to cast, never more than limits.ray_budget; where
    ///                 there is an old value the target holds it already
    PanoramaStats lookup(const PinholeView& view, std::span<const TileRequest> wanted, const PanoramaLimits& limits,
                         const PanoramaTarget& target, std::vector<TileRequest>& to_cast);

    /// Settles the edges that the last lookup left aside (EdgeRule::verify): what the four texels around such a pixel
    /// show is intersected by the pixel's own ray, and the nearest goes to `out`. Its colour is that of the texels that
    /// show the same triangle, which were shaded less than a texel away. Pixels that none of the triangles covers look
    /// past all of them: they get the colour of the farthest texel.
    /// @param view, target  as for the lookup
    /// @param left          set where `out` was written but no texel around shows that triangle: to be shaded
    void verify_edges(const scene::StaticScene& scene, const PinholeView& view, const PanoramaTarget& target,
                      VisibilityBuffer& out, PixelMask& left);

    /// Gives pixels that the last lookup left to others the colour of the texels around that show what their rays met,
    /// as verify_edges() does.
    /// @param visibility, colors  of those pixels
    /// @param asked               their mask; those that get a colour are taken out
    void known_colors(const VisibilityBuffer& visibility, std::uint32_t* colors, int color_stride, PixelMask& asked);

    /// Enters pixels that were cast and shaded for the screen.
    /// @param lit  optional: which of them see the sun, as visibility; then light() is kept, too
    void store(const PinholeView& view, std::span<const TileRequest> tiles, const VisibilityBuffer& visibility,
               std::span<const std::uint32_t> colors, int color_stride, const std::uint8_t* lit = nullptr);

    /// Which texels see the sun, 255 or 0, laid out as map(): who fills the map writes it, known_light() reads it.
    /// Made, and its memory taken, by the first call.
    [[nodiscard]] std::uint8_t* light();
    /// What the texels know of the light of the pixels that the last lookup left to others: a pixel whose own ray met
    /// what a good texel beside it shows sees the same place, less than a texel away, in the same light. Texels that
    /// disagree, as on the border of a shadow, know nothing.
    /// @param visibility  of those pixels
    /// @param lit         as visibility; 255 or 0 where it is known, else left
    /// @param tiles       the pixels that ask; replaced by those that are left
    /// @return pixels answered
    std::uint64_t known_light(const VisibilityBuffer& visibility, std::uint8_t* lit, std::vector<TileRequest>& tiles);

    /// Forgets the texels whose ray meets the box before or where it ends: call it with the old and the new box of
    /// whatever changed.
    /// @param marked  all marked texels, too: mirrors may show the box wherever it is
    /// @return texels forgotten
    std::uint64_t invalidate(const DBox3& box, bool marked = false);

    /// Frames since the texel in a direction was cast; -1: never. For the debug view.
    [[nodiscard]] std::int64_t age(const Vec3& direction) const;
    [[nodiscard]] std::uint64_t memory_bytes() const;
    [[nodiscard]] const PanoramaSettings& settings() const;

  private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace ff::farfield
