// @TITLE@: walk to the beacons and light them all. A component, a system, an event, and what the engine asks of a game.

#include <fmt/format.h>

#include <glm/geometric.hpp>

#include "engine/core/byte_stream.h"
#include "engine/core/log.h"
#include "engine/ecs/schedule.h"
#include "engine/host/first_person.h"
#include "engine/host/run_game.h"
#include "engine/host/shown_model.h"
#include "engine/physics/physics_world.h"

using namespace ff;

namespace {

constexpr double kFov = radians_of(65.0), kEyeHeight = 1.65, kReach = 4.0;  // radians, metres
constexpr float kWalk = 2.5f, kRun = 8.0f;                                  // metres a second
enum Button { kJump, kRunFast, kUse };                                      // in the order of the actions below

// Component: what an entity is.
struct Beacon {
    WorldPos at{0.0};
    bool lit = false;
};
// Event: a beacon begins to burn.
struct Lit {};
// Resource: what systems share.
struct Player {
    WorldPos feet{0.0};
    loop::UserCommand command;
};

// System: one step of every tick. It says what it touches, so that the engine can run systems side by side.
void light_beacons(ecs::SystemContext& context) {
    const Player& player = context.resource<const Player>();
    context.each<Beacon>([&](Beacon& beacon) {
        if (beacon.lit || !player.command.held(kUse) || glm::distance(player.feet, beacon.at) > kReach) return;
        beacon.lit = true;
        context.send(Lit{});
    });
}

class Game final : public host::Game {
  public:
    explicit Game(const scene::World& world) : world_(world), physics_(world.scene()) {
        schedule_.add("light", ecs::Access().write<Beacon>().read_resource<Player>().send<Lit>(), light_beacons);
    }

    Status begin() {
        FF_ASSIGN(walker_, physics_.add_character({.position = world_.info().spawn_position}));
        player_.feet = before_ = world_.info().spawn_position;
        player_.command.yaw_urad = std::int32_t(world_.info().spawn_yaw * 1e6);
        while (const scene::NamedPlace* place = world_.find_place(fmt::format("beacon.{}", beacons_.size() + 1)))
            beacons_.push_back(registry_.create(Beacon{place->position}));
        if (beacons_.empty()) return bad_input(world_.info().name + ": has no place called beacon.1");
        return {};
    }

    void tick(const loop::UserCommand& command) override {
        const bool runs = command.held(kRunFast);
        const auto input = host::walking_input(command, runs ? kRun : kWalk, command.held(kJump));
        if (const Status set = physics_.set_input(walker_, input); !set) log_warning("{}", set.error().message);
        physics_.step();
        before_ = player_.feet;
        player_ = {physics_.character(walker_).position, command};
        schedule_.run(registry_);
        registry_.swap_events();  // what was sent can be read now, until the next tick's end
        score_ += std::uint32_t(lit_.read().size());
        ++ticks_;
    }

    void show(double fraction, host::GameView& out) override {
        out.dynamic.clear();
        out.models.clear();
        out.hud.clear();
        out.time_s = (double(ticks_) + fraction) / host::kTicksPerSecond;
        out.camera = host::eyes_above(before_ + fraction * (player_.feet - before_), kEyeHeight, player_.command, kFov);
        const scene::NamedPlace* fire = world_.find_place("fire");
        for (const ecs::Entity entity : beacons_)
            if (const Beacon& beacon = *registry_.get<Beacon>(entity); beacon.lit && fire != nullptr)
                host::show_model(world_, host::model_of(*fire), beacon.at, host::turn_of(0.0), out.time_s, out);
        out.hud.push_back({.at = {0.5f, 0.05f}, .text = fmt::format("{} of {} burn", score_, beacons_.size())});
    }

    std::uint64_t ticks() const override { return ticks_; }
    host::Stage stage() const override { return score_ == beacons_.size() ? host::Stage::won : host::Stage::playing; }
    std::string status() const override { return fmt::format("{} of {} beacons burn", score_, beacons_.size()); }
    std::string end_text() const override { return "All beacons burn."; }
    std::string describe(std::uint32_t entity) const override { return fmt::format("beacon {}", entity + 1); }
    double yaw() const override { return player_.command.yaw_urad * 1e-6; }
    double pitch() const override { return player_.command.pitch_urad * 1e-6; }

    // A replay compares this every tick: everything that the next tick depends on.
    replay::StateDigest digest() override {
        replay::StateHash hash;
        visit(*this, [&](auto& value) { hash.add(value); });
        hash.add(physics_.hash());
        return hash.digest();
    }
    std::vector<std::byte> save() const override {
        std::vector<std::byte> bytes;
        ByteWriter out(bytes);
        visit(*this, [&](auto& value) { out.value(value); });
        out.raw(physics_.state());
        return bytes;
    }
    Status load(std::span<const std::byte> bytes, std::uint32_t) override {
        const std::size_t own = save().size() - physics_.state().size();
        if (bytes.size() < own) return bad_input("a saved game that ends too early");
        FF_TRY(physics_.set_state(bytes.subspan(own)));
        ByteReader in(bytes);
        visit(*this, [&](auto& value) { in.value(value); });
        player_.feet = before_ = physics_.character(walker_).position;
        return {};
    }

  private:
    /// Every number of the state, in one order for saving, loading and comparing.
    template <class Self, class Visit>
    static void visit(Self& self, Visit&& visit) {
        visit(self.ticks_);
        visit(self.score_);
        visit(self.player_.command.yaw_urad);
        visit(self.player_.command.pitch_urad);
        for (const ecs::Entity entity : self.beacons_) visit(self.registry_.template get<Beacon>(entity)->lit);
    }

    const scene::World& world_;
    ecs::Registry registry_;
    Player& player_ = registry_.resource<Player>();
    ecs::EventQueue<Lit>& lit_ = registry_.events<Lit>();
    ecs::Schedule schedule_;
    physics::PhysicsWorld physics_;
    physics::CharacterId walker_;
    std::vector<ecs::Entity> beacons_;
    WorldPos before_{0.0};  ///< where the player was a tick ago: frames show what lies between
    std::uint32_t score_ = 0;
    std::uint64_t ticks_ = 0;
};

host::GameInfo game_info() {
    host::GameInfo info{
        .name = "@NAME@", .title = "@TITLE@", .intro = "Light the beacons: walk up to them and press E."};
    info.fov = kFov;
    info.actions = host::walking_actions();
    info.actions.push_back(host::action("jump", {"space", "pad a"}));
    info.actions.push_back(host::action("run", {"left shift", "pad left thumb"}));
    info.actions.push_back(host::action("use", {"e", "pad x"}));
    info.begin = [](const scene::World& world, std::uint64_t) -> Result<std::unique_ptr<host::Game>> {
        auto game = std::make_unique<Game>(world);
        FF_TRY(game->begin());
        return std::unique_ptr<host::Game>(std::move(game));
    };
    return info;
}

}  // namespace

int main(int argc, char** argv) {
    return host::run_game(game_info(), argc, argv);
}
