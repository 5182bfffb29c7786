#include "engine/budget/cost_model.h"

#include <algorithm>
#include <cmath>

namespace ff::budget {

void UnitCost::observe(double ms, double units) {
    if (!(units >= kMinUnits) || !std::isfinite(ms) || ms < 0.0) return;
    recent_[std::size_t(next_)] = 1e6 * ms / units;
    next_ = (next_ + 1) % kWindow;
    count_ = std::min(count_ + 1, kWindow);
    auto sorted = recent_;
    const auto middle = sorted.begin() + count_ / 2;
    std::nth_element(sorted.begin(), middle, sorted.begin() + count_);
    value_ns_ = *middle;
}

}  // namespace ff::budget
