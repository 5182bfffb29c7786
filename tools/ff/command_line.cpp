#include <CLI/CLI.hpp>
#include <cmath>
#include <cstdio>
#include <cstdlib>

#include "engine/core/heap_count.h"
#include "engine/core/jobs.h"
#include "engine/core/log.h"
#include "engine/effects/registry.h"
#include "tools/ff/commands.h"
#include "tools/ff/describe_command_line.h"
#include "tools/ff/heap_counter.h"
#include "tools/ff/modes.h"

namespace ff::tool {
namespace {

const std::map<std::string, budget::WhenLate> kWhenLate{{"coarser", budget::WhenLate::coarser},
                                                        {"stale", budget::WhenLate::stale}};
const std::map<std::string, frame::CasterKind> kCasters{
    {"beam", frame::CasterKind::beam}, {"embree", frame::CasterKind::embree}, {"grid", frame::CasterKind::grid}};
const std::map<std::string, frame::OpacityKind> kOpacityKinds{{"auto", frame::OpacityKind::automatic},
                                                              {"software", frame::OpacityKind::software},
                                                              {"readback", frame::OpacityKind::readback}};

const std::map<std::string, frame::SunShadows> kSunShadows{
    {"scene", frame::SunShadows::by_scene}, {"off", frame::SunShadows::off}, {"on", frame::SunShadows::on}};

const std::map<std::string, host::AutoPlayerKind> kAutoPlayers{{"random", host::AutoPlayerKind::random},
                                                               {"winner", host::AutoPlayerKind::winner}};

/// WIDTHxHEIGHT, both in [16, 8192].
std::string parse_size(const std::string& text, ImageSize& size) {
    int width = 0, height = 0;
    char rest = 0;
    if (std::sscanf(text.c_str(), "%dx%d%c", &width, &height, &rest) != 2 || width < 16 || width > 8192 ||
        height < 16 || height > 8192)
        return "--size: '" + text + "' is not WIDTHxHEIGHT with both from 16 to 8192, as 640x480";
    size = {width, height};
    return {};
}

/// CLI::Range lets not-a-number pass, which is neither below nor above.
CLI::Validator number_in(double low, double high) {
    return CLI::Range(low, high) & CLI::Validator(
                                       [](const std::string& text) {
                                           return std::isnan(std::strtod(text.c_str(), nullptr))
                                                      ? "'" + text + "' is not a number"
                                                      : std::string();
                                       },
                                       "");
}

/// A check of mode reproject, or another part of it, by the name that --reproject-without takes.
void switch_off(const std::string& part, farfield::ReprojectSettings& settings) {
    if (part == "frustum") settings.check_view_frustum = false;
    if (part == "occlusion") settings.check_occlusion = false;
    if (part == "resampling") settings.resample_period = 0;
    if (part == "abrupt") settings.check_abrupt = false;
    if (part == "background") settings.use_background = false;
    if (part == "vote") settings.vote = farfield::Vote::any;
}

const std::map<std::string, farfield::Vote> kVotes{
    {"surface", farfield::Vote::surface}, {"primitive", farfield::Vote::primitive}, {"any", farfield::Vote::any}};

void add_reproject_options(CLI::App& app, frame::FrameSettings& settings) {
    app.add_option_function<std::vector<std::string>>(
           "--reproject-without",
           [&settings](const std::vector<std::string>& parts) {
               for (const std::string& part : parts) switch_off(part, settings.reproject);
           },
           "Mode reproject without some of its checks: frustum,occlusion,resampling,abrupt,background,vote")
        ->delimiter(',')
        ->check(CLI::IsMember({"frustum", "occlusion", "resampling", "abrupt", "background", "vote"}));
    app.add_flag("--reproject-shift", settings.reproject.shift_origin,
                 "Rays of pixels that fail begin where points landed around them (P3 5.3)");
    app.add_option("--reproject-count", settings.reproject.min_count,
                   "Points around a pixel that must vote for its hit (P3's m_cnt)")
        ->check(CLI::Range(0, 9));
    app.add_option("--reproject-vote", settings.reproject.vote,
                   "Whose points vote: those on the hit's surface, on its primitive, or any")
        ->transform(CLI::CheckedTransformer(kVotes, CLI::ignore_case).description(""));
    app.add_option("--reproject-surface", settings.reproject.surface_share,
                   "Depths within this share of each other are one surface")
        ->check(CLI::Range(0.0, 1.0));
    app.add_option("--reproject-period", settings.reproject.resample_period,
                   "Frames in which each pixel is cast at least once; 0: never")
        ->check(CLI::Range(0, 64));
    app.add_option("--reproject-block", settings.reproject.resample_block_px,
                   "Pixels that are cast for it lie in blocks of this side")
        ->check(CLI::IsMember({1, 2, 4, 8, 16, 32}));
    app.add_option("--reproject-caster", settings.reproject_caster,
                   "Who casts the tiles that mode reproject leaves: beam, embree or grid; single pixels go to Embree")
        ->transform(CLI::CheckedTransformer(kCasters, CLI::ignore_case).description(""));
}

void add_size_and_threads(CLI::App& app, ImageSize& size, int& threads) {
    app.add_option_function<std::string>(
        "--size",
        [&size](const std::string& text) {
            if (const std::string error = parse_size(text, size); !error.empty()) throw CLI::ValidationError(error);
        },
        "Image size in pixels, WIDTHxHEIGHT (640x480)");
    app.add_option("--threads", threads, "Worker threads; 0: as many as the machine has")->check(CLI::Range(0, 1024));
}

std::string effect_names() {
    std::string names;
    for (const effects::Effect& effect : effects::registry())
        names += (names.empty() ? "" : ", ") + std::string(effect.name);
    return names;
}

/// What is drawn, how large and by how many threads.
void add_scene_options(CLI::App& app, ViewOptions& view) {
    app.add_option("PACK", view.pack, "A .ffpack; or a scene.toml, .gltf or .glb, which is cooked into the cache first")
        ->required();
    app.add_option("--walk", view.walk, "Walkthrough: a name that the pack has, or a .walk.json file")
        ->capture_default_str();
    add_size_and_threads(app, view.size, view.threads);
}

void add_view_options(CLI::App& app, ViewOptions& view, bool with_mode) {
    add_scene_options(app, view);
    auto& settings = view.frame;
    if (with_mode)
        app.add_option(
               "--mode", settings.mode,
               "How frames are drawn: hybrid, raster, raycast (= orsa), near, beam, beam-reuse, reproject or irsa")
            ->transform(CLI::CheckedTransformer(mode_names(), CLI::ignore_case).description(""));
    app.add_option("--budget-ms", settings.budget_ms,
                   "Keep frames within this time by giving up accuracy; 0: exact frames")
        ->check(number_in(0.0, 1e5));
    app.add_option(
           "--when-late", settings.when_late,
           "What gives where the budget is short: coarser (the picture is drawn smaller) or stale (old texels of "
           "the panorama stay)")
        ->transform(CLI::CheckedTransformer(kWhenLate, CLI::ignore_case).description(""));
    app.add_option("--caster", settings.caster, "Who answers what is left over in hybrid: beam, embree or grid")
        ->transform(CLI::CheckedTransformer(kCasters, CLI::ignore_case).description(""));
    app.add_option("--near-m", settings.fixed_near_m,
                   "Near distance in metres instead of the controller's choice; 0: no near field")
        ->check(number_in(0.0, 1e6));
    app.add_option("--max-parallax-px", settings.max_parallax_px,
                   "A panorama texel is reused up to this predicted parallax")
        ->check(number_in(0.0, 16.0));
    app.add_option("--prelit-beyond-m", settings.prelit_beyond_m, "Beyond this depth triangles have one prelit colour")
        ->check(number_in(0.0, 1e9));
    app.add_option("--blend-within-m", settings.blend_within_m,
                   "Blended surfaces nearer than this are sorted per pixel, farther ones shown by coverage; 0: all")
        ->check(number_in(0.0, 1e6));
    app.add_option("--opacity", settings.opacity, "Opacity buffer: auto, software or readback")
        ->transform(CLI::CheckedTransformer(kOpacityKinds, CLI::ignore_case).description(""));
    app.add_option("--sun-shadows", settings.sun_shadows, "Sun shadows: scene (as its [sun] says), off or on")
        ->transform(CLI::CheckedTransformer(kSunShadows, CLI::ignore_case).description(""));
    app.add_option_function<std::vector<std::string>>(
           "--without",
           [&settings](const std::vector<std::string>& names) {
               for (const std::string& name : names)
                   settings.without_effects |= effects::set_of(effects::find_effect(name)->id);
           },
           "Effects that are off, whatever calls for them: " + effect_names())
        ->delimiter(',')
        ->check([](const std::string& name) {
            return effects::find_effect(name) != nullptr ? std::string()
                                                         : "no effect '" + name + "'; there are " + effect_names();
        });
    const auto add_sun = [&](const char* name, std::optional<std::array<double, 2>>& sun_deg, const char* about) {
        return app
            .add_option_function<std::vector<double>>(
                name,
                [&sun_deg](const std::vector<double>& angles) {
                    sun_deg = {angles[0], angles[1]};
                },
                about)
            ->delimiter(',')
            ->expected(2)
            ->check(number_in(-360.0, 360.0));
    };
    auto* sun =
        add_sun("--sun", view.sun_deg, "Azimuth and elevation of the sun in degrees, instead of the scene's: 215,12");
    add_sun("--sun-to", view.sun_to_deg, "Where --sun has moved by the end of the walk")->needs(sun);
    const auto add_weather = [&](const char* name, float scene::Weather::*what, const char* about) {
        app.add_option_function<double>(
               name,
               [&settings, what](double strength) {
                   if (!settings.weather) settings.weather.emplace();
                   (*settings.weather).*what = float(strength);
               },
               about)
            ->check(number_in(0.0, 1.0));
    };
    add_weather("--rain", &scene::Weather::rain, "Rain instead of the scene's weather, 0 to 1");
    add_weather("--snow", &scene::Weather::snow, "Snow instead of the scene's weather, 0 to 1");
    app.add_option("--lamps-within-m", settings.lamps_within_m, "Lamps farther away light nothing; 0: none does")
        ->check(number_in(0.0, 1e5));
    app.add_option("--reflection-rays", settings.reflection_rays,
                   "Rays a frame, about, for what water and glass mirror; 0: they mirror the sky alone")
        ->check(CLI::Range(0, 100000000));
    app.add_flag("--no-sun-reuse{false}", settings.reuse_sun,
                 "Cast a ray towards the sun from every pixel in every frame");
    app.add_option("--sun-refresh", settings.sun_refresh_frames,
                   "Frames in which reused light is looked at anew at least once; 0: never")
        ->check(CLI::Range(0, 255));
    add_reproject_options(app, settings);
    app.add_flag("--no-panorama{false}", settings.use_panorama, "Never reuse the panoramic cache");
    app.add_flag("--no-occlusion{false}", view.use_occlusion, "Draw near instances that others hide, too");
    app.add_flag("--no-horizon{false}", settings.use_horizon, "Cast sky pixels like all others");
    app.add_option("--max-error-px", view.max_error_px,
                   "Take the fastest settings that 'ff accuracy' measured to be off by so many pixels at most")
        ->check(number_in(0.0, 1e3));
    app.add_option("--min-psnr", view.min_psnr_db,
                   "Likewise: with at least so many dB against exact frames, in the worst frame")
        ->check(number_in(0.0, 99.0));
    app.add_flag("--deterministic", settings.deterministic, "Decide from recorded costs instead of measured ones");
}

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
