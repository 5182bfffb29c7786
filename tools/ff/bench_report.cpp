#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "engine/core/quantile.h"
#include "tools/ff/bench_run.h"

namespace ff::tool {
namespace {

/// P3 Figure 6, over the frames in which something was reprojected; null for modes that never do.
nlohmann::json causes_of(const ModeRun& run) {
    if (run.settings.mode != frame::Mode::reproject) return nullptr;
    farfield::ReprojectCounts sum;
    std::size_t frames = 0;
    for (const frame::FrameStats& stats : run.stats) {
        const farfield::ReprojectCounts& one = stats.causes;
        sum.verified += one.verified;
        sum.background += one.background;
        sum.failed += one.failed;
        sum.resampled += one.resampled;
        sum.abrupt += one.abrupt;
        frames += one.verified + one.background + one.failed + one.resampled + one.abrupt > 0;
    }
    const auto all = double(sum.verified + sum.background + sum.failed + sum.resampled + sum.abrupt);
    const auto percent = [&](std::uint64_t n) { return all > 0 ? 100.0 * double(n) / all : 0.0; };
    return {{"verified", percent(sum.verified)},
            {"background", percent(sum.background)},
            {"failed", percent(sum.failed)},
            {"resampled", percent(sum.resampled)},
            {"abrupt", percent(sum.abrupt)},
            {"frames_reprojected_pct", 100.0 * double(frames) / double(run.stats.size())}};
}

}  // namespace

nlohmann::json ErrorSum::report(double frames) const {
    const double wrong_colors = wrong_color_sum / frames;
    const bool knows_primitives = pixels > 0;
    return {{"psnr_db_mean", psnr_sum / frames},
            {"psnr_db_min", psnr_min},
            {"worst_frame", worst_frame},
            {"wrong_pixels_pct", knows_primitives ? 100.0 * double(wrong_primitives) / double(pixels) : wrong_colors},
            {"wrong_pixels_by", knows_primitives ? "primitive" : "color"},
            {"wrong_colors_pct", wrong_colors}};
}

std::vector<double> Times::medians() const {
    std::vector<double> result;
    for (const auto& frame : laps) result.push_back(median_of(frame));
    return result;
}

double Times::median() const {
    return median_of(medians());
}

nlohmann::json Times::report() const {
    const std::vector<double> times = medians();
    double mean = 0;
    for (const double t : times) mean += t / double(times.size());
    return {{"median", median_of(times)},
            {"mean", mean},
            {"p99", quantile_of(times, 0.99)},
            {"max", *std::max_element(times.begin(), times.end())}};
}

nlohmann::json report_of(const ModeRun& run, std::size_t frames, int laps) {
    frame::PixelCounts pixels;
    double rays = 0, nodes = 0, tested = 0, near_triangles = 0, near_draws = 0, shaded = 0, layers = 0, near_m = 0,
           stale = 0, sun_rays = 0, sun_reused = 0;
    double resolution = 0, least_resolution = 1;
    double parallax_p99 = 0, parallax_max = 0;
    for (const frame::FrameStats& stats : run.stats) {
        pixels.near_field += stats.pixels.near_field;
        pixels.sky += stats.pixels.sky;
        pixels.panorama += stats.pixels.panorama;
        pixels.verified += stats.pixels.verified;
        pixels.cast_hit += stats.pixels.cast_hit;
        pixels.cast_miss += stats.pixels.cast_miss;
        stale += double(stats.pixels.stale);
        resolution += stats.resolution;
        least_resolution = std::min(least_resolution, stats.resolution);
        rays += double(stats.rays);
        nodes += double(stats.nodes_visited);
        tested += double(stats.triangles_tested);
        near_triangles += double(stats.near_triangles);
        near_draws += double(stats.near_draws);
        shaded += double(stats.shaded_pixels);
        layers += double(stats.layers);
        sun_rays += double(stats.sun_rays);
        sun_reused += double(stats.sun_reused);
        near_m += stats.near_m;
        parallax_p99 = std::max(parallax_p99, double(stats.parallax_p99_px));
        parallax_max = std::max(parallax_max, double(stats.parallax_max_px));
    }
    const auto all =
        double(pixels.near_field + pixels.sky + pixels.panorama + pixels.verified + pixels.cast_hit + pixels.cast_miss);
    const auto percent = [&](std::uint64_t n) { return all > 0 ? 100.0 * double(n) / all : 0.0; };
    const auto n = double(frames);

    nlohmann::json passes;
    for (std::size_t p = 0; p < frame::kPassCount; ++p)
        passes[std::string(frame::kPassNames[p])] = run.pass_ms[p] / (n * laps);
    // Embree counts nothing: what no caster counted is null.
    const auto per_ray = [&](double work) {
        return work > 0 && rays > 0 ? nlohmann::json(work / rays) : nlohmann::json(nullptr);
    };
    return {{"frame_ms", run.frame_ms.report()},
            {"visibility_ms", run.visibility_ms.report()},
            {"shading_ms", run.shading_ms.report()},
            {"pass_ms_mean", passes},
            {"causes_pct", causes_of(run)},
            {"pixels_pct",
             {{"near", percent(pixels.near_field)},
              {"sky", percent(pixels.sky)},
              {"panorama", percent(pixels.panorama)},
              {"verified", percent(pixels.verified)},
              {"cast_hit", percent(pixels.cast_hit)},
              {"cast_miss", percent(pixels.cast_miss)}}},
            {"stale_pct", all > 0 ? 100.0 * stale / all : 0.0},
            {"resolution", {{"mean", resolution / n}, {"min", least_resolution}}},
            {"rays_per_frame", rays / n},
            {"intersections_per_ray", per_ray(tested)},
            {"traversal_steps_per_ray", per_ray(nodes)},
            {"shaded_pixels_per_frame", shaded / n},
            {"layers_per_frame", layers / n},
            {"sun_rays_per_frame", sun_rays / n},
            {"sun_reused_per_frame", sun_reused / n},
            {"near_triangles_per_frame", near_triangles / n},
            {"near_draws_per_frame", near_draws / n},
            {"near_m_mean", std::isfinite(near_m) ? nlohmann::json(near_m / n) : nlohmann::json(nullptr)},
            {"error", run.error.report(n)},
            {"error_against_full_shading",
             std::isfinite(run.settings.prelit_beyond_m) ? run.full_error.report(n) : nlohmann::json(nullptr)},
            {"panorama_parallax_px", {{"p99", parallax_p99}, {"max", parallax_max}}},
            {"heap_allocations_per_frame",
             run.steady_frames > 0 ? double(run.steady_allocations) / double(run.steady_frames) : 0.0}};
}

nlohmann::json ratios_of(const std::vector<ModeRun>& runs) {
    constexpr std::array<std::array<const char*, 2>, 12> kPairs{{{"raster", "hybrid"},
                                                                 {"raycast", "hybrid"},
                                                                 {"orsa", "hybrid"},
                                                                 {"beam", "hybrid"},
                                                                 {"orsa", "beam"},
                                                                 {"beam", "irsa"},
                                                                 {"orsa", "reproject"},
                                                                 {"reproject", "irsa"},
                                                                 {"orsa", "irsa"},
                                                                 {"orsa", "beam-reuse"},
                                                                 {"beam", "beam-reuse"},
                                                                 {"beam-reuse", "hybrid"}}};
    const auto find = [&](const char* name) {
        return std::find_if(runs.begin(), runs.end(), [&](const ModeRun& run) { return run.name == name; });
    };
    nlohmann::json ratios = nlohmann::json::object();
    for (const auto& [slow, fast] : kPairs) {
        const auto a = find(slow), b = find(fast);
        if (a == runs.end() || b == runs.end()) continue;
        const std::string name = std::string(slow) + "/" + fast;
        ratios[name] = a->frame_ms.median() / b->frame_ms.median();
        // OpenGL shades as it goes: its visibility has no time of its own.
        if (a->settings.mode != frame::Mode::raster)
            ratios["visibility " + name] = a->visibility_ms.median() / b->visibility_ms.median();
    }
    return ratios;
}

}  // namespace ff::tool
