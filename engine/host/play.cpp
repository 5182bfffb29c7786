#include "engine/host/play.h"

#include <fmt/format.h>

#include <cmath>

#include "engine/core/log.h"
#include "engine/core/stopwatch.h"
#include "engine/core/write_file.h"
#include "engine/host/player_settings.h"
#include "engine/host/screen.h"
#include "engine/host/session.h"
#include "engine/host/view_drawer.h"
#include "engine/loop/save_game.h"
#include "engine/nearfield/near_renderer.h"
#include "engine/platform/window.h"
#include "engine/scene/load_world.h"

namespace ff::host {
namespace {

using platform::Key;

constexpr double kMouseRadiansPx = 0.0022;

/// One run of the program: what lives as long as the window.
class Player {
  public:
    Player(const GameInfo& info, const PlayOptions& options, scene::World& world)
        : info_(info),
          options_(options),
          world_(world),
          folder_(options.folder.empty() ? player_folder(info.name) : options.folder),
          controls_(info.actions, {}) {}

    Status run();

  private:
    Status read_player_settings();
    void apply_settings();
    void store_settings();
    [[nodiscard]] std::filesystem::path save_path() const { return folder_ / "saved.game"; }

    enum class Purpose : std::uint8_t { play, show_behind_title };
    Status begin_session(Purpose purpose, const loop::SavedGame* saved = nullptr);
    void end_session();
    void save();
    Status load();

    void open(Menu menu);
    Status act(Choice choice);
    /// Of a frame: what is simulated, seen, and drawn.
    Status frame(double dt);
    Status draw();

    const GameInfo& info_;
    const PlayOptions& options_;
    scene::World& world_;
    std::filesystem::path folder_;
    PlayerSettings settings_;
    loop::Controls controls_;

    std::optional<platform::Window> window_;
    std::optional<nearfield::NearRenderer> near_renderer_;
    std::optional<Screen> screen_;
    std::optional<ViewDrawer> drawer_;
    shading::Image image_;

