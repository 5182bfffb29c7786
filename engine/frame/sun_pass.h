#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "engine/core/zero_pages.h"
#include "engine/farfield/panorama.h"
#include "engine/farfield/sun_history.h"
#include "engine/farfield/sun_rays.h"
#include "engine/frame/plan.h"
#include "engine/frame/stats.h"

namespace ff::frame {

/// What sun shadows need, made when a plan first asks for them.
struct SunLight {
    explicit SunLight(const scene::StaticScene& scene) : rays(scene) {}

    farfield::SunRays rays;
    farfield::SunHistory history;
    int pause_frames = 0;                        ///< frames for which reuse is not worth its time
    ZeroPageVector<std::uint8_t> seen;           ///< as VisibilityBuffer::index: 255 a pixel sees the sun, 0 not
    std::vector<farfield::TileRequest> cast;     ///< scratch: what reuse leaves
    std::vector<farfield::TileRequest> shaded;   ///< scratch: where shadows of what moves may fall
    std::vector<farfield::MovingSphere> moving;  ///< scratch: what moves, this frame
    farfield::MovingShadows shadows;             ///< scratch: of that
};

/// Balls round instances that move.
void bound_moving(std::span<const scene::Instance> dynamic, std::vector<farfield::MovingSphere>& out);

/// Finds which pixels see the sun: from what is known where the plan reuses that, else by a ray each.
/// @param tiles     the pixels that are going to be shaded
/// @param panorama  where it was looked up for this frame: its texels are asked; else the last frame is
/// @return for ShadeSettings::sun_seen, good until the next call; nullptr where the plan has no sun shadows
const std::uint8_t* find_sun(const FramePlan& plan, const scene::StaticScene& scene,
                             const farfield::VisibilityBuffer& visibility, std::span<const farfield::TileRequest> tiles,
                             farfield::Panorama* panorama, std::unique_ptr<SunLight>& sun, FrameStats& stats);

/// Likewise for texels of the panorama, which nothing that moves shades and nothing is known of.
/// @param view  of the face that they lie on
const std::uint8_t* find_sun_of_panorama(const FramePlan& plan, const scene::StaticScene& scene,
                                         const PinholeView& view, std::span<const farfield::TileRequest> texels,
                                         farfield::Panorama& panorama, std::unique_ptr<SunLight>& sun,
                                         FrameStats& stats);

/// Makes ready for the sun rays of what is no pixel of the frame: transparent layers, what mirrors show. nullptr where
/// the plan has no sun shadows.
/// @param dynamic  what moves and casts shadows; has to outlive the casts
const farfield::SunRays* begin_sun_rays(const FramePlan& plan, const scene::StaticScene& scene,
                                        std::span<const scene::Instance> dynamic, std::unique_ptr<SunLight>& sun);

/// Counts rays that were cast by those, too.
void count_sun_rays(std::uint64_t rays, FrameStats& stats);

}  // namespace ff::frame
