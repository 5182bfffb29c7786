#pragma once
// Which pixels of a frame are mirrors, and in which planes they lie: what the rays of reflections are planned from.

#include <cstdint>
#include <span>
#include <vector>

#include "engine/farfield/mirror_caster.h"
#include "engine/farfield/visibility_buffer.h"
#include "engine/math/camera.h"
#include "engine/scene/static_scene.h"

namespace ff::effects {

/// Whether what a pixel sees mirrors. Remembers the last answer, as neighbours see the same.
class MirrorTest {
  public:
    MirrorTest(const scene::StaticScene& scene, std::span<const scene::Instance> dynamic)
        : scene_(scene), dynamic_(dynamic) {}

    /// Names as the visibility buffer has them.
    bool operator()(std::uint32_t instance, std::uint32_t triangle);

  private:
    const scene::StaticScene& scene_;
    std::span<const scene::Instance> dynamic_;
    std::uint32_t instance_ = farfield::kSkyInstance, triangle_ = 0;
    const scene::Mesh* mesh_ = nullptr;
    bool has_mirrors_ = false, is_mirror_ = false;
};

/// What a frame's mirrors are found in.
struct MirrorInput {
    const scene::StaticScene& scene;
    std::span<const scene::Instance> dynamic;
    const PinholeView& view;
    const farfield::VisibilityBuffer& visibility;  ///< every pixel answered
    float within_m = 120.0f;                       ///< depth from which on mirrors but water show nothing
};

/// A plane with mirrors in it.
struct Mirror {
    farfield::MirrorPlane plane;
    std::uint32_t pixels = 0;  ///< of the reduced image, without those around that are asked for to filter
    std::uint32_t first_tile = 0, tile_count = 0;
};

/// Finds the mirrors of a view at a share of its size. What hardly mirrors, being looked at steeply, is no mirror. Of
/// many planes those that show in the most pixels count. The number of workers changes nothing; steady calls allocate
/// nothing.
class Mirrors {
  public:
    static constexpr std::size_t kMost = 16;  ///< planes

    /// For views up to this size.
    Mirrors(int width, int height);

    /// @param step  so many pixels of the view, along a side, are one
    /// @return pixels of the reduced image that have to be cast
    std::uint64_t find(const MirrorInput& input, int step);

    [[nodiscard]] std::span<const Mirror> found() const { return {planes_.data(), found_}; }
    /// The pixels of a mirror, by tiles of the reduced image.
    [[nodiscard]] std::span<const farfield::TileRequest> tiles(const Mirror& mirror) const {
        return {tiles_.data() + mirror.first_tile, mirror.tile_count};
    }

  private:
    void probe(const MirrorInput& input, int step);
    [[nodiscard]] std::uint8_t find_plane(const farfield::MirrorPlane& plane);
    void assign_planes(const MirrorInput& input, int step);
    void keep_largest();
    void widen();
    std::uint64_t collect_tiles();

    int width_ = 0, height_ = 0, stride_ = 0;         // of the reduced image
    std::vector<std::uint32_t> instance_, triangle_;  // seen by a mirror's pixel, else kSkyInstance
    std::vector<std::uint8_t> plane_, widened_;       // by pixel: index into planes_, kNone
    std::vector<Mirror> planes_;
    std::size_t found_ = 0;
    std::vector<farfield::TileRequest> tiles_;
};

}  // namespace ff::effects
