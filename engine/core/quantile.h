#pragma once
// Order statistics of what is measured, the same in every report.

#include <algorithm>
#include <cmath>
#include <vector>

namespace ff {

/// The value that a share of all values do not exceed (nearest rank).
/// @param values  at least one
/// @param share   (0, 1]
[[nodiscard]] inline double quantile_of(std::vector<double> values, double share) {
    const auto rank = std::size_t(std::ceil(share * double(values.size()))) - 1;
    std::nth_element(values.begin(), values.begin() + std::ptrdiff_t(rank), values.end());
    return values[rank];
}

/// The middle value; of an even number the greater of the two. @param values  at least one
[[nodiscard]] inline double median_of(std::vector<double> values) {
    const auto middle = values.begin() + std::ptrdiff_t(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    return *middle;
}

}  // namespace ff
