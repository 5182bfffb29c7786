#pragma once
// Everything that a frame will do, decided before anything is drawn: plain data that can be printed, compared and
// replayed.

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "engine/budget/governor.h"
#include "engine/effects/falling.h"
#include "engine/effects/registry.h"
#include "engine/frame/settings.h"
#include "engine/math/camera.h"
#include "engine/scene/static_scene.h"

namespace ff::frame {

struct FrameHistory;

struct FramePlan {
    Mode mode = Mode::hybrid;
    PinholeView view;  ///< what is drawn; smaller than the image where time is short
    int image_width = 0, image_height = 0;
    std::span<const scene::Instance> dynamic;  ///< instances that move, ids from the scene's instance count on
    scene::Environment environment;            ///< light and air of this frame
    effects::Decisions effects;

    // Near field
    bool rasterise = false;  ///< is there a near field this frame, or all of it in mode raster
    double near_m = 0.0;     ///< cells nearer than this are rasterised; +inf: all
    bool software_opacity = false;

    // Far field
    bool trace_horizon = false;
    int horizon_subsample = 1;
    bool look_up_panorama = false;
    bool store_panorama = false;  ///< enter what is cast, so that later frames may reuse it
    /// Cast whole tiles of the panorama ahead of the view: the viewer only turns or rests, or this is the first frame.
    bool fill_panorama = false;
    bool primitives_are_known = false;  ///< one intersection a pixel, nothing is searched in time that counts
    bool may_reproject = false;         ///< the last frame knows every pixel's primitive
    farfield::ReprojectSettings reproject;
    CasterKind caster = CasterKind::beam;
    float grid_cells_per_item = float(farfield::kUsualGridCellsPerItem);
    std::uint64_t ray_budget = UINT64_MAX;
    std::uint64_t fill_budget = UINT64_MAX;  ///< texels that may be filled
    float max_parallax_px = 0.5f;
    float panorama_density = 1.0f;
    farfield::EdgeRule panorama_edges = farfield::EdgeRule::verify;
    bool keep_ids = false;
    float prelit_beyond_m = 0.0f;
    float lamps_within_m = 0.0f;
    float air_error = 0.0f;
    float water_within_m = 0.0f;  ///< nearer water has waves, and never rests
    std::uint64_t reflection_rays = 0;
    float reflections_within_m = 0.0f;
    double sun_elevation_deg = 0.0;
    effects::Fall fall;  ///< what falls; nothing where its weather is none
    bool sun_shadows = false;
    bool reuse_sun = false;  ///< of pixels that see the same points as in the last frame
    int sun_refresh_frames = 32;
    double predicted_ms = 0.0;
};

/// Decides a frame. Reads the history, changes only its governor; touches no GL and draws nothing.
/// @param facts    of the scene
/// @param dynamic  instances that move, borrowed until the frame is drawn
void plan_frame(const scene::StaticScene& scene, const effects::SceneFacts& facts,
                std::span<const scene::Instance> dynamic, const Camera& camera, int width, int height,
                const FrameSettings& settings, FrameHistory& history, FramePlan& plan);

/// The plan as text, a line a decision.
[[nodiscard]] std::string to_text(const FramePlan& plan);

}  // namespace ff::frame
