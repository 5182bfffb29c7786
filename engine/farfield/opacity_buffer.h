#pragma once
// The opacity buffer: one bit per pixel, set where the near field covers it, so that nothing beyond need be asked
// there.
//
// Based on: Wimmer, Giegl, Schmalstieg, "Fast Walkthroughs with Image Caches and Ray Casting", VE'99, sections 4.1 and
// 7: a software renderer without shading and depth. Tiles of row masks and the test of boxes against them follow
// Hasselgren, Andersson, Akenine-Moller, "Masked Software Occlusion Culling", HPG 2016; ours needs no depth, as it
// only asks whether a pixel is covered; who draws cells that reach beyond the near distance must cut off what lies
// there.
//
// A set bit is a promise: the near raster covers the pixel. A missing bit only costs a ray. So triangles are drawn a
// little too small (see OpacitySettings::inset_px), and what is masked or blended is not drawn at all.

#include <cstdint>
#include <span>
#include <vector>

#include "engine/farfield/pixel_mask.h"
#include "engine/math/camera.h"
#include "engine/scene/static_scene.h"

namespace ff::farfield {

struct OpacitySettings {
    /// The near raster's near plane; nothing nearer is drawn. Metres along the view axis, > 0.
    float near_plane_m = 0.1f;
    /// How far inside a triangle a pixel centre must lie to count, pixels. OpenGL snaps vertices to 1/256 pixel; the
    /// rounding of large coordinates close to the eye is added to it. [1/512, 0.5]
    float inset_px = 1.0f / 128.0f;
};

/// Work done; exact and repeatable.
struct OpacityCost {
    std::uint32_t instances = 0;  ///< not rejected as a whole
    std::uint32_t nodes = 0;      ///< BVH nodes whose children were tested
    std::uint32_t leaves = 0;     ///< transformed
    std::uint32_t triangles = 0;  ///< set up
    std::uint32_t drawn = 0;      ///< of those, with a pixel centre inside their bounds
};

/// Draws opacity buffers in software. Keeps its scratch, so a steady frame allocates nothing.
/// Threads: one at a time; uses one core.
class OpacityRaster {
  public:
    explicit OpacityRaster(const OpacitySettings& settings = {}) : settings_(settings) {}

    /// Sets in `covered` (resized to the view) the pixels whose centre lies inside an opaque triangle of the instances.
    /// @param instance_ids  any order; drawn front to back. Ids from scene.instances.size() on name `dynamic` ones.
    OpacityCost draw(const scene::StaticScene& scene, std::span<const scene::Instance> dynamic,
                     std::span<const std::uint32_t> instance_ids, const PinholeView& view, PixelMask& covered);

  private:
    struct Entry {
        double distance = 0.0;
        std::uint32_t id = 0;
    };
    OpacitySettings settings_;
    std::vector<Entry> order_;
    std::vector<std::uint8_t> full_;  ///< per tile: every pixel is covered
};

/// What the near raster's depth buffer holds where nothing was drawn.
enum class EmptyDepth {
    infinite,  ///< distances; +inf is empty, as in VisibilityBuffer
    zero,      ///< reversed-Z as read back from OpenGL; 0 is empty
};

/// Sets the bit of every pixel with a depth.
/// @param depth      first pixel of the TOP row
/// @param row_step   floats from one row to the one below; negative for an image read back bottom row first
void opacity_from_depth(const float* depth, std::ptrdiff_t row_step, int width, int height, EmptyDepth empty,
                        PixelMask& covered);

/// Lists the pixels that neither mask has, tile by tile. Both masks must have the same size; `sky` may be null.
/// @return pixels listed.
std::uint64_t list_uncovered(const PixelMask& covered, const PixelMask* sky, std::vector<TileRequest>& out);

/// The plain way, kept to test the fast one against: every triangle, in double, clipped at the near plane, every pixel
/// centre against its edges; a centre exactly on an edge counts.
void draw_opacity_reference(const scene::StaticScene& scene, std::span<const scene::Instance> dynamic,
                            std::span<const std::uint32_t> instance_ids, const PinholeView& view, double near_plane_m,
                            PixelMask& covered);

}  // namespace ff::farfield
