#include "engine/core/quantile.h"

#include <gtest/gtest.h>

#include <numeric>
#include <vector>

namespace ff {
namespace {

TEST(Quantile, is_the_nearest_rank_whatever_the_order) {
    std::vector<double> values(200);
    std::iota(values.rbegin(), values.rend(), 1.0);  // 200 .. 1
    EXPECT_EQ(quantile_of(values, 0.99), 198.0);
    EXPECT_EQ(quantile_of(values, 1.0), 200.0);
    EXPECT_EQ(quantile_of(values, 0.001), 1.0);
    EXPECT_EQ(median_of(values), 101.0);
}

TEST(Quantile, one_value_is_all_of_them) {
    std::vector<double> one{3.0};
    EXPECT_EQ(quantile_of(one, 0.99), 3.0);
    EXPECT_EQ(median_of(one), 3.0);
}

}  // namespace
}  // namespace ff
