#pragma once
// The viewer, and the pinhole view of one frame: which ray belongs to which pixel.

#include "engine/math/leaf_sway.h"
#include "engine/math/types.h"

namespace ff {

/// Where the viewer stands and looks. Yaw 0 looks north (-z), positive to the east; pitch positive up; roll positive
/// tilts the head to the right. Applied yaw, then pitch, then roll.
struct Camera {
    WorldPos position{0.0};
    double yaw = 0.0;              ///< radians
    double pitch = 0.0;            ///< radians, [-pi/2, pi/2]
    double roll = 0.0;             ///< radians
    double vertical_fov = 1.0472;  ///< radians, (0, pi)

    friend bool operator==(const Camera&, const Camera&) = default;
};

/// Camera axes as columns, in the world: +x right, +y up, +z backwards (the view looks along -z).
[[nodiscard]] DMat3 world_from_camera(const Camera& camera);

/// The rays of an image. Pixel (x, y), x right and y DOWN from the top left corner, has its ray through its centre:
/// direction in camera space (u, v, -1), u = (x + 0.5) * u_step + u_first, v = (y + 0.5) * v_step + v_first,
/// v_step < 0. Depth is the distance along the view axis: a hit at depth t lies at position + t * R * (u, v, -1).
struct PinholeView {
    WorldPos position{0.0};
    Mat3 world_from_camera{1.0f};  ///< orthonormal
    int width = 0;                 ///< pixels
    int height = 0;
    float u_step = 0, u_first = 0;
    float v_step = 0, v_first = 0;
    /// Blended surfaces nearer to the eye than this, metres along the ray, are transparent layers: whatever finds what
    /// a pixel sees looks past them (farfield/alpha_test.h), and they are blended over it. 0: there are none.
    float blend_within_m = 0;
    LeafSway sway;  ///< of leaves, about `position`, in world axes

    /// Ray direction of a pixel in world axes, |z_camera| = 1 (not unit length).
    [[nodiscard]] Vec3 direction(int x, int y) const {
        return world_from_camera *
               Vec3((float(x) + 0.5f) * u_step + u_first, (float(y) + 0.5f) * v_step + v_first, -1.0f);
    }
    /// Angle that a pixel covers at the image centre, radians: the slope of its ray cone.
    [[nodiscard]] float pixel_angle() const { return -v_step; }
};

[[nodiscard]] PinholeView make_view(const Camera& camera, int width, int height);

/// The view of one face of a cube map of size x size texels around a position, in world axes. Faces 0..5 look along
/// +x, -x, +y, -y, +z, -z.
[[nodiscard]] PinholeView make_cube_face_view(const WorldPos& position, int face, int size);

}  // namespace ff
