// From 1 cm to 10,000 km in one frame, in order.

#include <cmath>

#include "tests/hardcases/cases.h"
#include "tests/hardcases/exact_pixels.h"
#include "tests/support/worlds.h"

namespace ff::hardcases {
namespace {

constexpr double kNearestM = 0.01, kFarthestM = 1e7;

/// Sheets at depths of all magnitudes before the eye, each with a second one a thousandth behind it.
/// @param nearest_m, farthest_m  of the depths
scene::SceneData make_sheets(test::Random& random, const Camera& camera, double nearest_m, double farthest_m) {
    scene::SceneData data;
    data.materials.push_back(test::plain_material());
    scene::MeshSource sheet;
    test::append_quad(sheet, Vec3(-1, -1, 0), Vec3(1, -1, 0), Vec3(1, 1, 0), Vec3(-1, 1, 0), 0);
    const std::uint32_t id = data.add_mesh(scene::prepare_mesh(std::move(sheet), data.materials));
    const DMat3 axes = world_from_camera(camera);
    for (int i = 0; i < 24; ++i) {
        const double depth = nearest_m * std::pow(farthest_m / nearest_m, random.unit());
        const DVec3 at(random.in(-0.5, 0.5) * depth, random.in(-0.5, 0.5) * depth, -depth);
        const Vec3 size = random.in_box(Vec3(0.02f), Vec3(0.2f)) * float(depth);
        const DMat3 tilt = world_from_camera({.yaw = random.in(-0.6, 0.6), .pitch = random.in(-0.6, 0.6)});
        const Mat3 world_from_mesh =
            Mat3(axes * tilt) * Mat3(Vec3(size.x, 0, 0), Vec3(0, size.y, 0), Vec3(0, 0, size.z));
        for (const double behind : {1.0, 1.001})
            data.add_instance(id, camera.position + axes * (at * behind), world_from_mesh, std::uint32_t(i));
    }
    data.finish(16);
    return data;
}

}  // namespace

template <Subject kSubject>
void depth_order(Trial& trial) {
    farfield::VisibilityBuffer seen, easy;
    while (!trial.done()) {
        test::Random random(trial.next_seed());
        Camera camera = test::random_camera(random, {DVec3(-100.0), DVec3(100.0)});
        const PinholeView view = make_view(camera, 96, 80);
        const scene::SceneData data = make_sheets(random, camera, kNearestM, kFarthestM);
        const scene::SceneData easy_data = make_sheets(random, camera, 1.0, 100.0);
        const scene::StaticScene scene = data.view(), easy_scene = easy_data.view();
        const auto caster = make_caster(kSubject, scene), easy_caster = make_caster(kSubject, easy_scene);
        seen.resize(view.width, view.height);
        easy.resize(view.width, view.height);
        const auto tiles = all_tiles(view);
        trial.time_hard([&] { caster->cast_tiles(view, tiles, seen); });
        trial.time_easy([&] { easy_caster->cast_tiles(view, tiles, easy); });
        ExactPixels(scene, view, {}).count(seen, trial);
        trial.report();
    }
}
template void depth_order<Subject::beam>(Trial&);
template void depth_order<Subject::embree>(Trial&);
template void depth_order<Subject::grid>(Trial&);

}  // namespace ff::hardcases
