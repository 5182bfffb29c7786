#pragma once

#include <limits>
#include <optional>

#include "engine/budget/governor.h"
#include "engine/farfield/reproject.h"

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
};

/// Whether a frame's visibility buffer holds the primitive of every pixel: no rasterised and no cached colours.
[[nodiscard]] constexpr bool knows_primitives(Mode mode) {
    return mode == Mode::raycast || mode == Mode::beam || mode == Mode::reproject || mode == Mode::irsa;
}

enum class CasterKind { beam, embree, grid };
enum class OpacityKind { automatic, software, readback };

/// What a user may choose about a frame. Defaults draw exact frames as fast as the machine can.
struct FrameSettings {
    Mode mode = Mode::hybrid;
    CasterKind caster = CasterKind::beam;
    double budget_ms = 0.0;  ///< 0: no limit, every pixel is right; else accuracy is given up to keep it
    budget::WhenLate when_late = budget::WhenLate::coarser;  ///< which accuracy
    std::optional<double> fixed_near_m;                      ///< instead of the controller's choice; [0, inf)
    float max_parallax_px = 0.5f;  ///< a panorama texel is reused up to this predicted parallax. [0, 16]
    float prelit_beyond_m = std::numeric_limits<float>::infinity();  ///< P1 4.6; metres
    OpacityKind opacity = OpacityKind::automatic;
    farfield::ReprojectSettings reproject;           ///< mode reproject
    CasterKind reproject_caster = CasterKind::beam;  ///< of tiles that it leaves; single pixels go to Embree
    bool use_panorama = true;
    bool use_horizon = true;
    bool deterministic = false;  ///< decide from recorded costs, so that the same inputs give the same bits
};

}  // namespace ff::frame
