#pragma once
// What mirrors show: water and glass, by few rays (P0 section 9.4).

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "engine/core/zero_pages.h"
#include "engine/effects/mirrors.h"
#include "engine/farfield/mirror_caster.h"
#include "engine/frame/dynamic_overlay.h"
#include "engine/frame/plan.h"
#include "engine/frame/stats.h"
#include "engine/frame/view_lights.h"
#include "engine/shading/reflections.h"

namespace ff::frame {

struct FrameHistory;
struct Tools;

/// What reflections need, made when a plan first asks for them.
struct ReflectionWork {
    static constexpr int kFirstStep = 2;

    /// For views of one size, of which at least so many pixels along a side share a ray.
    ReflectionWork(const scene::StaticScene& scene, int width, int height, int least_step);
    [[nodiscard]] bool fits(int width, int height) const { return width == width_ && height == height_; }

    /// How what a mirror shows is shaded.
    struct Look {
        ViewLights lights;
        shading::ShadeSettings settings;
    };

    effects::Mirrors mirrors;
    farfield::MirrorCaster caster;
    std::vector<farfield::MirrorRequest> requests;  ///< of this frame
    DynamicOverlay moving;
    farfield::VisibilityBuffer visibility;  ///< of the mirrored views, all of them in one
    farfield::PixelMask covered;            ///< scratch: by what moves
    ZeroPageVector<std::uint8_t> sun_seen;
    std::vector<Look> looks;  ///< by mirror
    shading::Image image;
    shading::Reflections shown{.image = image, .depth = nullptr};
    int step = kFirstStep;  ///< of the next frame

  private:
    int width_, height_;
};

/// Finds what the mirrors of a frame show of the world.
/// @param tiles  the pixels of plan.view that are going to be shaded, answered in history.visibility
/// @return for ShadeSettings::reflections, good until the next call; nullptr where the plan has no reflections
const shading::Reflections* find_reflections(const FramePlan& plan, const Tools& tools,
                                             std::span<const farfield::TileRequest> tiles, FrameHistory& history,
                                             FrameStats& stats);

/// Likewise what glass and metal show of all that stands still, for texels that the panorama fills: who rests sees the
/// same in them as long as it stays filled. A texel's parallax bounds theirs, for what is mirrored is farther away.
/// Water is left out, for it is never at rest.
/// @param view    of the face that the texels lie on
const shading::Reflections* find_reflections_of_panorama(const FramePlan& plan, const Tools& tools,
                                                         const PinholeView& view,
                                                         std::span<const farfield::TileRequest> texels,
                                                         FrameHistory& history, FrameStats& stats);

}  // namespace ff::frame
