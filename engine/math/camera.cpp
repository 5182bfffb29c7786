#include "engine/math/camera.h"

#include <cmath>

namespace ff {

DMat3 world_from_camera(const Camera& camera) {
    const double cy = std::cos(camera.yaw), sy = std::sin(camera.yaw);
    const double cp = std::cos(camera.pitch), sp = std::sin(camera.pitch);
    const double cr = std::cos(camera.roll), sr = std::sin(camera.roll);
    const DVec3 forward(sy * cp, sp, -cy * cp);
    const DVec3 level_right(cy, 0.0, sy);
    const DVec3 level_up(-sy * sp, cp, cy * sp);
    return DMat3(cr * level_right - sr * level_up, sr * level_right + cr * level_up, -forward);
}

PinholeView make_view(const Camera& camera, int width, int height) {
    const double half_height = std::tan(0.5 * camera.vertical_fov);
    const double step = 2.0 * half_height / height;
    PinholeView view;
    view.position = camera.position;
    view.world_from_camera = Mat3(world_from_camera(camera));
    view.width = width;
    view.height = height;
    view.u_step = float(step);
    view.u_first = float(-0.5 * step * width);
    view.v_step = float(-step);
    view.v_first = float(half_height);
    return view;
}

PinholeView make_cube_face_view(const WorldPos& position, int face, int size) {
    // Columns: right, up, backward. Up is +y on the sides; the top and bottom face have theirs along z.
    static const Mat3 axes[6] = {
        Mat3(Vec3(0, 0, 1), Vec3(0, 1, 0), Vec3(-1, 0, 0)),  Mat3(Vec3(0, 0, -1), Vec3(0, 1, 0), Vec3(1, 0, 0)),
        Mat3(Vec3(1, 0, 0), Vec3(0, 0, 1), Vec3(0, -1, 0)),  Mat3(Vec3(1, 0, 0), Vec3(0, 0, -1), Vec3(0, 1, 0)),
        Mat3(Vec3(-1, 0, 0), Vec3(0, 1, 0), Vec3(0, 0, -1)), Mat3(Vec3(1, 0, 0), Vec3(0, 1, 0), Vec3(0, 0, 1)),
    };
    PinholeView view;
    view.position = position;
    view.world_from_camera = axes[face];
    view.width = view.height = size;
    view.u_step = 2.0f / float(size);
    view.u_first = -1.0f;
    view.v_step = -2.0f / float(size);
    view.v_first = 1.0f;
    return view;
}

}  // namespace ff
