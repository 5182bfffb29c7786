// The panorama where its cube has poles, edges and corners, and after very many small turns.

#include "engine/farfield/panorama.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "engine/loop/free_camera.h"
#include "tests/hardcases/cases.h"
#include "tests/support/worlds.h"

namespace ff::hardcases {
namespace {

using farfield::Panorama;
using farfield::VisibilityBuffer;

constexpr int kWidth = 160, kHeight = 128;

/// A viewer in the middle of a closed ball, whose panorama is full of it.
class PanoramaRig {
  public:
    PanoramaRig()
        : data_(test::make_closed_sphere(40.0, 24)), scene_(data_.view()), caster_(make_caster(Subject::beam, scene_)) {
        found_.resize(kWidth, kHeight);
        seen_.resize(kWidth, kHeight);
        colors_.assign(found_.instance.size(), 0);
    }

    void begin_frame() { panorama_.begin_frame(WorldPos(0.0)); }
    void fill(const PinholeView& view) {
        const auto tiles = all_tiles(view);
        begin_frame();
        panorama_.plan_fill(view, tiles, {});
        map_colors_.resize(panorama_.map().instance.size(), 0xFF808080u);
        for (int face = 0; face < 6; ++face) {
            caster_->cast_tiles(panorama_.face_view(face), panorama_.fill_requests(face), panorama_.map());
            panorama_.commit_fill(face, map_colors_, panorama_.map().stride);
        }
    }
    void look_up(const PinholeView& view) {
        const auto tiles = all_tiles(view);
        std::fill(found_.instance.begin(), found_.instance.end(), farfield::kUnresolved);
        panorama_.lookup(view, tiles, {.edges = farfield::EdgeRule::blend}, {&found_, colors_.data(), found_.stride},
                         to_cast_);
    }
    /// How far a pixel's distance is off that of a ray of its own, relatively; NaN: it was not answered.
    double error_at(int x, int y) const {
        const std::size_t at = found_.index(x, y);
        if (found_.instance[at] != 0) return std::nan("");
        return std::fabs(double(found_.depth[at]) / double(seen_.depth[at]) - 1.0);
    }
    void cast(const PinholeView& view) { caster_->cast_tiles(view, all_tiles(view), seen_); }
    void count(const PinholeView& view, Trial& trial) {
        cast(view);
        for (int y = 0; y < kHeight; ++y)
            for (int x = 0; x < kWidth; ++x) {
                const double off = error_at(x, y);
                trial.count(!std::isnan(off), off, [&] { return fmt::format("pixel {}, {}: no answer", x, y); });
            }
    }

  private:
    scene::SceneData data_;
    scene::StaticScene scene_;
    std::unique_ptr<farfield::RayCaster> caster_;
    Panorama panorama_{{.face_size = 256}};
    VisibilityBuffer found_, seen_;
    std::vector<std::uint32_t> colors_, map_colors_;
    std::vector<farfield::TileRequest> to_cast_;
};

/// Straight at poles, cube edges and corners, or a hair beside.
Camera seam_camera(test::Random& random) {
    constexpr std::array<double, 5> kHairs{0.0, 1e-12, -1e-9, 1e-7, -1e-4};
    const auto hair = [&] { return kHairs[random.below(kHairs.size())]; };
    const double corner = std::atan(std::sqrt(0.5));
    const std::array<double, 7> pitches{0.0, corner, -corner, 0.25 * kPi, -0.25 * kPi, 0.5 * kPi, -0.5 * kPi};
    Camera camera;
    camera.yaw = 0.25 * kPi * (double(random.below(9)) - 4.0) + hair();
    camera.pitch = std::clamp(pitches[random.below(pitches.size())] + hair(), -0.5 * kPi, 0.5 * kPi);
    camera.roll = random.below(2) == 0 ? 0.25 * kPi * double(random.below(8)) : random.in(-kPi, kPi);
    camera.vertical_fov = radians_of(random.in(5.0, 120.0));
    return camera;
}

}  // namespace

void panorama_seams(Trial& trial) {
    PanoramaRig rig;
    while (!trial.done()) {
        test::Random random(trial.next_seed());
        const Camera camera = seam_camera(random);
        Camera easy_camera = camera;
        easy_camera.yaw = random.in(-0.1, 0.1);
        easy_camera.pitch = random.in(-0.1, 0.1);
        const PinholeView view = make_view(camera, kWidth, kHeight), easy = make_view(easy_camera, kWidth, kHeight);
        rig.fill(easy);
        rig.fill(view);
        trial.time_easy([&] { rig.look_up(easy); });
        trial.time_hard([&] { rig.look_up(view); });
        rig.count(view, trial);
        trial.report();
    }
}

void panorama_turns(Trial& trial) {
    constexpr int kTurnsPerPicture = 50000;
    constexpr double kPixelRadians = 1.0472 / 480.0, kDepthError = 0.02;
    const loop::FreeCameraSettings settings;
    PanoramaRig rig;
    Camera camera;
    long double yaw = 0.0;  // the sum of all turns, never wrapped
    platform::InputState input;
    while (!trial.done()) {
        test::Random random(trial.next_seed());
        for (int turn = 0; turn < kTurnsPerPicture; ++turn) {
            input.mouse_dx = random.in(-0.5, 1.5);
            input.mouse_dy = random.in(-0.5, 0.5);
            move_free_camera(input, 1.0 / 120.0, settings, camera);
            rig.begin_frame();
            yaw += static_cast<long double>(settings.mouse_radians_px * input.mouse_dx);
            const long double off =
                std::remainder(yaw - static_cast<long double>(camera.yaw), 2.0L * std::numbers::pi_v<long double>);
            trial.count(std::fabs(camera.yaw) <= kPi && std::fabs(camera.pitch) <= 0.5 * kPi,
                        double(std::fabs(off)) / kPixelRadians, [&] { return fmt::format("yaw {}", camera.yaw); });
        }
        const PinholeView view = make_view(camera, kWidth, kHeight);
        rig.fill(view);
        rig.look_up(view);
        rig.cast(view);
        for (int y = 0; y < kHeight; ++y)
            for (int x = 0; x < kWidth; ++x)
                trial.count(rig.error_at(x, y) < kDepthError, 0.0, [&] { return fmt::format("pixel {}, {}", x, y); });
        trial.report();
    }
}

}  // namespace ff::hardcases
