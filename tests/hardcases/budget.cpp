// The budget controller and the frame plan while costs are zero, tiny, huge, noisy, or lies: choices stay within their
// ranges and do not oscillate, and once the costs are honest again they are what they would have been.

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "engine/budget/governor.h"
#include "engine/frame/history.h"
#include "engine/frame/plan.h"
#include "tests/hardcases/cases.h"
#include "tests/support/worlds.h"

namespace ff::hardcases {
namespace {

using budget::Choice;
using budget::CostModel;
using budget::Governor;
using budget::Outlook;
using budget::WhenLate;

constexpr int kTroubledFrames = 400;
constexpr int kHonestFrames = 150;  ///< to recover within: costs are known after 9, rays after 27, resolution after 64

enum class Trouble { zero, tiny, huge, noisy, lying, no_numbers, count };

/// What a machine says that a unit of work has cost, of which it has cost `true_ns`.
double reported_ns(test::Random& random, Trouble trouble, double true_ns) {
    constexpr double kNan = std::numeric_limits<double>::quiet_NaN(), kInf = std::numeric_limits<double>::infinity();
    switch (trouble) {
        case Trouble::zero:
            return 0.0;
        case Trouble::tiny:
            return 1e-9 * true_ns;
        case Trouble::huge:
            return 1e9 * true_ns;
        case Trouble::noisy:
            return true_ns * std::exp(random.in(-0.3, 0.3)) * (random.below(20) == 0 ? 10.0 : 1.0);
        case Trouble::lying:
            return true_ns * std::pow(10.0, random.in(-1.0, 1.0));
        default:
            return std::array{kNan, kInf, -kInf, -true_ns}[random.below(4)];
    }
}

/// What its work truly costs a machine, nanoseconds.
struct TrueCosts {
    double cast = 4.0, shade = 7.0, look_up = 2.0, triangle = 65.0;
};

void observe(test::Random& random, const TrueCosts& costs, Trouble trouble, bool is_honest, CostModel& model) {
    constexpr double kUnits = 1e5;
    const auto observed = [&](budget::UnitCost& cost, double true_ns) {
        const double ns = is_honest ? true_ns : reported_ns(random, trouble, true_ns);
        cost.observe(1e-6 * ns * kUnits, kUnits);
    };
    observed(model.cast_ray, costs.cast);
    observed(model.shade_pixel, costs.shade);
    observed(model.lookup_pixel, costs.look_up);
    observed(model.near_triangle, costs.triangle);
}

Outlook random_outlook(test::Random& random) {
    Outlook outlook;
    outlook.pixels = 307200;
    outlook.sky_pixels = random.in(0.0, 1.0) * outlook.pixels;
    for (std::size_t i = 0; i < budget::kNearDistances.size(); ++i) {
        outlook.near_triangles[i] = 0.4 * budget::kNearDistances[i] * budget::kNearDistances[i];
        outlook.near_pixels[i] =
            (outlook.pixels - outlook.sky_pixels) * (1.0 - std::exp(-budget::kNearDistances[i] / 60.0));
    }
    outlook.reusable_pixels = random.below(2) == 0 ? 0.0 : random.unit() * (outlook.pixels - outlook.sky_pixels);
    outlook.horizon_azimuths = 320;
    return outlook;
}

bool is_in_range(const Choice& choice, const Outlook& outlook) {
    const auto is_one_of = [](const auto& list, double value) {
        return std::find(list.begin(), list.end(), value) != list.end();
    };
    return is_one_of(budget::kNearDistances, choice.near_m) && is_one_of(budget::kResolutions, choice.resolution) &&
           choice.predicted_ms >= 0.0 && std::isfinite(choice.predicted_ms) && choice.affordable_rays >= 0.0 &&
           choice.affordable_rays <= 2.0 * outlook.pixels && choice.needed_rays >= 0.0;
}

/// Whether a choice is what the expected one is, but for what is held on purpose.
bool is_same(const Choice& choice, const Choice& expected) {
    // Who draws the whole picture holds it while it just fits; who draws less waits until there is room.
    if (expected.resolution == 1.0 && expected.affordable_rays < Governor::kFinerRoom * expected.needed_rays)
        return true;
    // A coarser step is left only where there is room enough: held choices may be one step apart. More rays than
    // are needed make no difference.
    const auto step = [](double resolution) {
        return std::find(budget::kResolutions.begin(), budget::kResolutions.end(), resolution) -
               budget::kResolutions.begin();
    };
    const auto share = [](const Choice& c) { return std::min(1.0, c.affordable_rays / std::max(1.0, c.needed_rays)); };
    return std::abs(step(choice.resolution) - step(expected.resolution)) <= 1 &&
           std::fabs(share(choice) - share(expected)) <= 0.3;
}

/// Changes of direction, which is what an eye sees as oscillation.
class Turns {
  public:
    void add(double value) {
        const double step = value - last_;
        if (step != 0.0 && step * direction_ < 0.0) ++turns_;
        if (step != 0.0) direction_ = step;
        last_ = value;
    }
    [[nodiscard]] int count() const { return turns_; }

