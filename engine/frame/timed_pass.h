#pragma once

#include "engine/core/heap_count.h"
#include "engine/core/work_clock.h"
#include "engine/frame/planted_loss.h"
#include "engine/frame/stats.h"

namespace ff::frame {

/// Times a pass from its making to its end.
class TimedPass {
  public:
    TimedPass(FrameStats& stats, Pass pass) : stats_(stats), pass_(pass) {}
    ~TimedPass() {
        stats_.ms(pass_) += 1e-6 * double(with_planted_loss(pass_, work_ns() - begin_work_ns_));
        stats_.log.add({.begin_ns = begin_ns_, .end_ns = steady_ns(), .index = std::uint8_t(pass_)});
    }
    TimedPass(const TimedPass&) = delete;
    TimedPass& operator=(const TimedPass&) = delete;

  private:
    FrameStats& stats_;
    Pass pass_;
    std::int64_t begin_ns_ = steady_ns(), begin_work_ns_ = work_ns();
};

/// Times an effect, beside the pass that it is part of, and counts what it takes from the heap.
class TimedEffect {
  public:
    TimedEffect(FrameStats& stats, effects::EffectId effect)
        : stats_(stats), effect_(effect), allocations_(heap_allocation_count()) {}
    ~TimedEffect() {
        effects::Work& work = stats_.work(effect_);
        work.ms += 1e-6 * double(work_ns() - begin_work_ns_);
        work.allocations += heap_allocation_count() - allocations_;
        stats_.log.add(
            {.begin_ns = begin_ns_, .end_ns = steady_ns(), .index = std::uint8_t(effect_), .is_effect = true});
    }
    TimedEffect(const TimedEffect&) = delete;
    TimedEffect& operator=(const TimedEffect&) = delete;

  private:
    FrameStats& stats_;
    effects::EffectId effect_;
    std::uint64_t allocations_;
    std::int64_t begin_ns_ = steady_ns(), begin_work_ns_ = work_ns();
};

}  // namespace ff::frame
