#include "engine/host/run_game.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <map>
#include <optional>
#include <span>
#include <string_view>

#include "engine/core/log.h"
#include "engine/core/program_files.h"
#include "engine/host/play.h"
#include "engine/host/play_alone.h"
#include "engine/host/replay_session.h"
#include "engine/replay/recording.h"
#include "engine/scene/load_world.h"

namespace ff::host {
namespace {

/// An option of the command line; those without a value are flags.
struct Option {
    const char* name;
    const char* value;
    const char* help;
};
constexpr Option kOptions[] = {
    {"--pack", "FILE", "play in this world (.ffpack) instead of the game's own"},
    {"--folder", "DIR", "folder of settings, saved games and recordings"},
    {"--seed", "N", "of what is left to chance (1)"},
    {"--budget-ms", "MS", "time of a frame, instead of the player's setting; 0: exact frames"},
    {"--skip-title", nullptr, "begin at once"},
    {"--no-record", nullptr, "do not record the session"},
    {"--player", "random|winner", "without a window, played by a program, as fast as it goes"},
    {"--minutes", "M", "of game time at most, with --player (20)"},
    {"--recording", "FILE", "file to record into, with --player"},
    {"--draw", nullptr, "draw what --player does, unseen, and say how long it takes"},
    {"--verify", "RECORDING", "play a recording again and compare every tick; exit code 4 where one differs"},
    {"--version", nullptr, "print the engine's version"},
    {"--help", nullptr, "print this"},
};

/// What was given, by the option's name; flags hold an empty text.
using Given = std::map<std::string_view, std::string_view>;

Result<Given> read_options(std::span<const char* const> arguments) {
    Given given;
    for (std::size_t i = 0; i < arguments.size(); ++i) {
        const std::string_view name = arguments[i];
        const auto* const option =
            std::find_if(std::begin(kOptions), std::end(kOptions), [&](const Option& o) { return o.name == name; });
        if (option == std::end(kOptions))
            return usage_error(fmt::format("there is no option '{}'; --help lists them", name));
        if (option->value == nullptr) {
            given[option->name] = {};
        } else {
            if (i + 1 == arguments.size()) return usage_error(fmt::format("{} needs {}", name, option->value));
            given[option->name] = arguments[++i];
        }
    }
    return given;
}

/// @param out  keeps its value where the option was not given
template <class Number>
Status read_number(const Given& given, const char* name, Number low, Number high, Number& out) {
    const auto found = given.find(name);
    if (found == given.end()) return {};
    const std::string_view text = found->second;
    Number value{};
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc() || end != text.data() + text.size() || !(value >= low && value <= high))
        return usage_error(fmt::format("{} {}: expected a number from {} to {}", name, text, low, high));
    out = value;
    return {};
}

void print_help(const GameInfo& info, std::string_view program) {
    std::printf("%s\n\nusage: %.*s [OPTION ...]\n\n", info.title.c_str(), int(program.size()), program.data());
    for (const Option& option : kOptions)
        std::printf("  %-24s %s\n",
                    fmt::format("{} {}", option.name, option.value != nullptr ? option.value : "").c_str(),
                    option.help);
}

Status verify(const GameInfo& info, const std::filesystem::path& pack, const std::filesystem::path& file) {
    FF_ASSIGN(const replay::Recording recording, replay::load_recording(file));
    FF_ASSIGN(const std::unique_ptr<scene::World> world, scene::load_world(pack));
    auto session = ReplaySession::begin(info, *world, recording);
    if (!session) return bad_input(fmt::format("{}: {}", file.string(), session.error().message));
    while (!session->divergence() && session->step()) {
    }
    if (session->divergence())
        return Error{ErrorKind::limit, fmt::format("{}: {}", file.string(), to_text(*session->divergence()))};
    log_info("{}: {} ticks, every one as recorded", file.string(), session->tick());
    return {};
}

Result<std::filesystem::path> own_world() {
    FF_ASSIGN(const std::filesystem::path program, program_path());
    FF_ASSIGN(const std::filesystem::path shared, shared_files());
    return shared / program.filename() / "world.ffpack";
}

Status run(const GameInfo& info, const Given& given) {
    const auto text = [&](const char* name) {
        const auto found = given.find(name);
        return std::string(found != given.end() ? found->second : std::string_view());
    };
    std::filesystem::path pack = text("--pack");
    if (pack.empty()) {
        FF_ASSIGN(pack, own_world());
    }
    if (given.contains("--verify")) return verify(info, pack, text("--verify"));

    std::uint64_t seed = 1;
    FF_TRY(read_number<std::uint64_t>(given, "--seed", 0, UINT64_MAX, seed));
    if (given.contains("--player")) {
        const std::string player = text("--player");
        if (player != "random" && player != "winner")
            return usage_error(fmt::format("--player {}: expected random or winner", player));
        double minutes = 20.0;
        FF_TRY(read_number(given, "--minutes", 0.0, 1e4, minutes));
        return play_alone(info, {.pack = pack,
                                 .folder = text("--folder"),
                                 .player = player == "winner" ? AutoPlayerKind::winner : AutoPlayerKind::random,
                                 .seed = seed,
                                 .ticks = std::uint64_t(std::llround(minutes * 60.0 * kTicksPerSecond)),
                                 .record = !given.contains("--no-record"),
                                 .recording = text("--recording"),
                                 .draw = given.contains("--draw")});
    }
    double budget_ms = 0.0;
    FF_TRY(read_number(given, "--budget-ms", 0.0, 1e5, budget_ms));
    return play(info, {.pack = pack,
                       .folder = text("--folder"),
                       .seed = seed,
                       .budget_ms = given.contains("--budget-ms") ? std::optional(budget_ms) : std::nullopt,
                       .record = !given.contains("--no-record"),
                       .skip_title = given.contains("--skip-title")});
}

}  // namespace

int run_game(const GameInfo& info, int argc, const char* const* argv) {
    const std::filesystem::path program(argc > 0 ? argv[0] : info.name.c_str());
    const std::string name = program.filename().string();
    const std::span<const char* const> arguments(argv, std::size_t(std::max(argc, 0)));
    const auto given = read_options(arguments.subspan(std::min<std::size_t>(1, arguments.size())));
    Status status = given ? Status() : Status(given.error());
    if (given && given->contains("--help")) {
        print_help(info, name);
    } else if (given && given->contains("--version")) {
        std::printf("%s, Farfield %s\n", info.title.c_str(), FF_VERSION);
    } else if (given) {
        status = run(info, *given);
    }
    if (status) return 0;
    log_line(name + ": error: ", status.error().message);
    return int(status.error().kind);
}

}  // namespace ff::host
