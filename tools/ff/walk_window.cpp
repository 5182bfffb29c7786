#include "tools/ff/walk_window.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "engine/core/log.h"
#include "engine/core/stopwatch.h"
#include "engine/core/write_file.h"
#include "engine/loop/fixed_step.h"
#include "engine/loop/free_camera.h"
#include "engine/nearfield/near_renderer.h"
#include "engine/platform/window.h"
#include "tools/ff/debug_picture.h"
#include "tools/ff/session.h"
#include "tools/picture/picture_file.h"

namespace ff::tool {
namespace {

using platform::Key;

constexpr std::size_t kGraphFrames = 240;
constexpr double kLongestStep = 0.25;  ///< seconds that may pass between two frames
constexpr int kRecordHz = 60;          ///< frames a second of what the player records

bool takes_over(const platform::InputState& input) {
    for (const Key key : {Key::w, Key::a, Key::s, Key::d, Key::e, Key::q, Key::up, Key::down, Key::left, Key::right})
        if (input.held(key)) return true;
    const auto& pad = input.gamepad;
    return input.held(platform::MouseButton::left) || pad.left_x != 0 || pad.left_y != 0 || pad.right_x != 0 ||
           pad.right_y != 0;
}

scene::WalkFrame frame_of(const Camera& camera) {
    return {.position = camera.position,
            .yaw_deg = degrees_of(camera.yaw),
            .pitch_deg = degrees_of(camera.pitch),
            .roll_deg = degrees_of(camera.roll)};
}

/// The walk played back, until the player takes the camera; and what the player records.
class Walker {
  public:
    Walker(const scene::Walk& walk, std::filesystem::path out) : walk_(walk), out_(std::move(out)) {}

    /// The camera after `dt` more seconds.
    const Camera& advance(const platform::InputState& input, double dt) {
        seconds_ += std::min(dt, kLongestStep);
        if (playing_ && takes_over(input)) {
            playing_ = false;
            log_info("the camera is yours: WASD, E and Q, mouse or arrow keys, shift to run; P plays the walk on");
        }
        if (input.pressed(Key::p)) playing_ = true;
        if (playing_) {
            time_ += dt;
            const double frames = double(walk_.frames.size());
            camera_ = walk_.camera(std::size_t(std::fmod(time_ * walk_.rate_hz, frames)));
        } else {
            loop::move_free_camera(input, dt, {}, camera_);
        }
        if (input.pressed(Key::r)) toggle_recording();
        // However fast the window draws, the recording plays as fast as it was walked.
        const int ticks = record_step_.advance(std::llround(1e9 * dt));
        if (recording_) recorded_.frames.insert(recorded_.frames.end(), std::size_t(ticks), frame_of(camera_));
        return camera_;
    }

    /// The time of what moves: since the window opened, without the times in which nothing was drawn.
    [[nodiscard]] double seconds() const { return seconds_; }

    void stop_recording() {
        if (!recording_) return;
        recording_ = false;
        std::error_code ignored;
        std::filesystem::create_directories(out_, ignored);
        std::filesystem::path path;
        for (int n = 1; path.empty() || std::filesystem::exists(path); ++n)
            path = out_ / fmt::format("recorded{}.walk.json", n);
        if (const Status status = write_file_whole(path, scene::walk_to_json(recorded_)); !status) {
            log_warning("{}", status.error().message);
            return;
        }
        log_info("{}: {} frames recorded; play them with --walk", path.string(), recorded_.frames.size());
    }

  private:
    void toggle_recording() {
        if (recording_) return stop_recording();
        recorded_ = {.name = "recorded", .fov_deg = walk_.fov_deg, .rate_hz = kRecordHz};
        recording_ = true;
        log_info("recording; R again ends it");
    }

