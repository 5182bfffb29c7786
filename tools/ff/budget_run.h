#pragma once
// A walk measured for a budget: laps until every limit holds or its figure has come to rest.
//
// A machine that others use slows frames down by chance and for minutes. Four things keep a verdict apart from that:
//   - with one worker, the tool's choice unless another is asked for, times are what the thread has run: the time in
//     which somebody else had its core is not in them (core/work_clock.h);
//   - a frame's time, and a pass's in it, is the least of its laps (budget/lap_table.h);
//   - before each frame the calibration (budget/calibration.h) runs, and is treated alike: limits are scaled by it, so
//     that what slows down all of a run is nobody's fault;
//   - figures only come down as laps are added. So what holds a limit may stop, and what misses one is looked at again
//     until it stays where it is (has_come_to_rest).

#include <vector>

#include "engine/budget/budget_check.h"
#include "engine/budget/calibration.h"
#include "engine/budget/lap_table.h"
#include "engine/debug/trace.h"
#include "tools/ff/session.h"
#include "tools/report/frame_series.h"

namespace ff::tool {

class BudgetRun {
  public:
    /// Borrows the session. @param frames  of the walk that are drawn, more than kWarmUpFrames, which do not count
    BudgetRun(Session& session, const ImageSize& size, std::size_t frames);

    /// One lap more. Errors: what the renderer refuses.
    Status lap();
    [[nodiscard]] std::size_t laps() const { return table_.laps(); }

    /// Frames, passes, effects, in milliseconds of this machine; work of the frame that takes most.
    [[nodiscard]] std::vector<budget::Figure> figures() const;
    /// Mean of a frame.
    [[nodiscard]] double calibration_ms() const;

    /// Every frame with these times.
    [[nodiscard]] report::FrameSeries series() const;
    /// Of the last lap.
    [[nodiscard]] const debug::Trace& trace() const { return trace_; }
    [[nodiscard]] frame::Renderer& renderer() { return *renderer_; }
    /// Those of the session, but deciding from recorded costs: the same work on every machine and in every lap. With a
    /// time per frame they decide as they do for users.
    [[nodiscard]] const frame::FrameSettings& settings() const { return settings_; }

  private:
    /// Where the frame of the walk stands in which a figure is worst, and its mean over the frames that count.
    [[nodiscard]] budget::Figure mean_of(budget::LimitKind kind, std::string_view key, std::size_t column) const;

    Session& session_;
    ImageSize size_;
    frame::FrameSettings settings_;
    std::unique_ptr<frame::Renderer> renderer_;
    shading::Image image_;
    budget::Calibration calibration_;
    budget::LapTable table_;
    std::vector<frame::FrameStats> stats_;  ///< of the last lap
    std::vector<report::FrameWork> work_;   ///< likewise, but for the fewest allocations of all laps
    debug::Trace trace_;
};

/// Laps as the options ask for them.
/// @param budget  that is to be held; nullptr: all of `max_laps`
/// @return a verdict a limit
Result<std::vector<budget::Verdict>> measure(BudgetRun& run, const budget::Budget* budget, int laps, int max_laps);

}  // namespace ff::tool
