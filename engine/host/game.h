#pragma once
// What a game is to the engine: rules that a tick changes, a view that a frame shows. Its code uses the engine's public
// headers; window, menus, recordings and saved games are the host's.

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "engine/animation/dynamic_models.h"
#include "engine/core/result.h"
#include "engine/effects/effect.h"
#include "engine/loop/controls.h"
#include "engine/loop/user_command.h"
#include "engine/math/camera.h"
#include "engine/replay/state_hash.h"
#include "engine/scene/world.h"
#include "engine/sound/sound_source.h"

namespace ff::host {

/// Text or a bar over the picture. Places are shares of the picture: (0, 0) is its top left, (1, 1) its bottom right.
struct HudItem {
    enum class Kind : std::uint8_t { text, bar, line };
    Kind kind = Kind::text;
    Vec2 at{0.5f};                      ///< text: its middle; bar: its left end; line: from
    Vec2 to{0.0f};                      ///< line: to; bar: (width, height), width of it at value 1
    float value = 0.0f;                 ///< bar: [0, 1]
    float size = 0.03f;                 ///< text: height of a line; line: its width
    std::uint32_t color = 0xFFFFFFFFu;  ///< RGBA8, r in the low byte
    std::string text;
};

/// Where the sun stands, for games in which it moves; see scene::Environment for the rest.
struct SunPosition {
    double azimuth = 0.0;    ///< radians clockwise from north
    double elevation = 0.0;  ///< radians above the horizon

    friend bool operator==(const SunPosition&, const SunPosition&) = default;
};

/// What one frame shows. Kept from frame to frame: the game clears and fills the lists.
struct GameView {
    Camera camera;
    std::vector<scene::Instance> dynamic;
    std::vector<animation::ModelState> models;    ///< that move of themselves, in poses of now
    std::optional<SunPosition> sun;               ///< nothing: as the world has it
    std::vector<sound::Emitter> sounds;           ///< that sound on and on, beside the world's own
    std::vector<sound::SoundEvent> sound_events;  ///< of about the last second; each is played once
    effects::Simulations simulations;             ///< of the last tick; for the list of effects alone
    double time_s = 0.0;                          ///< since the session began: what weather and water move by
    std::vector<HudItem> hud;
    double turn_scale = 1.0;  ///< of looking around: below 1 through a spyglass
};

/// How far a session has come.
enum class Stage : std::uint8_t { playing, won, lost };

class Game {
  public:
    virtual ~Game() = default;

    /// One tick on. The only thing that changes the state, and a function of state and command alone: the same bits for
    /// any number of workers, with or without frames between.
    virtual void tick(const loop::UserCommand& command) = 0;
    [[nodiscard]] virtual std::uint64_t ticks() const = 0;
    /// Of everything that the next tick depends on.
    [[nodiscard]] virtual replay::StateDigest digest() = 0;
    /// What an entity is, for people: "boat 2".
    [[nodiscard]] virtual std::string describe(std::uint32_t entity_index) const = 0;

    /// What is seen.
    /// @param fraction  of the time from the last tick to the next, [0, 1)
    virtual void show(double fraction, GameView& out) = 0;

    [[nodiscard]] virtual Stage stage() const = 0;
    /// Where the session stands, in a line for logs and reports.
    [[nodiscard]] virtual std::string status() const = 0;
    /// A sentence or two for the end screen.
    [[nodiscard]] virtual std::string end_text() const = 0;
    /// Where the player looks, radians: at the beginning and after a load.
    [[nodiscard]] virtual double yaw() const = 0;
    [[nodiscard]] virtual double pitch() const = 0;

    /// Everything, so that load() goes on bit for bit.
    [[nodiscard]] virtual std::vector<std::byte> save() const = 0;
    /// Errors (bad input): not a state of this game and world; the game is as it was then.
    /// @param version  that wrote it, at most GameInfo::save_version
    virtual Status load(std::span<const std::byte> state, std::uint32_t version) = 0;
};

/// Plays by itself: for playtests and recordings of load. Sees the game, commands like a player.
class AutoPlayer {
  public:
    virtual ~AutoPlayer() = default;
    [[nodiscard]] virtual loop::UserCommand next() = 0;
};

/// A game as the host starts it.
struct GameInfo {
    std::string name;   ///< of files and folders: lower-case letters, digits, dashes
    std::string title;  ///< on the screen
    std::string intro;  ///< a few lines on the title screen
    std::uint32_t save_version = 1;
    double fov = radians_of(65.0);      ///< vertical, of GameView::camera where nothing is magnified
    std::vector<loop::Action> actions;  ///< the walking ones first; see loop::Controls
    /// Begins a session. Errors (bad input): the world lacks something that the game needs.
    std::function<Result<std::unique_ptr<Game>>(const scene::World& world, std::uint64_t seed)> begin;
    /// One that tries to win, for a game that begin() made; null: there is none.
    std::function<std::unique_ptr<AutoPlayer>(Game& game, std::uint64_t seed)> winner;
};

/// Ticks of every game a second.
inline constexpr int kTicksPerSecond = 120;

}  // namespace ff::host