    const scene::Walk& walk_;
    std::filesystem::path out_;
    Camera camera_;
    double time_ = 0.0, seconds_ = 0.0;
    bool playing_ = true, recording_ = false;
    loop::FixedStep record_step_{{.ticks_per_second = kRecordHz}};
    scene::Walk recorded_;
};

Status save_picture(const std::filesystem::path& out, const shading::Image& image) {
    std::error_code ignored;
    std::filesystem::create_directories(out, ignored);
    std::filesystem::path path;
    for (int n = 1; path.empty() || std::filesystem::exists(path); ++n) path = out / fmt::format("picture{}.png", n);
    FF_TRY(write_image(path, image));
    log_info("{}", path.string());
    return {};
}

}  // namespace

Status walk_in_window(const WalkOptions& options) {
    FF_ASSIGN(const std::unique_ptr<scene::World> world, open_world(options.view.pack));
    FF_ASSIGN(const scene::Walk walk, find_walk(*world, options.view.walk));
    FF_ASSIGN(frame::FrameSettings settings, chosen_settings(options.view, *world, walk));
    if (options.view.sun_deg) settings.to_sun = sun_direction(*options.view.sun_deg);
    FF_ASSIGN(platform::Window window, platform::Window::open({.title = "Farfield: " + world->info().name,
                                                               .width = options.view.size.width,
                                                               .height = options.view.size.height}));
    FF_ASSIGN(nearfield::NearRenderer near_renderer, nearfield::NearRenderer::make(world->scene()));
    frame::Casters casters(world->scene());
    FF_ASSIGN(const std::unique_ptr<MovingModels> moving,
              MovingModels::make(*world, options.view.scenery, settings.without_effects));

    FF_ASSIGN(debug::Overlay overlay, debug::Overlay::make(window));
    debug::OverlayData overlay_data;
    std::vector<float> recent_ms(kGraphFrames, 0.0f);
    bool show_overlay = false;
    int debug_view = 0;

    Walker walker(walk, options.out);
    platform::InputState input;
    std::unique_ptr<frame::Renderer> renderer;
    platform::FramebufferSize size;
    shading::Image image;
    Stopwatch tick, title;
    while (window.poll(input) && !input.pressed(Key::escape)) {
        const double dt = tick.seconds();
        tick.restart();
        window.capture_mouse(input.held(platform::MouseButton::left));
        const Camera& camera = walker.advance(input, dt);

        const platform::FramebufferSize now = window.framebuffer_size();
        if (now.width < 16 || now.height < 16) continue;  // minimised
        if (!renderer || now.width != size.width || now.height != size.height) {
            size = now;
            renderer =
                std::make_unique<frame::Renderer>(world->scene(), casters, &near_renderer, size.width, size.height);
        }
        moving->advance(walker.seconds(), camera);
        settings.time_s = walker.seconds();
        settings.simulations = moving->work();
        const auto dynamic = moving->at(walker.seconds(), camera, {size.width, size.height});
        const frame::FrameStats& stats = renderer->draw(camera, dynamic, settings, image);
        FF_TRY(renderer->refusal());
        if (input.pressed(Key::f1)) show_overlay = !show_overlay;
        if (input.pressed(Key::f2)) debug_view = (debug_view + 1) % int(kDebugViewNames.size());
        draw_debug_view(DebugView(debug_view), *renderer, casters, image);
        FF_TRY(near_renderer.present(image, size.width, size.height));
        std::rotate(recent_ms.begin(), recent_ms.begin() + 1, recent_ms.end());
        recent_ms.back() = float(stats.frame_ms);
        if (show_overlay) {
            fill_overlay(*renderer, overlay_data);
            overlay_data.graph = recent_ms;
            overlay_data.graph_budget_ms = float(settings.budget_ms);
            overlay.draw(overlay_data);
        }
        window.swap();
        if (input.pressed(Key::f12)) FF_TRY(save_picture(options.out, image));
        if (title.seconds() > 0.5) {
            window.set_title(fmt::format("Farfield: {}  {:.1f} ms", world->info().name, stats.frame_ms));
            title.restart();
        }
    }
    walker.stop_recording();
    return {};
}

}  // namespace ff::tool
