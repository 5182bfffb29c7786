#pragma once
// The view as the shaders read it (shaders/view.glsl), std140.

#include "engine/math/camera.h"
#include "engine/shading/shading_model.h"

namespace ff::nearfield {

/// Nearer than this is clipped away, metres. Reversed float depth keeps its relative precision whatever it is.
inline constexpr float kNearPlaneM = 0.02f;

/// Clip space: x right, y DOWN (so that row 0 of a target is the top of the image), z = kNearPlaneM (reversed, far
/// plane at infinity), w = depth along the view axis. All from positions relative to the camera, in world axes.
struct ViewUniforms {
    Vec4 clip_x{0.0f};  ///< xyz: clip.x = dot(clip_x, p)
    Vec4 clip_y{0.0f};
    Vec4 clip_w{0.0f};  ///< w: near plane
    Vec4 right{0.0f};   ///< camera's axes in the world; w: u_step
    Vec4 up{0.0f};      ///< w: v_step
    Vec4 back{0.0f};    ///< w: pixel angle
    Vec4 first{0.0f};   ///< x: u_first, y: v_first, z: blend_within_m, w: LeafSway::within_m
    Vec4 gust{0.0f};    ///< trains of LeafSway: turns_per_m; w: turns
    Vec4 sway_u{0.0f};
    Vec4 sway_v{0.0f};
    Vec4 leaves{0.0f};  ///< x: LeafSway::amplitude_m
};
static_assert(sizeof(ViewUniforms) == 11 * 16);

[[nodiscard]] ViewUniforms make_view_uniforms(const PinholeView& view);

}  // namespace ff::nearfield
