#pragma once
// Which pixels of a frame are mirrors, and in which planes they lie: what the rays of reflections are planned from.

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "engine/farfield/mirror_caster.h"
#include "engine/farfield/visibility_buffer.h"
#include "engine/math/camera.h"
#include "engine/scene/static_scene.h"

namespace ff::effects {

/// How a surface mirrors.
enum class MirrorKind : std::uint8_t {
    none,
    water,  ///< as far as one sees, and never at rest where it has waves
    glass,  ///< fades with distance; metal, too
};

/// Of scene::MaterialFlags.
using MirrorFlags = std::uint32_t;

/// How what a pixel sees mirrors. Remembers the last answer, as neighbours see the same.
class MirrorTest {
  public:
    MirrorTest(const scene::StaticScene& scene, std::span<const scene::Instance> dynamic)
        : scene_(scene), dynamic_(dynamic) {}

    /// Names as the visibility buffer has them.
    MirrorKind operator()(std::uint32_t instance, std::uint32_t triangle);
    /// What of scene::kMaterialWater and scene::kMaterialMirror any triangle of the instance has.
    MirrorFlags flags_of(std::uint32_t instance);
    /// Whether a row of a tile sees nothing but the sky and one instance that is known to have no mirrors: mostly so,
    /// and quickly asked. False does not say that there are any.
    /// @param instance  [kTileSize]
    bool is_plain_row(const std::uint32_t* instance);
    /// Which pixels of a row of a tile are mirrors, by bits.
    /// @param instance, triangle  [kTileSize]
    std::uint16_t mirrors_of_row(const std::uint32_t* instance, const std::uint32_t* triangle);

  private:
    const scene::StaticScene& scene_;
    std::span<const scene::Instance> dynamic_;
    std::uint32_t instance_ = farfield::kSkyInstance, triangle_ = 0;
    const scene::Mesh* mesh_ = nullptr;
    MirrorFlags flags_ = 0;
    std::uint32_t plain_ = farfield::kSkyInstance;  ///< without mirrors
    MirrorKind kind_ = MirrorKind::none;
};

/// The plane of a triangle, as seen by an eye; nullopt where that is in it, or where the triangle has no area.
[[nodiscard]] std::optional<farfield::MirrorPlane> mirror_plane(const scene::StaticScene& scene,
                                                                const scene::Instance& instance, std::uint32_t triangle,
                                                                const WorldPos& eye);

/// What mirrors are found in.
struct MirrorInput {
    const scene::StaticScene& scene;
    std::span<const scene::Instance> dynamic;
    const PinholeView& view;
    const farfield::VisibilityBuffer& visibility;
    int left = 0, top = 0;  ///< pixel of the visibility buffer that is the view's first; multiples of kTileSize
    /// The pixels that ask, by tiles of the visibility buffer, none twice; all of them in the view and answered.
    std::span<const farfield::TileRequest> tiles;
    float within_m = 120.0f;      ///< depth from which on mirrors but water show nothing
    float water_beyond_m = 0.0f;  ///< depth up to which water does not ask
};

/// A plane with mirrors in it.
struct Mirror {
    farfield::MirrorPlane plane;
    std::uint32_t pixels = 0;  ///< of the reduced image, without those around that are asked for to filter
};

/// Finds the mirrors of a view at a share of its size. What hardly mirrors, being looked at steeply, is no mirror. Of
/// many planes those that show in the most pixels count. The number of workers changes nothing; steady calls allocate
/// nothing.
class Mirrors {
  public:
    static constexpr std::size_t kMost = 16;  ///< planes

    /// For views up to this size, of which at least so many pixels along a side are one.
    Mirrors(int width, int height, int least_step);

    /// @param step  so many pixels of the view, along a side, are one: 1, 2, 4 or 8
    /// @return pixels of the reduced image that have to be cast
    std::uint64_t find(const MirrorInput& input, int step);

    [[nodiscard]] std::span<const Mirror> found() const { return {planes_.data(), found_}; }
    /// The pixels of one of them, and those beside it that filtering looks at, by tiles of the reduced image.
    [[nodiscard]] std::span<const farfield::TileRequest> tiles(std::size_t mirror) const { return tiles_[mirror]; }
    /// All tiles of the reduced image that who shades the pixels may look at, mirrors or not: x and y alone.
    [[nodiscard]] std::span<const farfield::TileRequest> looked_at() const { return looked_at_; }

  private:
    void find_asked(const MirrorInput& input, int step);
    void probe(const MirrorInput& input, int step);
    bool probe_tile(const MirrorInput& input, int step, std::uint32_t tile, MirrorTest& kind_of);
    void list_tiles();
    [[nodiscard]] std::uint8_t find_plane(const farfield::MirrorPlane& plane);
    void assign_planes(const MirrorInput& input, int step);
    void keep_largest();
    [[nodiscard]] std::uint64_t row_around(int tile_x, int y) const;
    void widen();
    std::uint64_t collect_tiles();
    template <class Visit>
    void visit_pixels(std::uint32_t tile, Visit&& visit) const;

    int width_ = 0, height_ = 0, stride_ = 0;  // of the reduced image
    int tiles_x_ = 0, tiles_y_ = 0;
    std::vector<std::uint32_t> instance_, triangle_;  // seen by a mirror's pixel, else kSkyInstance; in mirror_tiles_
    std::vector<std::uint8_t> plane_, widened_;       // by pixel: index into planes_, kNone; in wide_tiles_
    std::vector<std::uint16_t> rows_;                 // by row of a tile: pixels whose plane counts
    int asked_x_ = 0;                                 // tiles of the view in a row
    std::vector<std::uint32_t> asked_;                // by tile of the view: its place among the input's + 1, or 0
    // Most tiles have no mirror: all steps but the first look at those alone that have, and at the tiles around them.
    std::vector<std::uint8_t> is_asked_, has_mirrors_;  // by tile
    std::vector<farfield::TileRequest> looked_at_;
    std::vector<std::uint32_t> mirror_tiles_, wide_tiles_;
    std::vector<Mirror> planes_;
    std::size_t found_ = 0;
    std::array<std::vector<farfield::TileRequest>, kMost> tiles_;
};

}  // namespace ff::effects
