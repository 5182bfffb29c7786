#pragma once
// A loss of time put into one pass on purpose, to see that budgets catch it (tests/bench/budget_trial.cpp). Only that
// program's build of this module knows FF_PLANTED_LOSS; in all others nothing is left of it.

#include <cstdint>

#include "engine/core/work_clock.h"
#include "engine/frame/stats.h"

namespace ff::frame {

#ifdef FF_PLANTED_LOSS
/// Which pass loses, and how much of its own time; set before the first frame.
struct PlantedLoss {
    Pass pass = Pass::plan;
    double share = 0.0;  ///< 0.1: it takes 1.1 times as long
};
PlantedLoss& planted_loss();
#endif

/// What a pass took, on the clock of work_ns(). Waits where it is to lose time.
[[nodiscard]] inline std::int64_t with_planted_loss([[maybe_unused]] Pass pass, std::int64_t work) {
#ifdef FF_PLANTED_LOSS
    if (pass == planted_loss().pass) {
        const std::int64_t begin = work_ns(), loss = std::int64_t(planted_loss().share * double(work));
        std::int64_t lost = 0;
        while (lost < loss) lost = work_ns() - begin;
        work += lost;
    }
#endif
    return work;
}

}  // namespace ff::frame
