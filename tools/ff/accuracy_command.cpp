// ff accuracy: sweeps every knob over a walk and writes accuracy.json and accuracy.html.

#include <fmt/format.h>

#include <algorithm>

#include "engine/core/jobs.h"
#include "engine/core/log.h"
#include "engine/core/write_file.h"
#include "tools/accuracy/choose.h"
#include "tools/accuracy/reference.h"
#include "tools/accuracy/report.h"
#include "tools/ff/machine.h"
#include "tools/ff/session.h"

namespace ff::tool {

Status run_accuracy(const AccuracyOptions& options) {
    constexpr int kMostPx = frame::Renderer::kMaxSidePx / accuracy::kSamplesPerSide;
    if (std::max(options.view.size.width, options.view.size.height) > kMostPx)
        return usage_error(
            fmt::format("--size {}x{}: expected sides of {} pixels at most; the reference has {} x {} "
                        "samples in each",
                        options.view.size.width, options.view.size.height, kMostPx, accuracy::kSamplesPerSide,
                        accuracy::kSamplesPerSide));
    // Before the minutes of work whose result goes there.
    std::error_code error;
    std::filesystem::create_directories(options.out, error);
    if (error) return failure(fmt::format("{}: cannot create: {}", options.out.string(), error.message()));
    const frame::Mode modes[] = {frame::Mode::hybrid, frame::Mode::raster};
    auto opened = Session::open(options.view, modes);
    const bool has_gl = opened.has_value();
    if (!has_gl) {
        if (opened.error().kind != ErrorKind::failure) return opened.error();  // the pack's fault, not OpenGL's
        // Without OpenGL there is no near field to turn knobs of, and all else goes on.
        const frame::Mode without_gl[] = {frame::Mode::hybrid};
        log_warning("no OpenGL ({}): its knobs are left out", opened.error().message);
        opened = Session::open(options.view, without_gl);
        if (!opened) return opened.error();
    }
    Session& session = **opened;
    const accuracy::Effort effort = options.quick ? accuracy::kQuick : accuracy::kThorough;
    const accuracy::LabScene scene{.world = session.world(),
                                   .walk = session.walk(),
                                   .moving = [&](std::size_t f) { return session.dynamic(f, options.view.size); },
                                   .width = options.view.size.width,
                                   .height = options.view.size.height,
                                   .has_gl = has_gl,
                                   .make_renderer =
                                       [&](int width, int height) {
                                           return session.make_renderer({width, height});
                                       }};
    const auto frames = accuracy::schedule(scene.walk.frames.size(), effort);
    FF_ASSIGN(const auto reference, accuracy::make_reference(scene, frames, cache_directory() / "accuracy"));
    accuracy::Bench bench{.scene = scene, .frames = frames, .reference = reference, .laps = effort.laps};
    // A near field by a software rasteriser is never chosen; the renderers here could, for they have one.
    if (session.has_software_gl()) bench.exact.fixed_near_m = 0.0;
    FF_ASSIGN(const accuracy::Sweep sweep, accuracy::sweep(bench, effort.pairs));
    const accuracy::ReportInfo info{
        .cpu = cpu_name(), .gl_renderer = session.gl_renderer_name(), .threads = worker_count()};
    FF_TRY(accuracy::write_report(bench, sweep, info, options.out));
    // Beside the pack, too: there walks that are given an allowed error find it.
    const std::filesystem::path table = accuracy::table_path(pack_path(options.view.pack));
    FF_TRY(write_file_whole(table, accuracy::report_json(bench, sweep, info)));
    for (const accuracy::KnobCurve& curve : sweep.curves) log_info("{}: {}", curve.knob->name, curve.says);
    log_info("{}: for --max-error-px and --min-psnr", table.string());
    log_info("{}: accuracy.html and accuracy.json", std::filesystem::absolute(options.out).string());
    return {};
}

}  // namespace ff::tool
