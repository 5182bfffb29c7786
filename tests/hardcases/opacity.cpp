// The opacity buffer promises that what it covers the near raster covers: never a pixel that is empty.

#include <fmt/format.h>

#include <cmath>
#include <memory>
#include <numeric>
#include <vector>

#include "engine/farfield/opacity_buffer.h"
#include "engine/nearfield/near_renderer.h"
#include "engine/platform/headless.h"
#include "tests/hardcases/cases.h"
#include "tests/support/worlds.h"

namespace ff::hardcases {
namespace {

using farfield::OpacityRaster;
using farfield::PixelMask;

constexpr float kNearPlaneM = 0.1f;

/// Slivers along pixel rows, triangles through the near plane and through the eye, ones that reach a thousand
/// kilometres beside the image, ones with edges exactly on pixel centres.
scene::SceneData make_hard_triangles(test::Random& random) {
    scene::MeshSource mesh;
    const auto add = [&](const Vec3& a, const Vec3& b, const Vec3& c) { test::append_triangle(mesh, a, b, c, 0); };
    const auto ahead = [&](float depth) {
        return random.in_box(Vec3(-depth, -depth, -depth), Vec3(depth, depth, -depth));
    };
    for (int i = 0; i < 24; ++i) {
        const auto depth = float(random.in(0.3, 20.0));
        const Vec3 a = ahead(depth);
        switch (random.below(5)) {
            case 0: {
                const Vec3 b = ahead(depth * float(random.in(0.5, 2.0)));
                add(a, b,
                    a + (b - a) * float(random.unit()) + random.in_box(Vec3(-1e-7f), Vec3(1e-7f)) * glm::length(b - a));
                break;
            }
            case 1:  // through the near plane, or a hair before or behind it
                add(a, Vec3(a.y, a.x, float(random.in(-0.3, 0.3))),
                    Vec3(a.x, -a.y, -kNearPlaneM * float(1.0 + random.in(-1e-6, 1e-6))));
                break;
            case 2:  // beyond any guard band
                add(a, random.in_box(Vec3(-1e6f), Vec3(1e6f)), random.in_box(Vec3(-1e6f), Vec3(1e6f)));
                break;
            case 3: {  // pixel centres of a 64 x 64 image of 90 degrees
                const auto corner = [&] {
                    return depth * Vec3((float(random.below(64)) + 0.5f) / 32.0f - 1.0f,
                                        (float(random.below(64)) + 0.5f) / 32.0f - 1.0f, -1.0f);
                };
                add(corner(), corner(), corner());
                break;
            }
            default:
                add(a, a + random.in_box(Vec3(-0.3f), Vec3(0.3f)), a + random.in_box(Vec3(-0.3f), Vec3(0.3f)));
        }
    }
    return scene_of(std::move(mesh), WorldPos(0.0));
}

PinholeView hard_view(test::Random& random) {
    Camera camera{.vertical_fov = 0.5 * kPi};
    int width = 64, height = 64;
    if (random.below(2) == 0) {
        camera.yaw = random.in(-0.2, 0.2);
        camera.roll = random.in(-kPi, kPi);
        camera.vertical_fov = random.in(0.1, 2.4);
        width = 50 + int(random.below(60));
        height = 40 + int(random.below(40));
    }
    return make_view(camera, width, height);
}

std::vector<std::uint32_t> all_instances(const scene::StaticScene& scene) {
    std::vector<std::uint32_t> ids(scene.instances.size());
    std::iota(ids.begin(), ids.end(), 0u);
    return ids;
}

template <class IsCovered>
void count_covered(const PixelMask& covered, Trial& trial, IsCovered&& is_covered) {
    for (int y = 0; y < covered.height; ++y)
        for (int x = 0; x < covered.width; ++x)
            trial.count(!covered.test(x, y) || is_covered(x, y), 0.0,
                        [&] { return fmt::format("pixel {}, {} is covered by nothing", x, y); });
}

}  // namespace

void opacity_exact(Trial& trial) {
    OpacityRaster raster({.near_plane_m = kNearPlaneM});
    PixelMask covered, exact, easy_covered;
    while (!trial.done()) {
        test::Random random(trial.next_seed());
        const scene::SceneData data = make_hard_triangles(random);
        const scene::SceneData easy_data = test::make_triangle_soup(
            {.triangles = 8, .meshes = 1}, {.seed = random.below(1u << 30), .height_grid_size = 16});
        const scene::StaticScene scene = data.view(), easy_scene = easy_data.view();
        const PinholeView view = hard_view(random);
        const auto ids = all_instances(scene), easy_ids = all_instances(easy_scene);
        trial.time_hard([&] { raster.draw(scene, {}, ids, view, covered); });
        trial.time_easy([&] { raster.draw(easy_scene, {}, easy_ids, view, easy_covered); });
        draw_opacity_reference(scene, {}, ids, view, double(kNearPlaneM), exact);
        count_covered(covered, trial, [&](int x, int y) { return exact.test(x, y); });
        trial.report();
    }
}

void opacity_opengl(Trial& trial) {
    auto context = platform::HeadlessContext::open();
    if (!context) return trial.skip(context.error().message);
    OpacityRaster raster({.near_plane_m = kNearPlaneM});
    PixelMask covered;
    farfield::VisibilityBuffer drawn;
    nearfield::NearStats stats;
    while (!trial.done()) {
        test::Random random(trial.next_seed());
        const scene::SceneData data = make_hard_triangles(random);
        const scene::StaticScene scene = data.view();
        auto near_renderer = nearfield::NearRenderer::make(scene);
        if (!near_renderer) return trial.skip(near_renderer.error().message);
        const auto ids = all_instances(scene);
        for (int views = 0; views < 8; ++views) {
            const PinholeView view = hard_view(random);
            if (const Status status = near_renderer->render_ids(view, {.instances = ids}, drawn, stats); !status)
                return trial.skip(status.error().message);
            raster.draw(scene, {}, ids, view, covered);
            count_covered(covered, trial,
                          [&](int x, int y) { return drawn.instance[drawn.index(x, y)] != farfield::kUnresolved; });
        }
        trial.report();
    }
}

}  // namespace ff::hardcases
