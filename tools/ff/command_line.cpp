#include <cstdio>

#include "engine/core/heap_count.h"
#include "engine/core/jobs.h"
#include "engine/core/log.h"
#include "tools/ff/command_options.h"
#include "tools/ff/describe_command_line.h"
#include "tools/ff/heap_counter.h"
#include "tools/ff/modes.h"
#include "tools/ff/playtest_options.h"

namespace ff::tool {
namespace {

const std::map<std::string, host::AutoPlayerKind> kAutoPlayers{{"random", host::AutoPlayerKind::random},
                                                               {"winner", host::AutoPlayerKind::winner}};

}  // namespace

int run(int argc, const char* const* argv) {
    set_heap_counter(heap_allocations);
    CLI::App app{"Farfield: cook a world, walk through it, draw to the horizon."};
    app.name("ff");
    app.require_subcommand(1);
    app.set_version_flag("--version", "ff " FF_VERSION);

    CookOptions cook;
    auto* cook_app = app.add_subcommand("cook", "Cook a scene.toml, .gltf or .glb into a pack");
    cook_app->add_option("SOURCE", cook.source, "scene.toml, .gltf or .glb")->required();
    cook_app->add_option("-o,--output", cook.output, "The pack to write, NAME.ffpack")->required();
    cook_app->add_option("--scale", cook.scale, "Make about N times the triangles of the source")
        ->check(CLI::Range(1, 1000));
    cook_app->add_option("--jobs", cook.jobs, "Worker threads; 0: as many as the machine has")
        ->check(CLI::Range(0, 1024));
    cook_app->add_option("--cache", cook.cache_dir, "Folder of the cook cache; default: the user's cache folder");
    cook_app->add_flag("--json", cook.json, "Print the report as one JSON object on stdout");

    InfoOptions info;
    auto* info_app = app.add_subcommand("info", "Say what a pack holds");
    info_app->add_option("PACK", info.pack, "A .ffpack, or a source")->required();
    info_app->add_flag("--json", info.json, "Print one JSON object on stdout");

    RenderOptions render;
    auto* render_app = app.add_subcommand("render", "Draw one frame of a walkthrough into an image");
    add_view_options(*render_app, render.view, true);
    render_app->add_option("--frame", render.frame, "Frame of the walkthrough, from 0")->check(CLI::Range(0, 1000000));
    render_app
        ->add_option("--debug", render.debug_view,
                     "Draw a debug view instead: sources, age, light, border, causes or work")
        ->check(CLI::IsMember({"sources", "age", "light", "border", "causes", "work"}));
    render_app->add_option("-o,--output", render.output, "Image to write (.png, .exr, .jpg ...)")->required();

    WalkOptions walk;
    bool window = false, headless = false;
    auto* walk_app = app.add_subcommand("walk", "Walk through a world, in a window or headless into files");
    add_view_options(*walk_app, walk.view, true);
    walk_app->add_option("--out", walk.out, "Folder for frames, video and stats.json")->capture_default_str();
    walk_app->add_flag("--video", walk.video, "Also write a video (needs ffmpeg)");
    walk_app->add_option("--trace", walk.trace, "Write a trace of all frames (ui.perfetto.dev, chrome://tracing)");
    walk_app->add_option("--every", walk.every, "Write every N-th frame as PNG; default: eight over the walk")
        ->check(CLI::Range(0, 1000000));
    auto* window_flag = walk_app->add_flag("--window", window, "Open a window, or fail");
    walk_app->add_flag("--headless", headless, "Do not open a window")->excludes(window_flag);

    BenchOptions bench;
    bench.modes = {"hybrid", "raster", "raycast", "near"};
    auto* bench_app = app.add_subcommand("bench", "Time the modes lap by lap and print one JSON object");
    add_view_options(*bench_app, bench.view, false);
    bench_app
        ->add_option("--modes", bench.modes,
                     "Modes to compare: hybrid,raster,raycast,near,beam,beam-reuse,orsa,reproject,irsa")
        ->delimiter(',')
        ->check(CLI::IsMember(mode_names()));
    bench_app->add_option("--laps", bench.laps, "Laps of each mode")->check(CLI::Range(1, 1000))->capture_default_str();
    bench_app->add_option("--frames", bench.max_frames, "Only the first N frames of the walk; 0: all")
        ->check(CLI::Range(0, 1000000));
    bench_app->add_flag("--each-frame", bench.each_frame,
                        "Report every frame, too, and pictures of the slowest: input of ff report");
    bench_app->add_option("--trace", bench.trace, "Write a trace of the last lap (ui.perfetto.dev, chrome://tracing)");

    BudgetOptions budget;
    auto* budget_app = app.add_subcommand("budget", "Hold a walk to limits of time and work, or make them");
    add_budget_options(*budget_app, budget);

    CompareOptions compare;
    auto* compare_app =
        app.add_subcommand("compare", "Replay a session on two packs: frame times and images side by side");
    add_compare_options(*compare_app, compare);

    ReportOptions report;
    auto* report_app = app.add_subcommand("report", "Make one HTML page of benches, budgets, replays and comparisons");
    add_report_options(*report_app, report);

    StatsOptions stats;
    auto* stats_app = app.add_subcommand("stats", "Say which effects a walk calls for, why, and what they cost");
    add_view_options(*stats_app, stats.view, true);
    stats_app->add_option("--frames", stats.max_frames, "Only the first N frames of the walk; 0: all")
        ->check(CLI::Range(0, 1000000));
    stats_app
        ->add_option("--compare", stats.compare_laps,
                     "Laps in which frames are drawn with and without each effect that is called for; 0: none")
        ->check(CLI::Range(0, 1000));
    stats_app->add_option("--pictures", stats.pictures,
                          "Folder for the picture that each effect changes most, with and without it");
    stats_app->add_option("--table", stats.table,
                          "Folder for effects.md: every effect's cost, and its picture with and without it");
    stats_app->add_flag("--json", stats.json, "Print one JSON object on stdout");

    HardcasesOptions hardcases;
    auto* hardcases_app = app.add_subcommand("hardcases", "Run the hard cases against their oracles and print a table");
    hardcases_app->add_option("--case", hardcases.name, "Only this case, or those of a group: its name up to the dot");
    hardcases_app->add_option("--instances", hardcases.instances, "Instances of each case; 0: those of a full run");
    hardcases_app->add_option("--seed", hardcases.seed, "Seed of the random instances")->capture_default_str();
    hardcases_app->add_flag("--json", hardcases.json, "Print one JSON object on stdout");

    AccuracyOptions accuracy;
    auto* accuracy_app = app.add_subcommand(
        "accuracy", "Measure what each approximation costs in time and in error, as a page and JSON");
    add_scene_options(*accuracy_app, accuracy.view);
    accuracy_app->add_option("--out", accuracy.out, "Folder for accuracy.html, accuracy.json and pictures")
        ->capture_default_str();
    accuracy_app->add_flag("--quick", accuracy.quick,
                           "Few frames and pairs of knobs: minutes instead of a quarter of an hour");

    PlayOptions play;
    auto* play_app = app.add_subcommand(
        "play", "Play the sample game in a world; a source is cooked, and anew when its files change");
    play_app->add_option("PACK", play.pack, "A .ffpack, or a source")->required();
    play_app->add_option("--folder", play.folder, "Folder of settings, saved games and recordings");
    play_app->add_option("--budget-ms", play.budget_ms, "Instead of the player's own")->check(number_in(0.0, 1e5));
    play_app->add_option("--seed", play.seed, "Of what is left to chance")->capture_default_str();
    play_app->add_flag("--no-record{false}", play.record, "Do not record the session");
    play_app->add_flag("--skip-title", play.skip_title, "Begin at once");
    play_app
        ->add_option("--player", play.player,
                     "Without a window, as fast as it goes: random does anything, winner tries to win")
        ->transform(CLI::CheckedTransformer(kAutoPlayers, CLI::ignore_case).description(""));
    play_app->add_option("--minutes", play.minutes, "Of game time at most, for --player")->check(number_in(0.0, 1e4));
    play_app
        ->add_option("--shaders", play.shaders, "Folder of GLSL files to use and watch instead of the built-in ones")
        ->check(CLI::ExistingDirectory);
    play_app->add_option("--recording", play.recording, "File to record into, for --player");

    ReplayOptions replay;
    auto* replay_app = app.add_subcommand("replay", "Play a recorded session again");
    replay_app->add_option("RECORDING", replay.recording, "A .ffreplay")->required();
    replay_app->add_option("--pack", replay.pack, "The world; default: the one that it was recorded in");
    replay_app->add_option("--until", replay.until, "Stop after this tick");
    replay_app->add_flag("--verify", replay.verify,
                         "Compare every tick with what was recorded; exit code 4 where it differs");
    replay_app->add_flag("--bench", replay.bench,
                         "Draw it, 30 frames a second of game time, and say how long frames took");
    replay_app->add_flag("--each-frame", replay.each_frame,
                         "With --bench: report every frame, too, and pictures of the slowest: input of ff report");
    replay_app->add_option("--trace", replay.trace,
                           "With --bench: write a trace of all frames (ui.perfetto.dev, chrome://tracing)");
    replay_app->add_option("--video", replay.video, "Draw it into a video (needs ffmpeg)");
    replay_app->add_option("--picture", replay.picture, "Draw the last frame into an image");
    replay_app->add_flag("--json", replay.json, "Print one JSON object on stdout");
    replay_app->add_option("--budget-ms", replay.budget_ms, "Of drawn frames; 0: exact frames")
        ->check(number_in(0.0, 1e5));
    add_size_and_threads(*replay_app, replay.size, replay.threads);

    NewOptions new_game;
    auto* new_app = app.add_subcommand("new", "Make a new game from the template");
    new_app->add_option("DIR", new_game.folder, "Folder to make; it must not be there, or be empty")->required();
    new_app->add_option("--name", new_game.name,
                        "Of program and package: lower-case letters, digits, dashes; default: the folder's");

    PackageOptions package;
    auto* package_app = app.add_subcommand("package", "Build a game and make a .deb and a .tar.gz of it");
    package_app->add_option("GAME_DIR", package.game, "Folder of the game, with its CMakeLists.txt")->required();
    package_app->add_option("-o,--output", package.output, "Folder for the packages")->required();
    package_app->add_option("--jobs", package.jobs, "Compilers at a time; 0: as many as the machine has")
        ->check(CLI::Range(0, 1024));

    auto* man_app = app.add_subcommand("man", "Print ff's manual page");
    std::string shell;
    auto* completion_app = app.add_subcommand("completion", "Print completion for a shell");
    completion_app->add_option("SHELL", shell, "bash or zsh")->required()->check(CLI::IsMember({"bash", "zsh"}));

    try {
        app.parse(argc, argv);
    } catch (const CLI::ParseError& error) {
        const int code = app.exit(error);
        return code == 0 ? 0 : static_cast<int>(ErrorKind::usage);
    }
    if (window) walk.target = WalkTarget::window;
    if (headless) walk.target = WalkTarget::headless;

    Status status;
    const auto with_workers = [](int workers, auto&& body) {
        const WorkerLimit limit(workers);
        return body();
    };
    if (*cook_app) status = with_workers(cook.jobs, [&] { return run_cook(cook); });
    if (*info_app) status = run_info(info);
    if (*render_app) status = with_workers(render.view.threads, [&] { return run_render(render); });
    if (*walk_app) status = with_workers(walk.view.threads, [&] { return run_walk(walk); });
    if (*bench_app) status = with_workers(bench.view.threads, [&] { return run_bench(bench); });
    if (*budget_app) status = with_workers(budget.view.threads, [&] { return run_budget(budget); });
    if (*compare_app) status = with_workers(compare.threads, [&] { return run_compare(compare); });
    if (*report_app) status = run_report(report);
    if (*play_app) status = run_play(play);
    if (*replay_app) status = with_workers(replay.threads, [&] { return run_replay(replay); });
    if (*stats_app) status = with_workers(stats.view.threads, [&] { return run_stats(stats); });
    if (*hardcases_app) status = run_hardcases(hardcases);
    if (*new_app) status = run_new(new_game);
    if (*package_app) status = run_package(package);
    if (*man_app) std::fputs(manual_page(app).c_str(), stdout);
    if (*completion_app) std::fputs((shell == "bash" ? bash_completion(app) : zsh_completion(app)).c_str(), stdout);
    if (*accuracy_app) status = with_workers(accuracy.view.threads, [&] { return run_accuracy(accuracy); });
    if (status) return 0;
    log_line("ff: error: ", status.error().message);
    return static_cast<int>(status.error().kind);
}

}  // namespace ff::tool
