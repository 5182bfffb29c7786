#include "tests/golden/golden_shots.h"

#include <cmath>

#include "tests/support/town.h"

namespace ff::test {

std::vector<GoldenShot> golden_shots() {
    const Camera street{.position = {0.5, 1.7, 60.0}, .yaw = 0.05};
    const Camera pond{.position = {60.0, 22.0, 40.0}, .yaw = -0.35, .pitch = -0.22};
    using frame::Mode;
    std::vector<GoldenShot> shots;
    for (const auto& [place, camera] : {std::pair("street", street), std::pair("pond", pond)}) {
        const auto add = [&, at = camera](const std::string& kind, frame::FrameSettings settings, int turning = 0) {
            settings.deterministic = true;
            shots.push_back({place + ("_" + kind), at, settings, turning});
        };
        add("hybrid", {.fixed_near_m = 0.0});
        add("hybrid_near100", {.fixed_near_m = 100.0});
        add("hybrid_turned", {.fixed_near_m = 0.0}, 12);
        add("raycast", {.mode = Mode::raycast});
        add("raster", {.mode = Mode::raster});
        add("near", {.mode = Mode::near, .fixed_near_m = 100.0});
    }
    return shots;
}

Result<std::unique_ptr<GoldenStudio>> GoldenStudio::open(double sun_shift) {
    auto studio = std::unique_ptr<GoldenStudio>(new GoldenStudio);
    studio->town_ = make_small_town({.glass = true});
    Vec3& sun = studio->town_.environment.to_sun;
    const float c = float(std::cos(sun_shift)), s = float(std::sin(sun_shift));
    sun = Vec3(c * sun.x - s * sun.z, sun.y, s * sun.x + c * sun.z);
    studio->scene_ = studio->town_.view();
    studio->casters_ = std::make_unique<frame::Casters>(studio->scene_);
    FF_ASSIGN(nearfield::NearRenderer renderer, nearfield::NearRenderer::make(studio->scene_));
    studio->near_renderer_ = std::make_unique<nearfield::NearRenderer>(std::move(renderer));
    return studio;
}

shading::Image GoldenStudio::draw(const GoldenShot& shot) {
    frame::Renderer renderer(scene_, *casters_, near_renderer_.get(), kGoldenWidth, kGoldenHeight);
    shading::Image image;
    constexpr double kTurn = 0.01;  // radians a frame
    for (int f = shot.turning_frames; f >= 0; --f) {
        Camera camera = shot.camera;
        camera.yaw -= kTurn * f;
        renderer.draw(camera, {}, shot.settings, image);
    }
    return image;
}

}  // namespace ff::test
