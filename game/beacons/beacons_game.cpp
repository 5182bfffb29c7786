#include "game/beacons/beacons_game.h"

#include <fmt/format.h>

#include "engine/host/first_person.h"
#include "game/beacons/rules.h"
#include "game/beacons/state.h"
#include "game/beacons/winner.h"

namespace ff::beacons {
namespace {

class BeaconsGame final : public host::Game {
  public:
    BeaconsGame(const scene::World& world, std::uint64_t seed) : state_(world, seed) {}

    Status begin() { return populate(state_); }

    void tick(const loop::UserCommand& command) override {
        if (state_.day().stage != host::Stage::playing) return;
        state_.command().now = command;
        state_.schedule.run(state_.registry);
        state_.command().buttons_before = command.buttons;
    }
    std::uint64_t ticks() const override { return const_cast<State&>(state_).day().tick; }
    replay::StateDigest digest() override { return digest_of(state_); }
    std::string describe(std::uint32_t index) const override {
        return index < state_.level.names.size() ? state_.level.names[index] : "no entity of the game";
    }
    void show(double fraction, host::GameView& out) override { show_state(state_, fraction, out); }
    host::Stage stage() const override { return const_cast<State&>(state_).day().stage; }
    std::string status() const override {
        const ecs::Registry& registry = state_.registry;
        int lit = 0, spotted = 0;
        for (const ecs::Entity entity : state_.level.beacons) {
            lit += registry.get<Beacon>(entity)->lit ? 1 : 0;
            spotted += registry.get<Beacon>(entity)->spotted ? 1 : 0;
        }
        const WorldPos& at = registry.get<ecs::LocalTransform>(state_.level.player)->position;
        return fmt::format("{:.1f} s: at ({:.1f}, {:.1f}, {:.1f}), {} beacons lit, {} spotted, of {}",
                           double(ticks()) * kTick, at.x, at.y, at.z, lit, spotted, state_.level.beacons.size());
    }
    std::string end_text() const override {
        const double minutes = double(ticks()) * kTick / 60.0;
        return stage() == host::Stage::won
                   ? fmt::format("All beacons burn. It took you {:.1f} minutes;\nthe valley sleeps safely tonight.",
                                 minutes)
                   : std::string(
                         "Night has fallen over a dark valley.\nClimb higher next time: from a height more can be "
                         "seen.");
    }
    double yaw() const override { return const_cast<State&>(state_).view().yaw_urad * 1e-6; }
    double pitch() const override { return const_cast<State&>(state_).view().pitch_urad * 1e-6; }
    std::vector<std::byte> save() const override { return save_state(const_cast<State&>(state_)); }
    Status load(std::span<const std::byte> bytes, std::uint32_t version) override {
        return load_state(state_, bytes, version);
    }

    [[nodiscard]] State& state() { return state_; }

  private:
    State state_;
};

/// How to walk, and what else can be done, in the order of Button.
std::vector<loop::Action> actions() {
    std::vector<loop::Action> all = host::walking_actions();
    all.push_back(host::action("jump", {"space", "pad a"}));
    all.push_back(host::action("run", {"left shift", "pad left thumb"}));
    all.push_back(host::action("use", {"e", "pad x"}));
    all.push_back(host::action("spyglass", {"mouse right", "f", "pad left bumper"}));
    return all;
}

}  // namespace

const host::GameInfo& game_info() {
    static const host::GameInfo info{
        .name = "beacons",
        .title = "Beacons",
        .intro =
            "The watch on the heights has gone home.\n"
            "Find the beacons with your spyglass, climb to them,\n"
            "and light them all before the last light is gone.",
        .save_version = kSaveVersion,
        .fov = kFov,
        .actions = actions(),
        .begin = [](const scene::World& world, std::uint64_t seed) -> Result<std::unique_ptr<host::Game>> {
            auto game = std::make_unique<BeaconsGame>(world, seed);
            FF_TRY(game->begin());
            return std::unique_ptr<host::Game>(std::move(game));
        },
        .winner = [](host::Game& game, std::uint64_t) { return make_winner(static_cast<BeaconsGame&>(game).state()); }};
    return info;
}

}  // namespace ff::beacons
