#include "engine/budget/governor.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

namespace ff::budget {
namespace {

Outlook street_outlook() {
    Outlook outlook;
    outlook.pixels = 307200;
    outlook.sky_pixels = 70000;
    for (std::size_t i = 0; i < kNearDistances.size(); ++i) {
        outlook.near_triangles[i] = 40.0 * kNearDistances[i] * kNearDistances[i] * 0.01;
        outlook.near_pixels[i] = 230000.0 * (1.0 - std::exp(-kNearDistances[i] / 60.0));
    }
    outlook.horizon_azimuths = 300;
    return outlook;
}

/// Times as a shared machine gives them: noisy, one in twenty ten times too long.
class NoisyClock {
  public:
    NoisyClock(unsigned seed, double sigma) : random_(seed), noise_(0.0, sigma) {}
    double operator()(double ns) {
        const double noisy = ns * noise_(random_);
        return spike_(random_) ? 10.0 * noisy : noisy;
    }

  private:
    std::mt19937 random_;
    std::lognormal_distribution<double> noise_;
    std::bernoulli_distribution spike_{0.05};
};

TEST(Governor, keeps_the_near_field_off_where_opengl_is_dear) {
    Governor governor;
    CostModel costs;  // those of a machine without a GPU
    Choice choice;
    for (int i = 0; i < 50; ++i) choice = governor.choose(street_outlook(), costs, 0.0);
    EXPECT_EQ(choice.near_m, 0.0);
}

TEST(Governor, rasterises_where_opengl_is_cheap) {
    Governor governor;
    CostModel costs;
    costs.near_fixed_ms = 0.1;
    costs.near_triangle = UnitCost(0.3);
    Choice choice;
    for (int i = 0; i < 50; ++i) choice = governor.choose(street_outlook(), costs, 0.0);
    EXPECT_GE(choice.near_m, 50.0);
}

TEST(Governor, does_not_oscillate_under_noisy_costs_with_spikes) {
    for (unsigned seed = 0; seed < 50; ++seed) {
        SCOPED_TRACE(seed);
        NoisyClock measured(seed, 0.3);
        Governor governor;
        CostModel costs;
        costs.near_fixed_ms = 0.2;
        int switches = 0;
        double last = -1.0;
        for (int frame = 0; frame < 1000; ++frame) {
            costs.cast_ray.observe(1e-6 * measured(4.0) * 2e5, 2e5);
            costs.near_triangle.observe(1e-6 * measured(1.0) * 1e4, 1e4);
            const Choice choice = governor.choose(street_outlook(), costs, 0.0);
            switches += choice.near_m != last ? 1 : 0;
            last = choice.near_m;
        }
        EXPECT_LE(switches, 4);  // the first choice, and a few while the costs are learned
    }
}

TEST(Governor, keeps_the_predicted_time_within_the_budget_by_casting_less) {
    Governor governor;
    CostModel costs;
    costs.cast_ray = UnitCost(40.0);
    Choice choice;
    for (int i = 0; i < 100; ++i) choice = governor.choose(street_outlook(), costs, 6.0, WhenLate::stale);
    EXPECT_LE(choice.predicted_ms, 6.0);
    EXPECT_LT(choice.ray_budget, 307200u);
    EXPECT_TRUE(choice.look_up_panorama);
    EXPECT_EQ(choice.resolution, 1.0);
}

TEST(Governor, keeps_the_predicted_time_within_the_budget_by_drawing_smaller) {
    Governor governor;
    CostModel costs;
    costs.cast_ray = UnitCost(40.0);
    Choice choice;
    for (int i = 0; i < 100; ++i) choice = governor.choose(street_outlook(), costs, 6.0);
    EXPECT_LE(choice.predicted_ms, 6.0);
    EXPECT_LT(choice.resolution, 1.0);
    EXPECT_GE(choice.resolution, kResolutions.back());
    EXPECT_FALSE(choice.look_up_panorama);
    EXPECT_EQ(choice.ray_budget, UINT64_MAX) << "of the smaller picture no pixel is left out";
}

TEST(Governor, holds_the_resolution_under_noisy_costs_with_spikes) {
    for (unsigned seed = 0; seed < 50; ++seed) {
        SCOPED_TRACE(seed);
        NoisyClock measured(seed, 0.2);
        Governor governor;
        CostModel costs;
        int changes = 0;
        double last = 1.0;
        for (int frame = 0; frame < 1000; ++frame) {
            costs.cast_ray.observe(1e-6 * measured(40.0) * 2e5, 2e5);
            const Choice choice = governor.choose(street_outlook(), costs, 6.0);
            changes += choice.resolution != last ? 1 : 0;
            last = choice.resolution;
        }
        EXPECT_LE(changes, 60) << "in 1000 frames: a few as the costs are learned, else one in 20 at most";
    }
}

TEST(Governor, casts_everything_when_the_budget_is_ample_or_absent) {
    for (const double budget_ms : {0.0, 1000.0}) {
        Governor governor;
        const CostModel costs;
        const Choice choice = governor.choose(street_outlook(), costs, budget_ms);
        EXPECT_GE(choice.ray_budget, 237200u);
    }
}

TEST(Governor, moves_the_ray_budget_by_bounded_steps) {
    Governor governor;
    CostModel cheap;
    CostModel dear;
    dear.cast_ray = UnitCost(400.0);
    const auto rays = [&](const CostModel& costs) {
        return double(governor.choose(street_outlook(), costs, 5.0, WhenLate::stale).ray_budget);
    };
    double last = rays(cheap);
    for (int frame = 0; frame < 200; ++frame) {
        const double now = rays(frame % 2 == 0 ? dear : cheap);
        EXPECT_LE(now, last * Governor::kRayStep + 1.0);
        EXPECT_GE(now, last / Governor::kRayStep - 1.0);
        last = now;
    }
}

TEST(UnitCost, ignores_what_is_not_a_time_and_recovers_from_spikes) {
    UnitCost cost(10.0);
    cost.observe(std::numeric_limits<double>::quiet_NaN(), 1e6);
    cost.observe(std::numeric_limits<double>::infinity(), 1e6);
    cost.observe(-1.0, 1e6);
    cost.observe(5.0, 0.0);
    EXPECT_EQ(cost.ns(), 10.0);
    for (int i = 0; i < 9; ++i) cost.observe(i % 3 == 0 ? 100.0 : 2.0, 1e6);
    EXPECT_DOUBLE_EQ(cost.ns(), 2.0);
}

}  // namespace
}  // namespace ff::budget
