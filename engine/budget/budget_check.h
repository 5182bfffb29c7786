#pragma once
// What was measured, held against a budget.

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "engine/budget/budget_file.h"

namespace ff::budget {

/// One figure of a walk.
struct Figure {
    LimitKind kind = LimitKind::time;
    std::string key;
    double value = 0.0;
    std::size_t frame = 0;  ///< where it is worst
};

/// A limit, and how it was kept.
struct Verdict {
    Limit limit;
    double allowed = 0.0;   ///< the limit, of times for this machine's speed
    double measured = 0.0;  ///< 0 where nothing of this kind was done
    std::size_t frame = 0;  ///< where it is worst

    [[nodiscard]] bool held() const { return measured <= allowed; }
    /// Measured over allowed, less one: 0.1 is a tenth too much.
    [[nodiscard]] double excess() const;
};

/// @param scale  this machine's calibration over the budget's: what time limits are multiplied by
/// @return a verdict a limit, in their order
[[nodiscard]] std::vector<Verdict> check(const Budget& budget, std::span<const Figure> figures, double scale);

/// Limits a margin above what was measured. Passes and effects that take less than a hundredth of the median frame
/// have none: they are too small to be measured to a margin.
/// @param margin  of times, 0.05: a twentieth; twice that for the 99th percentile and thrice for the worst frame, which
///                are single frames. Work is exact and gets none
[[nodiscard]] Budget make_budget(std::span<const Figure> figures, double calibration_ms, double margin);

/// "passes.cast.ms: 5.61 of 5.10 ms (+10.0 %), worst in frame 37"
[[nodiscard]] std::string to_text(const Verdict& verdict);

/// The verdicts as a JUnit report, a test case a limit.
/// @param suite  its name; @param seconds  that it took
[[nodiscard]] std::string to_junit(std::span<const Verdict> verdicts, std::string_view suite, double seconds);

}  // namespace ff::budget
