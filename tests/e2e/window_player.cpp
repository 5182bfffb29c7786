// Plays the sample game from its title to its end screen through the real window: window_player FF PACK FOLDER OUT
// SECONDS. Runs `FF play PACK` on the display of the environment and sends key and mouse events by xdotool. What the
// game knows it learns from outside: a session that is being recorded is played along, tick by tick, from its growing
// file, and the game's own auto player says what one would do there. Pictures of the stages go to OUT.

#include <fmt/format.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <thread>

#include "engine/host/game.h"
#include "engine/replay/recording.h"
#include "engine/scene/load_world.h"
#include "game/beacons/beacons_game.h"

namespace {

using namespace ff;
using Clock = std::chrono::steady_clock;

constexpr double kRadiansPx = 0.0022;  // of the game at mouse speed 1
constexpr double kTurnShare = 0.35;    // of what is missing, each round: what was sent before is still on its way
constexpr double kMostPx = 150.0;      // a round
constexpr double kRoundSeconds = 0.06;

void wait_seconds(double seconds) {
    std::this_thread::sleep_for(std::chrono::duration<double>(seconds));
}

std::string output_of(const std::string& command) {
    std::string text;
    if (FILE* pipe = popen(command.c_str(), "r")) {
        std::array<char, 256> buffer;
        while (std::fgets(buffer.data(), int(buffer.size()), pipe) != nullptr) text += buffer.data();
        pclose(pipe);
    }
    while (!text.empty() && text.back() == '\n') text.pop_back();
    return text;
}

/// Sends events to the window that has the focus.
class Hands {
  public:
    Hands() : pipe_(popen("exec xdotool -", "w")) {}
    ~Hands() {
        if (pipe_ != nullptr) pclose(pipe_);
    }
    void key(const char* name) { send(fmt::format("key {}", name)); }
    void hold(const char* name, bool& is_down, bool wanted) {
        if (is_down == wanted) return;
        is_down = wanted;
        send(fmt::format("{} {}", wanted ? "keydown" : "keyup", name));
    }
    void move(int dx, int dy) {
        if (dx != 0 || dy != 0) send(fmt::format("mousemove_relative -- {} {}", dx, dy));
    }

  private:
    void send(const std::string& line) {
        std::fprintf(pipe_, "%s\n", line.c_str());
        std::fflush(pipe_);
    }
    FILE* pipe_;
};

struct Player {
    std::filesystem::path folder, out;
    Hands hands;
    std::array<bool, 5> down{};
    int pictures = 0;

