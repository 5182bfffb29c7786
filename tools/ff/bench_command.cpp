// ff bench: the modes lap by lap in one process, and one JSON object on stdout (README.md names its parts).

#include <sys/resource.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "engine/core/jobs.h"
#include "engine/core/log.h"
#include "engine/core/stopwatch.h"
#include "tools/ff/bench_run.h"
#include "tools/ff/heap_counter.h"
#include "tools/ff/machine.h"
#include "tools/ff/modes.h"
#include "tools/ff/session.h"

namespace ff::tool {
namespace {

using nlohmann::json;

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
        const std::span<const scene::Instance> dynamic = session.dynamic(f, size);
        reference->draw(camera, dynamic, settings, reference_image);
        if (is_prelit) {
            settings.prelit_beyond_m = std::numeric_limits<float>::infinity();
            full_reference->draw(camera, dynamic, settings, full_image);
        }
        for (ModeRun& run : runs) {
            frame::FrameSettings with_ids = run.settings;
            with_ids.keep_ids = true;
            run.renderer->draw(camera, dynamic, with_ids, image);
            run.error.add(int(f), image, reference_image);
            const bool draws_all = run.settings.budget_ms <= 0.0 && run.settings.resolution >= 1.0f;
            const bool has_ids = frame::knows_primitives(run.settings.mode) || run.settings.mode == frame::Mode::hybrid;
            if (has_ids && draws_all)
                run.error.add_primitives(run.renderer->history().visibility, reference->history().visibility);
            if (is_prelit) run.full_error.add(int(f), image, full_image);
            progress.advance();
        }
    }
}

void time_laps(Session& session, std::vector<ModeRun>& runs, const ImageSize& size, int laps, std::size_t frames) {
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
                const Stopwatch pose_watch;
                const std::span<const scene::Instance> dynamic = session.dynamic(f, size);
                const double pose_ms = pose_watch.milliseconds();
                const frame::FrameStats& stats = run.renderer->draw(camera, dynamic, run.settings, image);
                if (f >= kWarmUpFrames) {
                    run.steady_allocations += heap_allocations() - allocations;
                    ++run.steady_frames;
                }
                run.frame_ms.laps[f].push_back(pose_ms + stats.frame_ms);
                run.visibility_ms.laps[f].push_back(stats.visibility_ms());
                run.shading_ms.laps[f].push_back(stats.shading_ms());
                for (std::size_t p = 0; p < frame::kPassCount; ++p) run.pass_ms[p] += stats.pass_ms[p];
                if (lap == 0) run.stats.push_back(stats);
            }
            progress.advance(frames);
        }
    }
}

}  // namespace

Status run_bench(const BenchOptions& options) {
    std::vector<frame::Mode> modes;
    for (const std::string& name : options.modes) modes.push_back(mode_names().at(name));
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
        const frame::Mode mode = mode_names().at(name);
        run.settings = options.view.frame;
        run.settings.mode = mode;
        // The fastest that keeps a given error may be reprojection.
        if (mode == frame::Mode::hybrid) run.settings = session->settings();
        run.renderer = session->make_renderer(options.view.size);
        for (Times* times : {&run.frame_ms, &run.visibility_ms, &run.shading_ms}) times->resize(frames, options.laps);
        run.stats.reserve(frames);
        runs.push_back(std::move(run));
    }
    measure_errors(*session, runs, options.view.size, frames);
    time_laps(*session, runs, options.view.size, options.laps, frames);

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
    for (const ModeRun& run : runs) report["modes"][run.name] = report_of(run, frames, options.laps);
    report["ratios"] = ratios_of(runs);
    std::printf("%s\n", report.dump(2).c_str());
    return {};
}

}  // namespace ff::tool
