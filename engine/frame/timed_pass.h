#pragma once

#include "engine/core/heap_count.h"
#include "engine/core/stopwatch.h"
#include "engine/frame/stats.h"

namespace ff::frame {

/// Times a pass from its making to its end.
class TimedPass {
  public:
    TimedPass(FrameStats& stats, Pass pass) : stats_(stats), pass_(pass) {}
    ~TimedPass() { stats_.ms(pass_) += watch_.milliseconds(); }
    TimedPass(const TimedPass&) = delete;
    TimedPass& operator=(const TimedPass&) = delete;

  private:
    FrameStats& stats_;
    Pass pass_;
    Stopwatch watch_;
};

/// Times an effect, beside the pass that it is part of, and counts what it takes from the heap.
class TimedEffect {
  public:
    TimedEffect(FrameStats& stats, effects::EffectId effect)
        : work_(stats.work(effect)), allocations_(heap_allocation_count()) {}
    ~TimedEffect() {
        work_.ms += watch_.milliseconds();
        work_.allocations += heap_allocation_count() - allocations_;
    }
    TimedEffect(const TimedEffect&) = delete;
    TimedEffect& operator=(const TimedEffect&) = delete;

  private:
    effects::Work& work_;
    std::uint64_t allocations_;
    Stopwatch watch_;
};

}  // namespace ff::frame
