#pragma once
// All of the lab's work on one walk of one scene: every knob by itself, the best pairs of them, and which settings are
// beaten by none.

#include "engine/frame/knobs.h"
#include "tools/accuracy/measure.h"

namespace ff::accuracy {

/// A knob and what each of its values costs and gives, in the table's order.
struct KnobCurve {
    const frame::Knob* knob = nullptr;
    std::vector<Point> points;
    std::string says;  ///< a sentence: what a millisecond buys here
};

struct Sweep {
    Point exact;  ///< no knob turned
    std::vector<KnobCurve> curves;
    std::vector<Point> pairs;   ///< two knobs at once
    std::vector<Point> pareto;  ///< none is as fast and looks better; the fastest first
    std::size_t schedule_frames = 0, counted_frames = 0;
};

/// Errors: a knob table that contradicts itself, the cache cannot be written.
Result<Sweep> sweep(const Bench& bench, int pairs);

/// Points that no other beats in both time (against exact frames of the same laps) and FLIP; the fastest first. An
/// error less by under a hundredth is no reason to take longer.
[[nodiscard]] std::vector<const Point*> pareto_front(std::span<const Point* const> points);

/// Two-knob settings that promise most: from values that save time by themselves, those pairs of different knobs that
/// would be on the front if times multiplied and errors added. Of two knobs of one technique, what the technique itself
/// saves and spoils counts once; a pair of which one knob would have no effect is none.
/// @param singles  one knob turned each
/// @param exact    none turned
[[nodiscard]] std::vector<KnobSettings> promising_pairs(std::span<const Point* const> singles, const Point& exact,
                                                        std::size_t count);

/// What a curve says in one sentence, against the point where the knob stands at its default.
[[nodiscard]] std::string say(const frame::Knob& knob, std::span<const Point> points);

}  // namespace ff::accuracy
