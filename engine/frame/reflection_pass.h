#pragma once
// What mirrors show: water and glass, by few rays (P0 section 9.4).

#include <cstdint>
#include <memory>

#include "engine/core/zero_pages.h"
#include "engine/effects/mirrors.h"
#include "engine/farfield/mirror_caster.h"
#include "engine/frame/dynamic_overlay.h"
#include "engine/frame/plan.h"
#include "engine/frame/stats.h"
#include "engine/shading/reflections.h"

namespace ff::frame {

struct FrameHistory;
struct Tools;

/// What reflections need, made when a plan first asks for them.
struct ReflectionWork {
    static constexpr int kFirstStep = 2;

    /// For frames of one size.
    ReflectionWork(const scene::StaticScene& scene, int width, int height);
    [[nodiscard]] bool fits(int width, int height) const { return width == width_ && height == height_; }

    effects::Mirrors mirrors;
    farfield::MirrorCaster caster;
    std::vector<farfield::MirrorRequest> requests;  ///< of this frame
    DynamicOverlay moving;
    farfield::VisibilityBuffer visibility;  ///< of the mirrored views, all of them in one
    farfield::PixelMask covered;            ///< scratch: by what moves
    ZeroPageVector<std::uint8_t> sun_seen;
    shading::Image image;
    shading::Reflections shown{.image = image, .depth = nullptr};
    int step = kFirstStep;  ///< of the next frame

  private:
    int width_, height_;
};

/// Finds what the mirrors of a frame show of the world.
/// @param visibility  of plan.view, every pixel answered
/// @return for ShadeSettings::reflections, good until the next call; nullptr where the plan has no reflections
const shading::Reflections* find_reflections(const FramePlan& plan, const Tools& tools, FrameHistory& history,
                                             FrameStats& stats);

}  // namespace ff::frame
