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
#include "tools/ff/frame_recorder.h"
#include "tools/ff/machine.h"
#include "tools/ff/modes.h"
#include "tools/ff/session.h"
#include "tools/ff/walk_lap.h"

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

Status time_laps(Session& session, std::vector<ModeRun>& runs, const ImageSize& size, int laps, std::size_t frames,
                 debug::Trace* trace) {
    shading::Image image;
    Progress progress("timing", std::uint64_t(laps) * runs.size() * frames);
    for (int lap = 0; lap < laps; ++lap) {
        for (std::size_t i = 0; i < runs.size(); ++i) {
            ModeRun& run = runs[(i + std::size_t(lap)) % runs.size()];  // nobody is always first
            const bool is_last = lap + 1 == laps;
            if (is_last && trace != nullptr) trace->begin_process(run.name);
            FF_TRY(draw_lap(session, *run.renderer, run.settings, size, frames, image, [&](const LapFrame& drawn) {
                if (drawn.frame >= kWarmUpFrames) {
                    run.steady_allocations += drawn.allocations;
                    ++run.steady_frames;
                }
                const frame::FrameStats& stats = drawn.stats;
                run.frame_ms.laps[drawn.frame].push_back(drawn.ms);
                run.visibility_ms.laps[drawn.frame].push_back(stats.visibility_ms());
                run.shading_ms.laps[drawn.frame].push_back(stats.shading_ms());
                for (std::size_t p = 0; p < frame::kPassCount; ++p) run.pass_ms[p] += stats.pass_ms[p];
                if (lap == 0) {
                    run.stats.push_back(stats);
                    run.work.push_back(report::work_of(stats, drawn.allocations, drawn.upload_bytes));
                }
                if (is_last && trace != nullptr) trace->add(drawn.frame, drawn.allocations, stats);
            }));
            progress.advance(frames);
        }
    }
    return {};
}

/// Every frame of a mode and pictures of its slowest; passes as in the first lap.
Status add_frames_of(Session& session, const ModeRun& run, const ImageSize& size, json& out) {
    report::FrameSeries series(run.stats.size());
    const std::vector<double> ms = run.frame_ms.medians();
    for (std::size_t f = 0; f < run.stats.size(); ++f)
        series.add(session.walk().camera(f), ms[f], run.work[f], run.stats[f]);
    return add_frames(session, *run.renderer, run.settings, size, series, out);
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
        run.work.reserve(frames);
        runs.push_back(std::move(run));
    }
    measure_errors(*session, runs, options.view.size, frames);
    debug::Trace trace(options.trace.empty() ? 0 : runs.size() * frames);
    FF_TRY(
        time_laps(*session, runs, options.view.size, options.laps, frames, options.trace.empty() ? nullptr : &trace));
    if (!options.trace.empty()) FF_TRY(write_trace(options.trace, trace));

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
    for (const ModeRun& run : runs) {
        json& out = report["modes"][run.name] = report_of(run, frames, options.laps);
        if (options.each_frame) FF_TRY(add_frames_of(*session, run, options.view.size, out));
    }
    report["ratios"] = ratios_of(runs);
    std::printf("%s\n", report.dump(2).c_str());
    return {};
}

}  // namespace ff::tool
