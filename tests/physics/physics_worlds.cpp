#include "tests/physics/physics_worlds.h"

#include <cmath>

namespace ff::test {

Ground& Ground::floor(float half, float y) {
    const int n = int(half);
    for (int z = -n; z < n; ++z)
        for (int x = -n; x < n; ++x) {
            const auto at = [&](int dx, int dz) { return Vec3(float(x + dx), y, float(z + dz)); };
            append_quad(mesh_, at(0, 0), at(0, 1), at(1, 1), at(1, 0), 0);
        }
    return *this;
}

Ground& Ground::ramp(double slope_deg, float length) {
    const float x = length * float(std::cos(radians_of(slope_deg)));
    const float y = length * float(std::sin(radians_of(slope_deg)));
    append_quad(mesh_, {0, 0, -10}, {0, 0, 10}, {x, y, 10}, {x, y, -10}, 0);
    return *this;
}

Ground& Ground::stairs(int steps, float rise, float run) {
    for (int i = 0; i < steps; ++i) {
        const float y = rise * float(i + 1);
        append_box(mesh_, {run * float(i), 0.0f, -3.0f}, {run * float(steps) + 6.0f, y, 3.0f}, 1, 0);
    }
    return *this;
}

scene::SceneData Ground::finish(const WorldPos& origin) const {
    scene::SceneData scene;
    scene.materials.push_back(plain_material());
    const std::uint32_t mesh = scene.add_mesh(scene::prepare_mesh(mesh_, scene.materials));
    scene.add_instance(mesh, origin, Mat3(1.0f), 0);
    scene.finish(64);
    return scene;
}

}  // namespace ff::test
