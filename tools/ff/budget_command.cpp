// ff budget: holds a walk to limits of time and work, and keeps what a miss looked like.

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "engine/core/jobs.h"
#include "engine/core/log.h"
#include "engine/core/stopwatch.h"
#include "engine/core/work_clock.h"
#include "engine/core/write_file.h"
#include "tools/ff/budget_run.h"
#include "tools/ff/frame_recorder.h"
#include "tools/ff/machine.h"
#include "tools/ff/walk_lap.h"
#include "tools/picture/picture_file.h"

namespace ff::tool {
namespace {

using budget::Verdict;
using nlohmann::json;

Result<budget::Budget> read_budget(const std::filesystem::path& path) {
    FF_ASSIGN(const std::string text, read_text_file(path));
    return budget::parse_budget(text, path.string(), {frame::kPassNames, report::effect_names()});
}

json json_of(const Verdict& verdict) {
    return {{"name", verdict.limit.name()},
            {"limit", verdict.limit.value},
            {"allowed", verdict.allowed},
            {"measured", verdict.measured},
            {"held", verdict.held()},
            {"worst_frame", verdict.frame},
            {"unit", verdict.limit.kind == budget::LimitKind::work ? "count" : "ms"}};
}

json report_of(Session& session, const BudgetRun& run, const BudgetOptions& options,
               const std::optional<budget::Budget>& budget, std::span<const Verdict> verdicts) {
    const double file_ms = budget ? budget->calibration_ms.value_or(0.0) : 0.0;  // 0: it says none
    json report{
        {"kind", "budget"},
        {"scene", {{"name", session.world().info().name}}},
        {"machine", {{"cpu", cpu_name()}, {"threads", worker_count()}, {"gl_renderer", session.gl_renderer_name()}}},
        {"settings",
         {{"walk", session.walk().name},
          {"laps", run.laps()},
          {"warm_up_frames", kWarmUpFrames},
          {"width", options.view.size.width},
          {"height", options.view.size.height},
          {"budget_ms", options.view.frame.budget_ms},
          {"clock", work_clock() == WorkClock::thread ? "thread" : "wall"},
          {"frame_ms", "a frame's time is the least of its laps"}}},
        {"calibration",
         {{"ms", run.calibration_ms()},
          {"file_ms", file_ms > 0.0 ? json(file_ms) : json(nullptr)},
          {"scale", file_ms > 0.0 ? run.calibration_ms() / file_ms : 1.0}}},
        {"limits", json::array()},
        {"figures", json::object()}};
    for (const Verdict& verdict : verdicts) report["limits"].push_back(json_of(verdict));
    for (const budget::Figure& figure : run.figures())
        report["figures"][budget::Limit{.kind = figure.kind, .key = figure.key}.name()] = figure.value;
    return report;
}

/// The limit that is missed most.
const Verdict* worst_of(std::span<const Verdict> verdicts) {
    const auto worst = std::max_element(verdicts.begin(), verdicts.end(),
                                        [](const Verdict& a, const Verdict& b) { return a.excess() < b.excess(); });
    return worst == verdicts.end() || worst->held() ? nullptr : &*worst;
}

/// Where a miss is kept.
std::filesystem::path keep_folder(const BudgetOptions& options) {
    return options.keep.empty() ? options.junit.parent_path() / "budget-miss" : options.keep;
}

/// Draws the frame in which a limit is missed most once more: its picture and plan, and the trace of the last lap.
Status keep_miss(Session& session, BudgetRun& run, const BudgetOptions& options, const Verdict& worst,
                 const std::string& text, const json& report) {
    const std::filesystem::path folder = keep_folder(options);
    std::error_code error;
    std::filesystem::create_directories(folder, error);
    if (error) return failure(fmt::format("{}: cannot create: {}", folder.string(), error.message()));
    const report::FrameSeries series = run.series();
    FF_ASSIGN(const auto pictures,
              draw_pictures(session, run.renderer(), run.settings(), options.view.size, {worst.frame}, series));
    FF_TRY(write_image(folder / "frame.png", pictures.front().image));
    FF_TRY(write_file_whole(folder / "plan.txt", fmt::format("{}\nframe {}, {:.3f} ms\n{}", text, worst.frame,
                                                             pictures.front().ms, pictures.front().plan)));
    FF_TRY(write_file_whole(folder / "trace.json", run.trace().to_json()));
    return write_file_whole(folder / "budget.json", report.dump(1));
}

void print_table(std::span<const Verdict> verdicts, double scale) {
    if (verdicts.empty()) return;
    fmt::print("{:<26} {:>12} {:>12} {:>9} {:>7}\n", "limit", "allowed", "measured", "of it", "frame");
    for (const Verdict& v : verdicts) {
        const int digits = v.limit.kind == budget::LimitKind::work ? 0 : 3;
        fmt::print("{:<26} {:>12.{}f} {:>12.{}f} {:>7.1f} % {:>7}{}\n", v.limit.name(), v.allowed, digits, v.measured,
                   digits, v.allowed > 0.0 ? 100.0 * v.measured / v.allowed : 0.0, v.frame, v.held() ? "" : "  MISSED");
    }
    fmt::print("times are allowed {:.3f} of what the file says: this machine's calibration over the file's\n", scale);
}

}  // namespace

Status run_budget(const BudgetOptions& options) {
    if (options.budget.empty() && options.write.empty())
        return usage_error("--budget FILE to hold one, --write FILE to make one: neither is given");
    std::optional<budget::Budget> budget;
    if (!options.budget.empty()) {
        FF_ASSIGN(budget, read_budget(options.budget));
    }
    if (worker_count() == 1) set_work_clock(WorkClock::thread);
    const Stopwatch watch;
    FF_ASSIGN(const std::unique_ptr<Session> session,
              Session::open(options.view, std::span(&options.view.frame.mode, 1)));
    const std::size_t all = session->walk().frames.size();
    const std::size_t frames = options.max_frames > 0 ? std::min(std::size_t(options.max_frames), all) : all;
    if (frames <= kWarmUpFrames)
        return usage_error(
            fmt::format("{} frames: expected more than {}, for those do not count", frames, kWarmUpFrames));
    BudgetRun run(*session, options.view.size, frames);
    FF_ASSIGN(const std::vector<Verdict> verdicts,
              measure(run, budget ? &*budget : nullptr, options.laps, std::max(options.laps, options.max_laps)));

    const std::string suite = fmt::format("{}, walk {}", session->world().info().name, session->walk().name);
    const Verdict* worst = worst_of(verdicts);
    if (!options.trace.empty()) FF_TRY(write_trace(options.trace, run.trace()));
    if (!options.junit.empty())
        FF_TRY(write_file_whole(options.junit, budget::to_junit(verdicts, suite, watch.seconds())));
    if (!options.write.empty()) {
        const std::string comment = fmt::format("{}, {}x{}, {} laps, times with a margin of {} %; {}, {} threads",
                                                suite, options.view.size.width, options.view.size.height, run.laps(),
                                                options.margin_pct, cpu_name(), worker_count());
        const budget::Budget made = budget::make_budget(run.figures(), run.calibration_ms(), 1e-2 * options.margin_pct);
        FF_TRY(write_file_whole(options.write, budget::to_text(made, comment)));
        log_info("{}: {} limits", options.write.string(), made.limits.size());
    }
    json report = report_of(*session, run, options, budget, verdicts);
    if (options.json || worst != nullptr)
        FF_TRY(add_frames(*session, run.renderer(), run.settings(), options.view.size, run.series(), report));
    if (options.json)
        fmt::print("{}\n", report.dump(1));
    else
        print_table(verdicts, report["calibration"]["scale"].get<double>());
    if (worst == nullptr) return {};

    const auto missed = std::count_if(verdicts.begin(), verdicts.end(), [](const Verdict& v) { return !v.held(); });
    const std::string text =
        fmt::format("{}: {} of {} limits missed, worst {}", suite, missed, verdicts.size(), budget::to_text(*worst));
    FF_TRY(keep_miss(*session, run, options, *worst, text, report));
    return Error{ErrorKind::limit, fmt::format("{}; its picture, plan and trace: {}", text,
                                               std::filesystem::absolute(keep_folder(options)).string())};
}

}  // namespace ff::tool
