// ff bench: the modes lap by lap in one process, and one JSON object on stdout (README.md names its parts).

#include <sys/resource.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>

#include "engine/core/jobs.h"
#include "engine/core/log.h"
#include "engine/core/stopwatch.h"
#include "engine/shading/image_difference.h"
#include "tools/ff/heap_counter.h"
#include "tools/ff/machine.h"
#include "tools/ff/session.h"

namespace ff::tool {
namespace {

using nlohmann::json;

const std::map<std::string, frame::Mode> kModes{{"hybrid", frame::Mode::hybrid},
                                                {"raster", frame::Mode::raster},
                                                {"raycast", frame::Mode::raycast},
                                                {"near", frame::Mode::near}};

double median_of(std::vector<double> values) {
    const auto middle = values.begin() + std::ptrdiff_t(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    return *middle;
}

/// The value that a share of all values do not exceed, share in (0, 1].
double quantile_of(std::vector<double> values, double share) {
    const auto rank = std::size_t(std::ceil(share * double(values.size()))) - 1;
    std::nth_element(values.begin(), values.begin() + std::ptrdiff_t(rank), values.end());
    return values[rank];
}

/// Differences of a walk's frames from a reference.
struct ErrorSum {
    double psnr_sum = 0, psnr_min = 99.0, wrong_sum = 0;
    int worst_frame = 0;

    void add(int frame, const shading::Image& image, const shading::Image& reference) {
        constexpr int kWrongLevels = 16;  // of 255
        const auto [psnr, wrong] = shading::compare_images(image, reference, kWrongLevels);
        psnr_sum += psnr;
        if (psnr < psnr_min) worst_frame = frame;
        psnr_min = std::min(psnr_min, psnr);
        wrong_sum += 100.0 * wrong;
    }
    [[nodiscard]] json report(double frames) const {
        return {{"psnr_db_mean", psnr_sum / frames},
                {"psnr_db_min", psnr_min},
                {"worst_frame", worst_frame},
                {"wrong_pixels_pct", wrong_sum / frames}};
    }
};

/// Everything measured of one mode.
struct ModeRun {
    std::string name;
    frame::FrameSettings settings;
    std::unique_ptr<frame::Renderer> renderer;
    std::vector<std::vector<double>> frame_ms;  ///< [frame][lap]
    std::vector<frame::FrameStats> stats;       ///< [frame], of the first lap: work is the same in all
    std::vector<double> pass_ms = std::vector<double>(frame::kPassCount, 0.0);
    std::uint64_t steady_allocations = 0, steady_frames = 0;
    ErrorSum error;       ///< against mode raycast with the same shading
    ErrorSum full_error;  ///< against mode raycast with full shading: what a prelit far field costs as well

    /// A frame's time: the median over the laps, so that another process's burst in one lap is not ours.
    [[nodiscard]] std::vector<double> times() const {
        std::vector<double> result;
        for (const auto& laps : frame_ms) result.push_back(median_of(laps));
        return result;
    }
};

double peak_memory_mb() {
    rusage usage{};
    getrusage(RUSAGE_SELF, &usage);
    return double(usage.ru_maxrss) / 1024.0;
}

/// One untimed lap in step: every mode's picture of a frame against mode raycast's.
void measure_errors(Session& session, std::vector<ModeRun>& runs, const ImageSize& size, std::size_t frames) {
    const auto reference = session.make_renderer(size);
    const auto full_reference = session.make_renderer(size);
    shading::Image reference_image, full_image, image;
    const bool is_prelit = std::isfinite(runs.front().settings.prelit_beyond_m);
    Progress progress("comparing with raycast", frames * runs.size());
    for (std::size_t f = 0; f < frames; ++f) {
        const Camera camera = session.walk().camera(f);
        frame::FrameSettings settings = runs.front().settings;
        settings.mode = frame::Mode::raycast;
        reference->draw(camera, session.dynamic(), settings, reference_image);
        if (is_prelit) {
            settings.prelit_beyond_m = std::numeric_limits<float>::infinity();
            full_reference->draw(camera, session.dynamic(), settings, full_image);
        }
        for (ModeRun& run : runs) {
            run.renderer->draw(camera, session.dynamic(), run.settings, image);
            run.error.add(int(f), image, reference_image);
            if (is_prelit) run.full_error.add(int(f), image, full_image);
            progress.advance();
        }
    }
}

void time_laps(Session& session, std::vector<ModeRun>& runs, int laps, std::size_t frames) {
    constexpr std::size_t kWarmUpFrames = 4;  // of a lap, before its frames count as steady
    shading::Image image;
    Progress progress("timing", std::uint64_t(laps) * runs.size() * frames);
    for (int lap = 0; lap < laps; ++lap) {
        for (std::size_t i = 0; i < runs.size(); ++i) {
            ModeRun& run = runs[(i + std::size_t(lap)) % runs.size()];  // nobody is always first
            run.renderer->reset();
            for (std::size_t f = 0; f < frames; ++f) {
                const Camera camera = session.walk().camera(f);
                const std::uint64_t allocations = heap_allocations();
                const frame::FrameStats& stats = run.renderer->draw(camera, session.dynamic(), run.settings, image);
                if (f >= kWarmUpFrames) {
                    run.steady_allocations += heap_allocations() - allocations;
                    ++run.steady_frames;
                }
                run.frame_ms[f].push_back(stats.frame_ms);
                for (std::size_t p = 0; p < frame::kPassCount; ++p) run.pass_ms[p] += stats.pass_ms[p];
                if (lap == 0) run.stats.push_back(stats);
            }
            progress.advance(frames);
        }
    }
}

json report_of(const ModeRun& run, std::size_t frames, int laps) {
    const std::vector<double> times = run.times();
    double mean = 0;
    for (const double t : times) mean += t / double(times.size());

    frame::PixelCounts pixels;
    double rays = 0, near_triangles = 0, near_draws = 0, shaded = 0, layers = 0, near_m = 0, stale = 0;
    double resolution = 0, least_resolution = 1;
    double parallax_p99 = 0, parallax_max = 0;
    for (const frame::FrameStats& stats : run.stats) {
        pixels.near_field += stats.pixels.near_field;
        pixels.sky += stats.pixels.sky;
        pixels.panorama += stats.pixels.panorama;
        pixels.cast_hit += stats.pixels.cast_hit;
        pixels.cast_miss += stats.pixels.cast_miss;
        stale += double(stats.pixels.stale);
        resolution += stats.resolution;
        least_resolution = std::min(least_resolution, stats.resolution);
        rays += double(stats.rays);
        near_triangles += double(stats.near_triangles);
        near_draws += double(stats.near_draws);
        shaded += double(stats.shaded_pixels);
        layers += double(stats.layers);
        near_m += stats.near_m;
        parallax_p99 = std::max(parallax_p99, double(stats.parallax_p99_px));
        parallax_max = std::max(parallax_max, double(stats.parallax_max_px));
    }
    const auto all = double(pixels.near_field + pixels.sky + pixels.panorama + pixels.cast_hit + pixels.cast_miss);
    const auto percent = [&](std::uint64_t n) { return all > 0 ? 100.0 * double(n) / all : 0.0; };
    const auto n = double(frames);

    json passes;
    for (std::size_t p = 0; p < frame::kPassCount; ++p)
        passes[std::string(frame::kPassNames[p])] = run.pass_ms[p] / (n * laps);
    return {{"frame_ms",
             {{"median", median_of(times)},
              {"mean", mean},
              {"p99", quantile_of(times, 0.99)},
              {"max", *std::max_element(times.begin(), times.end())}}},
            {"pass_ms_mean", passes},
            {"pixels_pct",
             {{"near", percent(pixels.near_field)},
              {"sky", percent(pixels.sky)},
              {"panorama", percent(pixels.panorama)},
              {"cast_hit", percent(pixels.cast_hit)},
              {"cast_miss", percent(pixels.cast_miss)}}},
            {"stale_pct", all > 0 ? 100.0 * stale / all : 0.0},
            {"resolution", {{"mean", resolution / n}, {"min", least_resolution}}},
            {"rays_per_frame", rays / n},
            {"shaded_pixels_per_frame", shaded / n},
            {"layers_per_frame", layers / n},
            {"near_triangles_per_frame", near_triangles / n},
            {"near_draws_per_frame", near_draws / n},
            {"near_m_mean", std::isfinite(near_m) ? json(near_m / n) : json(nullptr)},
            {"error", run.error.report(n)},
            {"error_against_full_shading",
             std::isfinite(run.settings.prelit_beyond_m) ? run.full_error.report(n) : json(nullptr)},
            {"panorama_parallax_px", {{"p99", parallax_p99}, {"max", parallax_max}}},
            {"heap_allocations_per_frame",
             run.steady_frames > 0 ? double(run.steady_allocations) / double(run.steady_frames) : 0.0}};
}

}  // namespace

Status run_bench(const BenchOptions& options) {
    std::vector<frame::Mode> modes;
    for (const std::string& name : options.modes) modes.push_back(kModes.at(name));
    const Stopwatch open_watch;
    FF_ASSIGN(const std::unique_ptr<Session> session, Session::open(options.view, modes));
    const double open_seconds = open_watch.seconds();
    const std::size_t frames = options.max_frames > 0
                                   ? std::min(std::size_t(options.max_frames), session->walk().frames.size())
                                   : session->walk().frames.size();

    std::vector<ModeRun> runs;
    for (const std::string& name : options.modes) {
        if (std::any_of(runs.begin(), runs.end(), [&](const ModeRun& run) { return run.name == name; })) continue;
        ModeRun run;
        run.name = name;
        run.settings = kModes.at(name) == frame::Mode::hybrid ? session->settings() : options.view.frame;
        run.settings.mode = kModes.at(name);
        run.renderer = session->make_renderer(options.view.size);
        run.frame_ms.resize(frames);
        for (auto& laps : run.frame_ms) laps.reserve(std::size_t(options.laps));
        run.stats.reserve(frames);
        runs.push_back(std::move(run));
    }
    measure_errors(*session, runs, options.view.size, frames);
    time_laps(*session, runs, options.laps, frames);

    const scene::StaticScene& scene = session->world().scene();
    const scene::WorldStatistics& statistics = session->world().statistics();
    const frame::FrameSettings& settings = options.view.frame;
    json report{
        {"scene",
         {{"name", session->world().info().name},
          {"triangles", statistics.triangles},
          {"instanced_triangles", statistics.instanced_triangles},
          {"cells", scene.cells.size()}}},
        {"machine", {{"cpu", cpu_name()}, {"threads", worker_count()}, {"gl_renderer", session->gl_renderer_name()}}},
        {"settings",
         {{"walk", session->walk().name},
          {"frames", frames},
          {"laps", options.laps},
          {"width", options.view.size.width},
          {"height", options.view.size.height},
          {"budget_ms", settings.budget_ms},
          {"max_parallax_px", settings.max_parallax_px},
          {"near_m", settings.fixed_near_m ? json(*settings.fixed_near_m) : json(nullptr)},
          {"prelit_beyond_m", std::isfinite(settings.prelit_beyond_m) ? json(settings.prelit_beyond_m) : json(nullptr)},
          {"occlusion", options.view.use_occlusion},
          {"deterministic", settings.deterministic},
          {"frame_ms", "a frame's time is its median over the laps"}}},
        {"open_seconds", open_seconds},
        {"peak_memory_mb", peak_memory_mb()}};
    std::map<std::string, double> medians;
    for (const ModeRun& run : runs) {
        report["modes"][run.name] = report_of(run, frames, options.laps);
        medians[run.name] = report["modes"][run.name]["frame_ms"]["median"];
    }
    report["ratios"] = json::object();
    for (const char* other : {"raster", "raycast"})
        if (medians.count("hybrid") != 0 && medians.count(other) != 0)
            report["ratios"][std::string(other) + "/hybrid"] = medians[other] / medians["hybrid"];
    std::printf("%s\n", report.dump(2).c_str());
    return {};
}

}  // namespace ff::tool