  private:
    double last_ = 1.0, direction_ = 0.0;
    int turns_ = 0;
};

}  // namespace

void budget_choices(Trial& trial) {
    while (!trial.done()) {
        test::Random random(trial.next_seed());
        const auto trouble = Trouble(random.below(std::uint32_t(Trouble::count)));
        const WhenLate when_late = random.below(2) == 0 ? WhenLate::coarser : WhenLate::stale;
        const Outlook outlook = random_outlook(random);
        TrueCosts costs;
        costs.cast *= std::pow(10.0, random.in(-1.0, 1.5));
        costs.shade *= std::pow(10.0, random.in(-1.0, 1.0));
        const double budget_ms = random.below(4) == 0 ? 0.0 : std::pow(10.0, random.in(-1.0, 2.0));

        // What would be chosen by one who never saw trouble.
        Governor calm;
        CostModel calm_costs;
        Choice expected;
        for (int frame = 0; frame < kTroubledFrames + kHonestFrames; ++frame) {
            observe(random, costs, trouble, true, calm_costs);
            expected = calm.choose(outlook, calm_costs, budget_ms, when_late);
        }
        Governor governor;
        CostModel model;
        Turns resolution, near;
        for (int frame = 0; frame < kTroubledFrames + kHonestFrames; ++frame) {
            const bool is_honest = frame >= kTroubledFrames;
            observe(random, costs, trouble, is_honest, model);
            const Choice choice = governor.choose(outlook, model, budget_ms, when_late);
            if (!is_honest) {
                resolution.add(choice.resolution);
                near.add(1.0 + choice.near_m);
            }
            const bool is_last = frame + 1 == kTroubledFrames + kHonestFrames;
            const bool recovered = !is_last || is_same(choice, expected);
            const double turns = is_last ? 100.0 * std::max(resolution.count(), near.count()) / kTroubledFrames : 0.0;
            trial.count(is_in_range(choice, outlook) && recovered, turns, [&] {
                return fmt::format("frame {}, trouble {}, budget {} ms: resolution {}, {} rays; expected {}, {}", frame,
                                   int(trouble), budget_ms, choice.resolution, choice.affordable_rays,
                                   expected.resolution, expected.affordable_rays);
            });
        }
        trial.report();
    }
}

void budget_plans(Trial& trial) {
    constexpr int kWidth = 160, kHeight = 120;
    const scene::SceneData data = test::make_city({.cells = 2});
    const scene::StaticScene scene = data.view();
    while (!trial.done()) {
        test::Random random(trial.next_seed());
        const auto trouble = Trouble(random.below(std::uint32_t(Trouble::count)));
        const frame::FrameSettings settings{.budget_ms = std::pow(10.0, random.in(-9.0, 6.0)),
                                            .when_late = random.below(2) == 0 ? WhenLate::coarser : WhenLate::stale};
        frame::FrameHistory history;
        history.can_rasterise = random.below(2) == 0;
        history.reset(kWidth, kHeight);
        const bool walks = random.below(2) == 0;
        Camera camera{.position = {0.0, 1.7, 0.0}};
        frame::FramePlan plan;
        for (int frame = 0; frame < kTroubledFrames; ++frame) {
            if (walks) camera.position.x += 0.05;
            camera.yaw += 0.01;
            plan_frame(scene, {}, {}, camera, kWidth, kHeight, settings, history, plan);
            const bool is_right = plan.view.width >= 1 && plan.view.width <= kWidth && plan.view.height >= 1 &&
                                  plan.view.height <= kHeight && plan.near_m >= 0.0 && plan.near_m <= 800.0 &&
                                  std::isfinite(plan.predicted_ms) && plan.view.u_step > 0.0f;
            trial.count(is_right, 0.0, [&] { return fmt::format("frame {}: {}", frame, to_text(plan)); });
            // As the renderer would after drawing it.
            observe(random, {}, trouble, false, history.costs);
            history.last_stats.pixels.sky = random.below(kWidth * kHeight);
            history.last_view = plan.view;
            history.panorama_is_full = random.below(4) != 0;
            history.has_frame = true;
            ++history.frame_number;
        }
        trial.report();
    }
}

}  // namespace ff::hardcases