    void picture(const std::string& stage) {
        const std::string path = (out / fmt::format("{:02}-{}.png", pictures++, stage)).string();
        const std::string area = output_of("xdotool getdisplaygeometry | tr ' ' x");
        std::system(
            fmt::format("ffmpeg -y -loglevel error -f x11grab -video_size {} -i $DISPLAY -frames:v 1 {}", area, path)
                .c_str());
    }
    void follow(const loop::UserCommand& wish, const loop::UserCommand& now) {
        const double yaw = std::remainder(1e-6 * (wish.yaw_urad - now.yaw_urad), 2.0 * 3.14159265358979);
        const double pitch = 1e-6 * (wish.pitch_urad - now.pitch_urad);
        const auto pixels = [](double radians) {
            return int(std::lround(std::clamp(kTurnShare * radians / kRadiansPx, -kMostPx, kMostPx)));
        };
        hands.move(pixels(yaw), -pixels(pitch));
        // Where it does not look where it wants to go yet, it stands.
        const bool faces = std::abs(yaw) < 0.5;
        constexpr std::array kKeys{"w", "space", "Shift_L", "e", "f"};
        const std::array wanted{wish.move_ahead > 0 && faces, (wish.buttons & 1) != 0, (wish.buttons & 2) != 0 && faces,
                                (wish.buttons & 4) != 0, (wish.buttons & 8) != 0};
        for (std::size_t i = 0; i < kKeys.size(); ++i) hands.hold(kKeys[i], down[i], wanted[i]);
    }
    void release() { follow({}, {}); }
};

/// Until the session is won, lost or `seconds` are over. @return whether it was won
Result<bool> play_session(Player& player, const scene::World& world, double seconds) {
    const host::GameInfo& info = beacons::game_info();
    const std::filesystem::path path = player.folder / "recordings" / "beacons-1.ffreplay";
    for (int i = 0; i < 600 && !std::filesystem::exists(path); ++i) wait_seconds(0.1);
    wait_seconds(1.0);
    FF_ASSIGN(const replay::Recording begun, replay::load_recording(path));
    FF_ASSIGN(const std::unique_ptr<host::Game> game, info.begin(world, begun.header.seed));
    const auto advisor = info.winner(*game, begun.header.seed);
    const Clock::time_point end = Clock::now() + std::chrono::milliseconds(std::int64_t(1e3 * seconds));
    player.picture("begun");
    std::string lit;
    bool looked_through_glass = false;
    loop::UserCommand wish;
    while (Clock::now() < end) {
        FF_ASSIGN(const replay::Recording so_far, replay::load_recording(path));
        for (std::size_t t = game->ticks(); t < so_far.commands.size(); ++t) {
            wish = advisor->next();
            game->tick(so_far.commands[t]);
            if (game->stage() != host::Stage::playing) break;
        }
        if (game->stage() != host::Stage::playing) break;
        if (!so_far.commands.empty()) player.follow(wish, so_far.commands.back());
        const std::string status = game->status();
        const std::string now = status.substr(status.find("), ") + 3, status.find(" lit") - status.find("), "));
        if (now != lit) {
            if (!lit.empty()) player.picture("lit");
            lit = now;
            fmt::print(stderr, "{}\n", status);
        }
        if (player.down[4] && !looked_through_glass && game->ticks() % 240 > 120) {
            looked_through_glass = true;
            player.picture("spyglass");
        }
        wait_seconds(kRoundSeconds);
    }
    player.release();
    fmt::print(stderr, "{}\n", game->status());
    return game->stage() == host::Stage::won;
}

Result<bool> play(const std::string& pack, Player& player, double seconds) {
    FF_ASSIGN(const std::unique_ptr<scene::World> world, scene::load_world(pack));
    std::string window;
    for (int i = 0; i < 600 && window.empty(); ++i) {
        wait_seconds(0.1);
        window = output_of("xdotool search --onlyvisible --name Beacons 2>/dev/null | head -1");
    }
    if (window.empty()) return failure("the game's window did not appear");
    // Refused until it is mapped.
    for (int i = 0; i < 50 && std::system(("xdotool windowfocus " + window + " 2>/dev/null").c_str()) != 0; ++i)
        wait_seconds(0.1);
    wait_seconds(3.0);
    player.picture("title");
    player.hands.key("Return");
    FF_ASSIGN(const bool won, play_session(player, *world, seconds));
    wait_seconds(2.0);
    player.picture("end");
    // From the first entry of the end screen, up goes round to "Quit".
    player.hands.key("Up");
    wait_seconds(1.0);
    player.hands.key("Return");
    return won;
}

}  // namespace

int main(int argc, char** argv) {
    if (argc != 6) {
        fmt::print(stderr, "usage: window_player FF PACK FOLDER OUT SECONDS\n");
        return 2;
    }
    std::filesystem::create_directories(argv[4]);
    const pid_t game = fork();
    if (game == 0) {
        execl(argv[1], argv[1], "play", argv[2], "--folder", argv[3], nullptr);
        _exit(127);
    }
    Player player{.folder = argv[3], .out = argv[4], .hands = {}};
    const auto won = play(argv[2], player, std::atof(argv[5]));
    if (!won) fmt::print(stderr, "{}\n", won.error().message);
    int status = 0;
    for (int i = 0; i < 200 && waitpid(game, &status, WNOHANG) == 0; ++i) {
        if (i == 199 || !won) kill(game, SIGKILL);
        wait_seconds(0.1);
    }
    return won && *won && WIFEXITED(status) && WEXITSTATUS(status) == 0 ? 0 : 1;
}