    std::unique_ptr<Session> session_;
    GameView view_;
    platform::InputState input_;
    Menu menu_ = Menu::title, menu_before_settings_ = Menu::title;
    MenuText menu_text_;
    bool show_rows_ = false, quits_ = false, pad_start_before_ = false;
    std::vector<std::pair<std::string, std::string>> rows_;
};

Status Player::read_player_settings() {
    settings_ = default_settings(info_.actions);
    const std::filesystem::path path = folder_ / "settings.toml";
    std::error_code ignored;
    if (!std::filesystem::exists(path, ignored)) return {};
    FF_ASSIGN(const std::string text, read_text_file(path));
    FF_ASSIGN(settings_, read_settings(text, path.string(), info_.actions));
    return {};
}

void Player::apply_settings() {
    controls_.look() = {.mouse_radians_px = kMouseRadiansPx * settings_.mouse_speed,
                        .invert_pitch = settings_.invert_pitch};
    std::copy(settings_.actions.begin(), settings_.actions.end(), controls_.actions().begin());
}

void Player::store_settings() {
    std::error_code ignored;
    std::filesystem::create_directories(folder_, ignored);
    if (const Status status = write_file_whole(folder_ / "settings.toml", to_text(settings_)); !status)
        menu_text_.notice = status.error().message;
}

Status Player::begin_session(Purpose purpose, const loop::SavedGame* saved) {
    end_session();
    SessionSettings settings{.seed = options_.seed,
                             .pack_name = std::filesystem::absolute(options_.pack).string(),
                             .player_settings = to_text(settings_),
                             .recording = {},
                             .start = {},
                             .start_version = 0};
    if (options_.record && purpose == Purpose::play)
        settings.recording = new_recording_path(folder_ / "recordings", info_);
    if (saved != nullptr) {
        settings.start = saved->state;
        settings.start_version = saved->version;
    }
    FF_ASSIGN(session_, Session::begin(info_, world_, settings));
    controls_.look_at(session_->game().yaw(), session_->game().pitch());
    if (drawer_) drawer_->reset();
    return {};
}

void Player::end_session() {
    if (!session_) return;
    if (const Status status = session_->close(); !status) log_warning("{}", status.error().message);
    session_.reset();
}

void Player::save() {
    const Status status = loop::write_save(save_path(), {info_.name, info_.save_version, session_->game().save()});
    menu_text_.notice = status ? "saved" : status.error().message;
}

Status Player::load() {
    const auto loaded = loop::load_save(save_path(), info_.name, info_.save_version);
    if (!loaded) {
        menu_text_.notice = loaded.error().message;
        return {};
    }
    if (const Status status = begin_session(Purpose::play, &loaded->save); !status) {
        menu_text_.notice = status.error().message;
        return begin_session(Purpose::play);
    }
    menu_ = Menu::none;
    if (!loaded->warning.empty()) log_warning("{}", loaded->warning);
    return {};
}

void Player::open(Menu menu) {
    menu_ = menu;
    std::error_code ignored;
    menu_text_ = {.title = menu == Menu::pause ? "Pause" : info_.title,
                  .text = menu == Menu::title ? info_.intro : "",
                  .notice = "",
                  .can_load = std::filesystem::exists(save_path(), ignored) ||
                              std::filesystem::exists(loop::previous_save(save_path()), ignored)};
    if (menu != Menu::end) return;
    menu_text_.title = session_->game().stage() == Stage::won ? "Well done" : "Night";
    menu_text_.text = session_->game().end_text();
}

Status Player::act(Choice choice) {
    switch (choice) {
        case Choice::none:
            break;
        case Choice::start:
            FF_TRY(begin_session(Purpose::play));
            menu_ = Menu::none;
            break;
        case Choice::go_on:
            menu_ = Menu::none;
            break;
        case Choice::load:
            return load();
        case Choice::save:
            save();
            menu_text_.can_load = true;
            break;
        case Choice::settings:
            menu_before_settings_ = menu_;
            menu_ = Menu::settings;
            break;
        case Choice::back:
            store_settings();
            apply_settings();
            menu_ = menu_before_settings_;
            break;
        case Choice::to_title:
            FF_TRY(begin_session(Purpose::show_behind_title));
            open(Menu::title);
            break;
        case Choice::quit:
            quits_ = true;
            break;
    }
    return {};
}

Status Player::draw() {
    frame::FrameSettings frame_settings;
    frame_settings.budget_ms = options_.budget_ms.value_or(settings_.budget_ms);
    if (settings_.fov_deg != 0.0) view_.camera.vertical_fov *= radians_of(settings_.fov_deg) / info_.fov;
    FF_TRY(drawer_->draw(view_, settings_.width, settings_.height, frame_settings, image_));
    const platform::FramebufferSize size = window_->framebuffer_size();
    FF_TRY(near_renderer_->present(image_, size.width, size.height));
    rows_.clear();
    if (show_rows_) {
        rows_.emplace_back("frame",
                           fmt::format("{:.1f} ms of {:.1f}", drawer_->stats().frame_ms, frame_settings.budget_ms));
        rows_.emplace_back("drawn at", fmt::format("{} x {}", drawer_->renderer().plan().view.width,
                                                   drawer_->renderer().plan().view.height));
        rows_.emplace_back("tick", fmt::format("{}", session_->game().ticks()));
    }
    return {};
}

Status Player::frame(double dt) {
    const bool plays = menu_ == Menu::none;
    window_->capture_mouse(plays);
    if (plays) session_->advance(input_, std::llround(1e9 * dt), controls_, view_.turn_scale);
    session_->show(controls_, view_);
    FF_TRY(draw());
    if (plays && session_->game().stage() != Stage::playing) open(Menu::end);
    if (menu_ == Menu::title) view_.hud.clear();
    const Choice choice = screen_->draw(view_.hud, menu_, menu_text_, input_, settings_, rows_);
    window_->swap();
    FF_TRY(act(choice));
    if (input_.pressed(Key::f1)) show_rows_ = !show_rows_;
    const bool pad_start = ((input_.gamepad.buttons >> 7) & 1) != 0;
    if (plays && (input_.pressed(Key::escape) || (pad_start && !pad_start_before_))) open(Menu::pause);
    // The menu itself goes back from the settings.
    else if (menu_ == Menu::pause && choice == Choice::none && input_.pressed(Key::escape))
        menu_ = Menu::none;
    pad_start_before_ = pad_start;
    return {};
}

Status Player::run() {
    FF_TRY(read_player_settings());
    apply_settings();
    FF_ASSIGN(platform::Window window, platform::Window::open({.title = info_.title,
                                                               .width = settings_.width,
                                                               .height = settings_.height,
                                                               .fullscreen = settings_.fullscreen}));
    window_.emplace(std::move(window));
    FF_ASSIGN(nearfield::NearRenderer near_renderer, nearfield::NearRenderer::make(world_.scene()));
    near_renderer_.emplace(std::move(near_renderer));
    FF_ASSIGN(Screen screen, Screen::make(*window_));
    screen_.emplace(std::move(screen));
    drawer_.emplace(world_, &*near_renderer_);
    FF_TRY(begin_session(options_.skip_title ? Purpose::play : Purpose::show_behind_title));
    open(options_.skip_title ? Menu::none : Menu::title);
    Stopwatch clock;
    while (!quits_ && window_->poll(input_)) {
        const double dt = clock.seconds();
        clock.restart();
        const platform::FramebufferSize size = window_->framebuffer_size();
        if (size.width < 16 || size.height < 16) continue;  // minimised
        FF_TRY(frame(dt));
    }
    end_session();
    return {};
}

}  // namespace

Status play(const GameInfo& info, const PlayOptions& options) {
    FF_ASSIGN(const std::unique_ptr<scene::World> world, scene::load_world(options.pack));
    Player player(info, options, *world);
    return player.run();
}

}  // namespace ff::host
