#include "tools/ff/command_options.h"

#include <cmath>
#include <cstdio>
#include <cstdlib>

#include "engine/effects/registry.h"
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

std::string effect_names() {
    std::string names;
    for (const effects::Effect& effect : effects::registry())
        names += (names.empty() ? "" : ", ") + std::string(effect.name);
    return names;
}

}  // namespace

CLI::Validator number_in(double low, double high) {
    // CLI::Range lets not-a-number pass, which is neither below nor above.
    return CLI::Range(low, high) & CLI::Validator(
                                       [](const std::string& text) {
                                           return std::isnan(std::strtod(text.c_str(), nullptr))
                                                      ? "'" + text + "' is not a number"
                                                      : std::string();
                                       },
                                       "");
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
    app.add_option_function<std::vector<double>>(
           "--wind",
           [&settings](const std::vector<double>& wind) {
               if (!settings.weather) settings.weather.emplace();
               const double from = radians_of(wind[1]);
               settings.weather->wind_m_s = Vec2(-wind[0] * std::sin(from), wind[0] * std::cos(from));
           },
           "Wind instead of the scene's: metres a second, and where it comes from, degrees clockwise from north: 6,270")
        ->delimiter(',')
        ->expected(2)
        ->check(number_in(-360.0, 360.0));
    app.add_option("--wind-within-m", settings.wind_within_m, "Leaves farther away stand still; 0: all do")
        ->check(number_in(0.0, 1e3));
    app.add_option("--birds-within-m", view.scenery.birds_within_m,
                   "Flocks farther away are not there, in a view of 60 degrees")
        ->check(number_in(0.0, 1e5));
    app.add_option("--bodies-within-m", view.scenery.bodies_within_m, "Rigid bodies farther away stay where they are")
        ->check(number_in(1.0, 1e5));
    app.add_option("--water-within-m", settings.water_within_m,
                   "Water farther away has no waves, but is as rough as they make it; 0: none has")
        ->check(number_in(0.0, 1e5));
    app.add_option(
           "--air-error", settings.air_error,
           "Air in front of a surface is left out where it changes a pixel by less than this, of 1: 0.002 is half "
           "a level of 255; 0: nowhere")
        ->check(number_in(0.0, 0.1));
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

}  // namespace ff::tool
