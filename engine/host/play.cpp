#include "engine/host/play.h"

#include <fmt/format.h>

#include <cmath>

#include "engine/core/log.h"
#include "engine/core/stopwatch.h"
#include "engine/core/write_file.h"
#include "engine/host/frame_log.h"
#include "engine/host/player_settings.h"
#include "engine/host/screen.h"
#include "engine/host/session.h"
#include "engine/host/view_drawer.h"
#include "engine/loop/save_game.h"
#include "engine/nearfield/near_renderer.h"
#include "engine/platform/window.h"
#include "engine/scene/load_world.h"
#include "engine/sound/sound_player.h"

namespace ff::host {
namespace {

using platform::Key;

constexpr double kMouseRadiansPx = 0.0022;
constexpr double kSaidSeconds = 8.0;

/// One run of the program: what lives as long as the window.
class Player {
  public:
    Player(const GameInfo& info, const PlayOptions& options, std::unique_ptr<scene::World> world)
        : info_(info),
          options_(options),
          world_(std::move(world)),
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
    /// The first frame of a place builds what later ones reuse, however long that takes: it belongs to the loading.
    Status draw_before_play();
    [[nodiscard]] SessionSettings session_settings(Purpose purpose) const;
    void end_session();
    void save();
    Status load();

    /// Takes up what changed; what cannot be taken leaves all as it was and says why.
    void take(const Change& change);
    Status take_world(const std::filesystem::path& pack);
    Status make_shaders_anew();
    void say(std::string text);

    void open(Menu menu);
    void take_picture();
    [[nodiscard]] frame::FrameSettings frame_settings() const;
    Status act(Choice choice);
    /// Of a frame: what is simulated, seen, and drawn.
    Status frame(double dt);
    Status draw();
    /// Lets the player hear what the view says; opens a device only for a world that has something to be heard.
    void hear();

    const GameInfo& info_;
    const PlayOptions& options_;
    std::unique_ptr<scene::World> world_;
    std::filesystem::path folder_;
    PlayerSettings settings_;
    loop::Controls controls_;

    std::optional<platform::Window> window_;
    std::optional<nearfield::NearRenderer> near_renderer_;
    std::optional<Screen> screen_;
    std::optional<ViewDrawer> drawer_;
    std::optional<sound::SoundPlayer> sound_;
    bool has_tried_sound_ = false;  ///< with this world
    shading::Image image_;

