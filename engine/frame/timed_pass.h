#pragma once

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

}  // namespace ff::frame
