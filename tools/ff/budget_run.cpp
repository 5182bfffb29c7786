#include "tools/ff/budget_run.h"

#include <algorithm>
#include <cmath>

#include "engine/core/log.h"
#include "tools/ff/walk_lap.h"

namespace ff::tool {
namespace {

using budget::Figure;
using budget::LimitKind;

// Columns of the table: the frame, the calibration before it, its passes, its effects.
constexpr std::size_t kFrameColumn = 0, kCalibrationColumn = 1, kPassColumn = 2,
                      kEffectColumn = kPassColumn + frame::kPassCount, kColumns = kEffectColumn + effects::kEffectCount;

/// Whether limits that are missed stay so: none of them has come down by a third of a percent since as many laps ago as
/// are made at least.
bool has_come_to_rest(std::span<const budget::Verdict> before, std::span<const budget::Verdict> now) {
    constexpr double kRest = 0.0033;
    if (before.size() != now.size()) return false;
    for (std::size_t i = 0; i < now.size(); ++i)
        if (!now[i].held() && !(now[i].excess() > before[i].excess() - kRest)) return false;
    return true;
}

}  // namespace

BudgetRun::BudgetRun(Session& session, const ImageSize& size, std::size_t frames)
    : session_(session),
      size_(size),
      settings_(session.settings()),
      renderer_(session.make_renderer(size)),
      table_(frames, kColumns),
      stats_(frames),
      work_(frames),
      trace_(frames) {
    // Who asks for a time per frame gets what the controller makes of it here, which differs from machine to machine.
    settings_.deterministic |= settings_.budget_ms <= 0.0;
}

Status BudgetRun::lap() {
    table_.add_lap();
    trace_ = debug::Trace(table_.frames());
    const bool is_first = table_.laps() == 1;
    const auto calibrate = [&](std::size_t f) { table_.at(f, kCalibrationColumn) = calibration_.run(); };
    const auto keep = [&](const LapFrame& drawn) {
        const frame::FrameStats& stats = drawn.stats;
        table_.at(drawn.frame, kFrameColumn) = drawn.ms;
        for (std::size_t p = 0; p < frame::kPassCount; ++p) table_.at(drawn.frame, kPassColumn + p) = stats.pass_ms[p];
        for (std::size_t e = 0; e < effects::kEffectCount; ++e)
            table_.at(drawn.frame, kEffectColumn + e) = stats.effect_work[e].ms;
        report::FrameWork& work = work_[drawn.frame];
        const std::uint64_t allocations =
            is_first ? drawn.allocations : std::min(work[report::kAllocations], drawn.allocations);
        work = report::work_of(stats, allocations, drawn.upload_bytes);
        stats_[drawn.frame] = stats;
        trace_.add(drawn.frame, drawn.allocations, stats);
    };
    return draw_lap(session_, *renderer_, settings_, size_, table_.frames(), image_, calibrate, keep);
}

Figure BudgetRun::mean_of(LimitKind kind, std::string_view key, std::size_t column) const {
    Figure figure{.kind = kind, .key = std::string(key), .value = 0.0, .frame = kWarmUpFrames};
    double worst = 0.0;
    for (std::size_t f = kWarmUpFrames; f < table_.frames(); ++f) {
        const double ms = table_.least(f, column);
        figure.value += ms / double(table_.frames() - kWarmUpFrames);
        if (ms > worst) figure.frame = f;
        worst = std::max(worst, ms);
    }
    return figure;
}

double BudgetRun::calibration_ms() const {
    return mean_of(LimitKind::time, "", kCalibrationColumn).value;
}

std::vector<Figure> BudgetRun::figures() const {
    std::vector<Figure> figures;
    std::vector<std::pair<double, std::size_t>> frames;  // time and number, fastest first
    for (std::size_t f = kWarmUpFrames; f < table_.frames(); ++f) frames.emplace_back(table_.least(f, kFrameColumn), f);
    std::sort(frames.begin(), frames.end());
    const auto time = [&](std::size_t key, std::size_t rank) {
        figures.push_back({.kind = LimitKind::time,
                           .key = std::string(budget::kTimeKeys[key]),
                           .value = frames[rank].first,
                           .frame = frames[rank].second});
    };
    time(0, frames.size() / 2);
    time(1, std::size_t(std::ceil(0.99 * double(frames.size()))) - 1);
    time(2, frames.size() - 1);
    for (std::size_t p = 0; p < frame::kPassCount; ++p)
        figures.push_back(mean_of(LimitKind::pass, frame::kPassNames[p], kPassColumn + p));
    for (std::size_t e = 0; e < effects::kEffectCount; ++e)
        figures.push_back(mean_of(LimitKind::effect, report::effect_names()[e], kEffectColumn + e));
    for (std::size_t w = 0; w < budget::kWorkKeys.size(); ++w) {
        const auto by_work = [w](const report::FrameWork& a, const report::FrameWork& b) { return a[w] < b[w]; };
        const auto most = std::max_element(work_.begin() + kWarmUpFrames, work_.end(), by_work);
        figures.push_back({.kind = LimitKind::work,
                           .key = std::string(budget::kWorkKeys[w]),
                           .value = double((*most)[w]),
                           .frame = std::size_t(most - work_.begin())});
    }
    return figures;
}

report::FrameSeries BudgetRun::series() const {
    report::FrameSeries series(table_.frames());
    for (std::size_t f = 0; f < table_.frames(); ++f) {
        series.add(session_.walk().camera(f), table_.least(f, kFrameColumn), work_[f], stats_[f]);
        for (std::size_t p = 0; p < frame::kPassCount; ++p) series.set_pass_ms(f, p, table_.least(f, kPassColumn + p));
        for (std::size_t e = 0; e < effects::kEffectCount; ++e)
            series.set_effect_ms(f, e, table_.least(f, kEffectColumn + e));
    }
    return series;
}

Result<std::vector<budget::Verdict>> measure(BudgetRun& run, const budget::Budget* budget, int laps, int max_laps) {
    Progress progress("measuring", std::uint64_t(budget != nullptr ? laps : max_laps));
    std::vector<budget::Verdict> verdicts, before;
    while (run.laps() < std::size_t(max_laps)) {
        FF_TRY(run.lap());
        progress.advance();
        if (budget == nullptr || run.laps() < std::size_t(laps)) continue;
        const double scale = budget->calibration_ms ? run.calibration_ms() / *budget->calibration_ms : 1.0;
        const bool looks_back = (run.laps() - std::size_t(laps)) % std::size_t(laps) == 0;
        verdicts = budget::check(*budget, run.figures(), scale);
        const bool is_held =
            std::all_of(verdicts.begin(), verdicts.end(), [](const budget::Verdict& v) { return v.held(); });
        // Work is the same in every lap.
        const bool misses_work = std::any_of(verdicts.begin(), verdicts.end(), [](const budget::Verdict& v) {
            return !v.held() && v.limit.kind == LimitKind::work;
        });
        if (is_held || misses_work || (looks_back && has_come_to_rest(before, verdicts))) break;
        if (looks_back) before = verdicts;
    }
    return verdicts;
}

}  // namespace ff::tool
