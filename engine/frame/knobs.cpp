#include "engine/frame/knobs.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <limits>

namespace ff::frame {
namespace {

/// Stands for without end: tables are stored as JSON, which has no infinity.
constexpr double kUnlimited = 1e9;

constexpr std::array kBudgets{KnobValue{0.0, "none"}, KnobValue{33}, KnobValue{24}, KnobValue{16},
                              KnobValue{12},          KnobValue{8},  KnobValue{6},  KnobValue{4}};
constexpr std::array kResolutionShares{KnobValue{1.0, "100%"}, KnobValue{0.84, "84%"}, KnobValue{0.71, "71%"},
                                       KnobValue{0.59, "59%"}, KnobValue{0.5, "50%"},  KnobValue{0.35, "35%"}};
constexpr std::array kParallaxes{KnobValue{0.0, "never"}, KnobValue{0.25}, KnobValue{0.5},
                                 KnobValue{1.0},          KnobValue{2.0},  KnobValue{4.0}};
constexpr std::array kRayBudgets{KnobValue{kUnlimited, "all"},
                                 KnobValue{160'000},
                                 KnobValue{80'000},
                                 KnobValue{40'000},
                                 KnobValue{20'000},
                                 KnobValue{10'000}};
constexpr std::array kDensities{KnobValue{1.5}, KnobValue{1.0}, KnobValue{0.75}, KnobValue{0.5}, KnobValue{0.35}};
constexpr std::array kEdgeRules{KnobValue{1, "cast"}, KnobValue{2, "verify"}, KnobValue{0, "blend"}};
constexpr std::array kPrelitDistances{
    KnobValue{kUnlimited, "never"}, KnobValue{1600}, KnobValue{400}, KnobValue{100}, KnobValue{25}, KnobValue{0}};
constexpr std::array kBlendDistances{KnobValue{60}, KnobValue{20}, KnobValue{0, "by coverage"}};
constexpr std::array kSubsamples{KnobValue{1, "every"}, KnobValue{2, "every 2nd"}, KnobValue{4, "every 4th"}};
constexpr std::array kHorizonUses{KnobValue{1, "traced"}, KnobValue{0, "off"}};
constexpr std::array kCasterKinds{KnobValue{0, "beam"}, KnobValue{1, "embree"}, KnobValue{2, "grid"}};
constexpr std::array kGridCells{KnobValue{1}, KnobValue{4}, KnobValue{16}};
constexpr std::array kNearDistances{KnobValue{0}, KnobValue{25}, KnobValue{50}, KnobValue{100}, KnobValue{400}};
constexpr std::array kOpacityKinds{KnobValue{2, "readback"}, KnobValue{1, "software"}};
constexpr std::array kReprojectCounts{KnobValue{7}, KnobValue{5}, KnobValue{3}, KnobValue{1}};
constexpr std::array kReprojectPeriods{KnobValue{4}, KnobValue{9}, KnobValue{16}, KnobValue{0, "never"}};
constexpr std::array kReprojectSurfaces{KnobValue{0.01, "1%"}, KnobValue{0.05, "5%"}, KnobValue{0.2, "20%"}};
constexpr std::array kReprojectVotes{KnobValue{1, "primitive"}, KnobValue{0, "surface"}, KnobValue{2, "any"}};
constexpr std::array kSwitches{KnobValue{0, "off"}, KnobValue{1, "on"}};
constexpr std::array kSunReuses{KnobValue{0, "cast"}, KnobValue{1, "reused"}};
constexpr std::array kSunRefreshes{KnobValue{1}, KnobValue{8}, KnobValue{32}, KnobValue{128}, KnobValue{0, "never"}};
constexpr std::array kSunShadowsValues{KnobValue{0, "as the scene says"}, KnobValue{1, "off"}};
constexpr std::array kLampDistances{KnobValue{1600}, KnobValue{400}, KnobValue{200},
                                    KnobValue{100},  KnobValue{50},  KnobValue{0, "none"}};
constexpr std::array kReflectionRays{KnobValue{400'000}, KnobValue{96'000}, KnobValue{24'000}, KnobValue{6'000},
                                     KnobValue{0, "none"}};
constexpr std::array kAirErrors{KnobValue{0.0, "all air"},          KnobValue{1.0 / 512.0, "half a level"},
                                KnobValue{1.0 / 128.0, "2 levels"}, KnobValue{1.0 / 64.0, "4 levels"},
                                KnobValue{1.0 / 32.0, "8 levels"},  KnobValue{1.0 / 16.0, "16 levels"}};
constexpr std::array kWaterDistances{KnobValue{1500}, KnobValue{600}, KnobValue{250},
                                     KnobValue{100},  KnobValue{40},  KnobValue{0, "none"}};
constexpr std::array kWindDistances{KnobValue{120}, KnobValue{60}, KnobValue{30}, KnobValue{15}, KnobValue{0, "none"}};
constexpr std::array kFallDensities{KnobValue{1.0}, KnobValue{0.5}, KnobValue{0.25}, KnobValue{0, "none"}};
constexpr std::array kChecks{KnobValue{1, "on"}, KnobValue{0, "off"}};

/// A panorama that serves a moving viewer, as the knobs of the panorama need it to show.
void reuse(FrameSettings& s) {
    s.use_panorama = s.reuse_while_moving = true;
}

/// Mode reproject, for the knobs of which only that takes notice. Exact frames are those of the usual mode: what the
/// knob's default costs and gives is what the mode does.
farfield::ReprojectSettings& reproject(FrameSettings& s) {
    s.mode = Mode::reproject;
    return s.reproject;
}

const std::array kKnobs{
    Knob{"budget_ms", "ms", "Time that a frame may take; what does not fit is drawn smaller.", 0.0, kBudgets,
         [](FrameSettings& s, double v) { s.budget_ms = v; }},
    Knob{"resolution", "", "Share of the image's sides that is drawn, then enlarged.", 1.0, kResolutionShares,
         [](FrameSettings& s, double v) { s.resolution = float(v); }, KnobScope::all},
    Knob{"panorama_parallax", "px", "A walking viewer reuses panorama texels up to this predicted parallax.", 0.0,
         kParallaxes,
         [](FrameSettings& s, double v) {
             s.reuse_while_moving = v > 0.0;
             if (v > 0.0) s.use_panorama = true;
             if (v > 0.0) s.max_parallax_px = float(v);
         },
         KnobScope::panorama},
    Knob{"ray_budget", "rays", "Pixels cast a frame at most, where a walking viewer reuses the panorama.", kUnlimited,
         kRayBudgets,
         [](FrameSettings& s, double v) {
             reuse(s);
             s.ray_budget = v < kUnlimited ? std::uint64_t(v) : UINT64_MAX;
         },
         KnobScope::panorama},
    Knob{"panorama_density", "x", "Texels a side of a reused panorama, against the usual 1.25 a pixel.", 1.0,
         kDensities,
         [](FrameSettings& s, double v) {
             reuse(s);
             s.panorama_density = float(v);
         },
         KnobScope::panorama},
    Knob{"panorama_edges", "", "What happens where the texels of a reused panorama show different things.", 2.0,
         kEdgeRules,
         [](FrameSettings& s, double v) {
             reuse(s);
             s.panorama_edges = farfield::EdgeRule(int(v));
         },
         KnobScope::panorama},
    Knob{"prelit_beyond", "m", "Beyond this distance triangles have one prelit colour instead of textures.", kUnlimited,
         kPrelitDistances,
         [](FrameSettings& s, double v) {
             s.prelit_beyond_m = v < kUnlimited ? float(v) : std::numeric_limits<float>::infinity();
         },
         KnobScope::all},
    Knob{"blend_within", "m", "Blended surfaces nearer than this are sorted per pixel, farther ones shown by coverage.",
         60.0, kBlendDistances, [](FrameSettings& s, double v) { s.blend_within_m = float(v); }, KnobScope::all},
    Knob{"sun_shadows", "", "Whether what stands between a surface and the sun keeps its light away.", 0.0,
         kSunShadowsValues, [](FrameSettings& s, double v) { s.sun_shadows = SunShadows(int(v)); }, KnobScope::all,
         false, true},
    Knob{"sun_reuse", "", "Whether pixels that see the same points as in the last frame keep their light.", 1.0,
         kSunReuses, [](FrameSettings& s, double v) { s.reuse_sun = v != 0.0; }, KnobScope::hybrid, false, true},
    Knob{"sun_refresh", "frames", "Reused light is looked at anew at least once in so many.", 32.0, kSunRefreshes,
         [](FrameSettings& s, double v) { s.sun_refresh_frames = int(v); }, KnobScope::hybrid, false, true},
    Knob{.name = "lamps_within",
         .unit = "m",
         .about = "Lamps farther from the viewer than this light nothing.",
         .default_value = 400.0,
         .values = kLampDistances,
         .set = [](FrameSettings& s, double v) { s.lamps_within_m = float(v); },
         .scope = KnobScope::all,
         .needs_lamps = true},
    Knob{.name = "reflection_rays",
         .unit = "rays",
         .about = "Rays a frame, about, for what water and glass mirror; none: the sky alone.",
         .default_value = 6'000.0,
         .values = kReflectionRays,
         .set = [](FrameSettings& s, double v) { s.reflection_rays = std::uint64_t(v); },
         .scope = KnobScope::all,
         .needs_mirrors = true},
    Knob{.name = "air_error",
         .unit = "",
         .about = "Air in front of a surface is left out where it changes a pixel by less than this.",
         .default_value = 1.0 / 512.0,
         .values = kAirErrors,
         .set = [](FrameSettings& s, double v) { s.air_error = float(v); },
         .scope = KnobScope::all,
         .needs_air = true},
    Knob{.name = "water_within",
         .unit = "m",
         .about = "Water farther from the viewer than this has no waves of its own.",
         .default_value = 1500.0,
         .values = kWaterDistances,
         .set = [](FrameSettings& s, double v) { s.water_within_m = float(v); },
         .scope = KnobScope::all,
         .needs_water = true},
    Knob{.name = "wind_within",
         .unit = "m",
         .about = "Leaves farther from the viewer than this stand still in the wind.",
         .default_value = 60.0,
         .values = kWindDistances,
         .set = [](FrameSettings& s, double v) { s.wind_within_m = float(v); },
         .scope = KnobScope::all,
         .needs_wind = true},
    Knob{.name = "fall_density",
         .unit = "",
         .about = "Share of the drops and flakes near the viewer that are drawn.",
         .default_value = 1.0,
         .values = kFallDensities,
         .set = [](FrameSettings& s, double v) { s.fall_density = float(v); },
         .scope = KnobScope::all,
         .needs_weather = true},
    Knob{"horizon", "", "Whether sky above the traced skyline is left to nobody.", 1.0, kHorizonUses,
         [](FrameSettings& s, double v) { s.use_horizon = v != 0.0; }},
    Knob{"horizon_subsample", "", "Which azimuths are traced; fewer ones on height squares so much coarser.", 1.0,
         kSubsamples, [](FrameSettings& s, double v) { s.horizon_subsample = int(v); }},
    Knob{"caster", "", "Who answers what is left over.", 0.0, kCasterKinds,
         [](FrameSettings& s, double v) { s.caster = CasterKind(int(v)); }},
    Knob{"grid_cells", "a triangle", "Cells of the regular grid, where that answers what is left over.", 4.0,
         kGridCells,
         [](FrameSettings& s, double v) {
             s.caster = CasterKind::grid;
             s.grid_cells_per_item = float(v);
         }},
    Knob{"near_distance", "m", "Cells nearer than this are rasterised by OpenGL.", 0.0, kNearDistances,
         [](FrameSettings& s, double v) { s.fixed_near_m = v; }, KnobScope::hybrid, true},
    Knob{"opacity", "", "How the near field's covered pixels are found, at 50 m near distance.", 2.0, kOpacityKinds,
         [](FrameSettings& s, double v) {
             s.fixed_near_m = s.fixed_near_m.value_or(50.0);
             s.opacity = OpacityKind(int(v));
         },
         KnobScope::hybrid, true},
    Knob{"reproject_count", "", "m_cnt: so many of the 3 x 3 pixels around must vote for a reprojected hit.", 5.0,
         kReprojectCounts, [](FrameSettings& s, double v) { reproject(s).min_count = int(v); },
         KnobScope::reprojection},
    Knob{"reproject_period", "frames", "Each pixel of a reprojected image is cast at least once in so many.", 9.0,
         kReprojectPeriods, [](FrameSettings& s, double v) { reproject(s).resample_period = int(v); },
         KnobScope::reprojection},
    Knob{"reproject_surface", "", "Reprojected depths within this share of each other are one surface.", 0.05,
         kReprojectSurfaces, [](FrameSettings& s, double v) { reproject(s).surface_share = float(v); },
         KnobScope::reprojection},
    Knob{"reproject_vote", "", "Whose reprojected points vote for a hit: its triangle's, its surface's or any.", 0.0,
         kReprojectVotes, [](FrameSettings& s, double v) { reproject(s).vote = farfield::Vote(int(v)); },
         KnobScope::reprojection},
    Knob{"reproject_frustum", "", "Whether all is cast once the eye has left the last view frustum.", 1.0, kChecks,
         [](FrameSettings& s, double v) { reproject(s).check_view_frustum = v != 0.0; }, KnobScope::reprojection},
    Knob{"reproject_occlusion", "", "Whether reprojected points that others overtook are left out.", 1.0, kChecks,
         [](FrameSettings& s, double v) { reproject(s).check_occlusion = v != 0.0; }, KnobScope::reprojection},
    Knob{"reproject_shift", "", "Whether rays of pixels that fail begin where points landed around them.", 0.0,
         kSwitches, [](FrameSettings& s, double v) { reproject(s).shift_origin = v != 0.0; }, KnobScope::reprojection},
    Knob{"reproject_abrupt", "", "Whether reprojected points that come too fast are left out.", 1.0, kChecks,
         [](FrameSettings& s, double v) { reproject(s).check_abrupt = v != 0.0; }, KnobScope::reprojection},
    Knob{"reproject_background", "", "Whether sky is reprojected like everything else; if not, it is cast.", 1.0,
         kSwitches, [](FrameSettings& s, double v) { reproject(s).use_background = v != 0.0; },
         KnobScope::reprojection},
};

}  // namespace

std::string Knob::text(double value) const {
    for (const KnobValue& v : values)
        if (v.value == value && !v.name.empty()) return std::string(v.name);
    return unit.empty() ? fmt::format("{}", value) : fmt::format("{} {}", value, unit);
}

std::span<const Knob> knobs() {
    return kKnobs;
}

const Knob* find_knob(std::string_view name) {
    const auto knob = std::find_if(kKnobs.begin(), kKnobs.end(), [&](const Knob& k) { return k.name == name; });
    return knob == kKnobs.end() ? nullptr : &*knob;
}

Status set_knob(FrameSettings& settings, std::string_view name, double value) {
    const Knob* knob = find_knob(name);
    if (knob == nullptr) return failure(fmt::format("there is no knob '{}'", name));
    const auto [low, high] =
        std::minmax_element(knob->values.begin(), knob->values.end(),
                            [](const KnobValue& a, const KnobValue& b) { return a.value < b.value; });
    if (!(value >= low->value && value <= high->value))
        return failure(fmt::format("knob '{}': {} is not in [{}, {}]", name, value, low->value, high->value));
    knob->set(settings, value);
    return {};
}

}  // namespace ff::frame
