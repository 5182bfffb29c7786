#pragma once

#include <cstdint>
#include <limits>
#include <optional>

#include "engine/budget/governor.h"
#include "engine/effects/effect.h"
#include "engine/farfield/panorama.h"
#include "engine/farfield/ray_caster.h"
#include "engine/farfield/reproject.h"
#include "engine/math/types.h"
#include "engine/scene/environment.h"

namespace ff::frame {

/// How whole frames are drawn; the tool's --mode.
enum class Mode {
    hybrid,     ///< this engine: near field, horizon, panorama, casts
    raster,     ///< everything through OpenGL, frustum culled
    raycast,    ///< every pixel through Embree
    near,       ///< OpenGL with the far plane at the near distance
    beam,       ///< every pixel below the horizon by tile beams
    reproject,  ///< P3: the last frame's hits verified by one intersection, the rest cast
    irsa,       ///< P3 7.3: each pixel's primitive is known beforehand, by a cast that no time counts; the bound of all
    beam_reuse,  ///< mode beam whose pixels keep the last frame's light where they see the same points
};

/// Whether a frame's visibility buffer holds the primitive of every pixel: no rasterised and no cached colours.
[[nodiscard]] constexpr bool knows_primitives(Mode mode) {
    return mode == Mode::raycast || mode == Mode::beam || mode == Mode::reproject || mode == Mode::irsa ||
           mode == Mode::beam_reuse;
}

enum class CasterKind { beam, embree, grid };
enum class OpacityKind { automatic, software, readback };
enum class SunShadows { by_scene, off, on };

/// What a user may choose about a frame. Defaults draw exact frames as fast as the machine can.
struct FrameSettings {
    Mode mode = Mode::hybrid;
    CasterKind caster = CasterKind::beam;
    float grid_cells_per_item = float(farfield::kUsualGridCellsPerItem);  ///< of CasterKind::grid; (0, 64]
    double budget_ms = 0.0;  ///< 0: no limit, every pixel is right; else accuracy is given up to keep it
    budget::WhenLate when_late = budget::WhenLate::coarser;  ///< which accuracy
    std::optional<double> fixed_near_m;                      ///< instead of the controller's choice; [0, inf)
    float max_parallax_px = 0.5f;  ///< a panorama texel is reused up to this predicted parallax. [0, 16]
    float prelit_beyond_m = std::numeric_limits<float>::infinity();  ///< P1 4.6; metres
    /// Blended surfaces nearer to the eye than this are sorted and blended per pixel, farther ones are shown by
    /// coverage. Metres along the ray, [0, inf); 0: all by coverage.
    float blend_within_m = 60.0f;
    OpacityKind opacity = OpacityKind::automatic;
    /// Whether surfaces that do not see the sun are without its light; modes raster and near know of no shadows.
    SunShadows sun_shadows = SunShadows::by_scene;
    bool reuse_sun = true;  ///< modes hybrid and beam_reuse: pixels that see the same points again keep their light
    /// Where the sun stands instead of where the scene has it, a unit direction: a game's time of day.
    std::optional<Vec3> to_sun;
    /// Such a sun is rounded to multiples of this: what shows its light is made anew when it has moved so far. Radians,
    /// [0, 0.1]; 0: for each move.
    float sun_step_rad = 0.0044f;
    std::optional<scene::Weather> weather;  ///< instead of the scene's
    double time_s = 0.0;                    ///< of the game, for what moves by itself: drops, flakes, waves
    /// Lamps farther from the eye than this light nothing. Metres, [0, 100,000]; 0: none does.
    float lamps_within_m = 400.0f;
    /// Air in front of a surface is left out where it changes no channel of the pixel by more than this, of 1. [0,
    /// 0.1]; the usual one is half a level of 255; 0: air is everywhere.
    float air_error = 1.0f / 512.0f;
    /// Water farther from the eye than this is as rough as waves make it, but has none, and rests while the viewer
    /// does. Metres, [0, 100,000]; 0: none has.
    float water_within_m = 1500.0f;
    /// Leaves farther from the eye than this stand still, whatever wind there is. Metres, [0, 1000]; 0: all do.
    float wind_within_m = 60.0f;
    float fall_density = 1.0f;  ///< share of drops and flakes that are drawn. [0, 1]
    /// Rays a frame, about, for what water and glass mirror: as many pixels share one as that takes, up to 8 x 8. 0:
    /// they mirror the sky alone.
    std::uint64_t reflection_rays = 6'000;
    /// Glass and metal farther from the eye than this mirror the sky alone. Metres, (0, 100,000].
    float reflections_within_m = 60.0f;
    effects::Hearing hearing;                ///< for the list of effects alone
    effects::Simulations simulations;        ///< likewise
    effects::EffectSet without_effects = 0;  ///< these are off, whatever calls for them
    int sun_refresh_frames = 32;  ///< reused light is looked at anew at least once in so many. [0, 255]; 0: never
    float resolution = 1.0f;      ///< share of the image's sides that is drawn; enlarged to be shown. [0.25, 1]
    farfield::ReprojectSettings reproject;           ///< mode reproject
    CasterKind reproject_caster = CasterKind::beam;  ///< of tiles that it leaves; single pixels go to Embree

    bool use_panorama = true;
    /// Texels within max_parallax_px serve a viewer who moves, too, not only one who turns: P0's way, not exact.
    bool reuse_while_moving = false;
    /// At most so many pixels are cast a frame; the others keep old texels. With reuse_while_moving.
    std::uint64_t ray_budget = UINT64_MAX;
    float panorama_density = 1.0f;  ///< so many times as many texels a side of the map as usual. [0.25, 2]
    farfield::EdgeRule panorama_edges = farfield::EdgeRule::verify;

    bool use_horizon = true;
    int horizon_subsample = 1;  ///< trace every n-th azimuth, on grid squares so much coarser: 1, 2 or 4
    /// Pixels that the panorama answers get their instance and triangle as well: dearer, for who measures what is seen.
    bool keep_ids = false;
    bool deterministic = false;  ///< decide from recorded costs, so that the same inputs give the same bits

    friend bool operator==(const FrameSettings&, const FrameSettings&) = default;
};

}  // namespace ff::frame