    std::unique_ptr<Session> session_;
    GameView view_;
    platform::InputState input_;
    Menu menu_ = Menu::title, menu_before_settings_ = Menu::title;
    MenuText menu_text_;
    bool show_rows_ = false, quits_ = false, pad_start_before_ = false;
    std::string said_;  ///< over the picture for a while
    Stopwatch said_since_;
    std::vector<std::pair<std::string, std::string>> rows_;
    FrameLog frame_log_;
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
    SessionSettings settings = session_settings(purpose);
    if (saved != nullptr) {
        settings.start = saved->state;
        settings.start_version = saved->version;
    }
    FF_ASSIGN(session_, Session::begin(info_, *world_, settings));
    controls_.look_at(session_->game().yaw(), session_->game().pitch());
    return draw_before_play();
}

Status Player::draw_before_play() {
    drawer_->reset();
    session_->show(controls_, view_);
    return drawer_->draw(view_, settings_.width, settings_.height, {}, image_);
}

SessionSettings Player::session_settings(Purpose purpose) const {
    SessionSettings settings{.seed = options_.seed,
                             .pack_name = std::filesystem::absolute(options_.pack).string(),
                             .player_settings = to_text(settings_),
                             .recording = {},
                             .start = {},
                             .start_version = 0};
    if (options_.record && purpose == Purpose::play)
        settings.recording = new_recording_path(folder_ / "recordings", info_);
    return settings;
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
    if (menu == Menu::pause) {
        menu_text_.text = "F1 frame times   F2 comment in the recording";
        if (options_.write_picture) menu_text_.text += "   F12 picture";
    }
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
        case Choice::mark:
            session_->mark(screen_->comment());
            menu_ = Menu::none;
            break;
        case Choice::quit:
            quits_ = true;
            break;
    }
    return {};
}

void Player::say(std::string text) {
    log_info("{}", text);
    said_ = std::move(text);
    said_since_.restart();
}

void Player::take(const Change& change) {
    if (!change.error.empty()) say(change.error);
    if (change.shaders) {
        const Status status = make_shaders_anew();
        say(status ? "shaders compiled anew" : status.error().message);
    }
    if (change.pack.empty()) return;
    if (const Status status = take_world(change.pack); !status) say(status.error().message);
}

Status Player::make_shaders_anew() {
    FF_ASSIGN(nearfield::NearRenderer renderer, nearfield::NearRenderer::make(world_->scene()));
    drawer_.reset();  // borrows the renderer
    near_renderer_.emplace(std::move(renderer));
    drawer_.emplace(*world_, &*near_renderer_);
    return {};
}

Status Player::take_world(const std::filesystem::path& pack) {
    FF_ASSIGN(std::unique_ptr<scene::World> world, scene::load_world(pack));
    FF_ASSIGN(nearfield::NearRenderer renderer, nearfield::NearRenderer::make(world->scene()));
    const Purpose purpose = menu_ == Menu::title ? Purpose::show_behind_title : Purpose::play;
    SessionSettings settings = session_settings(purpose);
    settings.start = session_->game().save();
    settings.start_version = info_.save_version;
    std::string said = "the world was changed";
    auto session = Session::begin(info_, *world, settings);
    if (!session) {
        said += "; its things too, so it begins anew: " + session.error().message;
        settings.start.clear();
        session = Session::begin(info_, *world, settings);
    }
    if (!session) return session.error();
    end_session();
    drawer_.reset();
    near_renderer_.reset();
    sound_.reset();  // borrows the world's recordings
    has_tried_sound_ = false;
    world_ = std::move(world);
    near_renderer_.emplace(std::move(renderer));
    drawer_.emplace(*world_, &*near_renderer_);
    session_ = std::move(*session);
    if (settings.start.empty()) controls_.look_at(session_->game().yaw(), session_->game().pitch());
    say(std::move(said));
    return draw_before_play();
}

void Player::hear() {
    const scene::SoundSet& sounds = world_->info().sounds;
    if (sounds.clips.empty()) return;
    if (settings_.volume == 0.0) {
        sound_.reset();
        has_tried_sound_ = false;
        return;
    }
    if (!has_tried_sound_) {
        has_tried_sound_ = true;
        if (auto opened = sound::SoundPlayer::open(sounds))
            sound_.emplace(std::move(*opened));
        else
            log_info("played without sound: {}", opened.error().message);
    }
    if (!sound_) return;
    // Nothing sounds behind menus; what ended the game is heard out.
    if (menu_ != Menu::none && menu_ != Menu::end)
        sound_->silence();
    else
        sound_->update(view_.camera, view_.sounds, view_.sound_events, view_.time_s, float(settings_.volume));
}

void Player::take_picture() {
    const std::filesystem::path folder = folder_ / "pictures";
    std::filesystem::path path;
    for (int n = 1; path.empty() || std::filesystem::exists(path); ++n)
        path = folder / fmt::format("{}-{}.png", info_.name, n);
    std::error_code ignored;
    std::filesystem::create_directories(folder, ignored);
    if (const Status status = options_.write_picture(path, image_); !status)
        log_warning("{}", status.error().message);
    else
        log_info("{}", path.string());
}

frame::FrameSettings Player::frame_settings() const {
    frame::FrameSettings settings;
    settings.budget_ms = options_.budget_ms.value_or(settings_.budget_ms);
    if (settings.budget_ms == 0.0 && settings_.error_px > 0.0) {
        settings.reuse_while_moving = true;
        settings.max_parallax_px = float(settings_.error_px);
    }
    settings.hearing = {.has_device = sound_.has_value(), .voices = sound_ ? sound_->voices() : 0};
    return settings;
}

Status Player::draw() {
    const frame::FrameSettings frame_settings = this->frame_settings();
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
    hear();
    FF_TRY(draw());
    if (plays && session_->game().stage() != Stage::playing) open(Menu::end);
    if (menu_ == Menu::title) view_.hud.clear();
    if (!said_.empty() && said_since_.seconds() > kSaidSeconds) said_.clear();
    if (!said_.empty()) view_.hud.push_back({.at = {0.5f, 0.97f}, .size = 0.025f, .text = said_.substr(0, 160)});
    const Choice choice = screen_->draw(view_.hud, menu_, menu_text_, input_, settings_, rows_);
    window_->swap();
    FF_TRY(act(choice));
    if (input_.pressed(Key::f1)) show_rows_ = !show_rows_;
    if (plays && input_.pressed(Key::f2)) open(Menu::marker);
    if (plays && input_.pressed(Key::f12) && options_.write_picture) take_picture();
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
    FF_ASSIGN(nearfield::NearRenderer near_renderer, nearfield::NearRenderer::make(world_->scene()));
    near_renderer_.emplace(std::move(near_renderer));
    FF_ASSIGN(Screen screen, Screen::make(*window_));
    screen_.emplace(std::move(screen));
    drawer_.emplace(*world_, &*near_renderer_);
    FF_TRY(begin_session(options_.skip_title ? Purpose::play : Purpose::show_behind_title));
    open(options_.skip_title ? Menu::none : Menu::title);
    Stopwatch clock;
    bool played = false;  // the frame before, whose time is known at the next one's beginning
    while (!quits_ && window_->poll(input_)) {
        const double dt = clock.seconds();
        clock.restart();
        const platform::FramebufferSize size = window_->framebuffer_size();
        if (size.width < 16 || size.height < 16) continue;  // minimised
        if (played) frame_log_.add(1e3 * dt, drawer_->renderer().plan().view.width, settings_.width);
        played = menu_ == Menu::none;
        if (options_.changes)
            if (const auto change = options_.changes()) take(*change);
        FF_TRY(frame(dt));
    }
    end_session();
    if (frame_log_.frames() > 0) log_info("{}", frame_log_.to_text());
    return {};
}

}  // namespace

Status play(const GameInfo& info, const PlayOptions& options) {
    FF_ASSIGN(std::unique_ptr<scene::World> world, scene::load_world(options.pack));
    Player player(info, options, std::move(world));
    return player.run();
}

}  // namespace ff::host
