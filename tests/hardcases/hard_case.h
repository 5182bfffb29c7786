#pragma once
// Hard cases: inputs on which numbers go wrong, each with an oracle that is exact or of higher precision, and with a
// bound that it is held to. `ff hardcases` prints them as a table; CTest runs each with fewer instances.
//
//   HardCase (a row of the table)  --run_case-->  Outcome (what was measured)  --broken_bound-->  what it exceeds
//
// A case is a function that makes random instances until its Trial has enough, and counts each of them.

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <utility>

#include "engine/core/log.h"

namespace ff::hardcases {

/// What a run of a case found.
struct Outcome {
    std::uint64_t instances = 0;
    std::uint64_t failures = 0;
    double worst_error = 0.0;   ///< in the case's unit; of instances that did not fail outright
    double time_ratio = 0.0;    ///< processor time by that of as many ordinary inputs; 0: not measured
    std::string first_failure;  ///< which instance, with its seed; empty: none
    std::string skipped;        ///< why the case could not run here; empty: it ran
};

/// The bookkeeping of one run: random seeds in, counts and times out.
class Trial {
  public:
    /// @param progress  may be null
    Trial(std::uint64_t instances, std::uint32_t seed, Progress* progress)
        : wanted_(instances), seed_(seed), progress_(progress) {}

    [[nodiscard]] bool done() const { return outcome_.instances >= wanted_ || !outcome_.skipped.empty(); }
    [[nodiscard]] std::uint64_t left() const { return done() ? 0 : wanted_ - outcome_.instances; }

    /// The seed of the next round of instances; the same run gives the same ones.
    [[nodiscard]] std::uint32_t next_seed() { return round_seed_ = seed_ + 0x9E3779B9u * round_++; }

    /// Counts an instance. An error above the case's bound is a breach even where the instance is not a failure.
    /// @param describe  () -> std::string, called at the first failure
    template <class Describe>
    void count(bool is_right, double error, Describe&& describe) {
        ++outcome_.instances;
        if (is_right) {
            if (!(error <= outcome_.worst_error)) outcome_.worst_error = error;
        } else if (outcome_.failures++ == 0) {
            outcome_.first_failure = describe() + seed_note();
        }
    }

    /// Tells the progress bar of what was counted; once a round.
    void report() {
        if (progress_ != nullptr) progress_->advance(outcome_.instances - reported_);
        reported_ = outcome_.instances;
    }

    /// Runs work on hard inputs, and on as many ordinary ones, and takes the processor time of both. Call them in turns
    /// within a round, so that a slow machine slows both.
    template <class Body>
    void time_hard(Body&& body) {
        hard_s_ += seconds_of(std::forward<Body>(body));
    }
    template <class Body>
    void time_easy(Body&& body) {
        easy_s_ += seconds_of(std::forward<Body>(body));
    }

    void skip(std::string reason) { outcome_.skipped = std::move(reason); }

    [[nodiscard]] Outcome outcome() const;

  private:
    template <class Body>
    static double seconds_of(Body&& body) {
        const double start = processor_seconds();
        body();
        return processor_seconds() - start;
    }
    static double processor_seconds();  // of the whole process
    [[nodiscard]] std::string seed_note() const;

    std::uint64_t wanted_;
    std::uint32_t seed_, round_ = 0, round_seed_ = 0;
    Progress* progress_;
    std::uint64_t reported_ = 0;
    double hard_s_ = 0.0, easy_s_ = 0.0;
    Outcome outcome_;
};

/// A row of the table.
struct HardCase {
    std::string_view name;
    std::string_view what;       ///< the inputs, and what must hold
    std::string_view oracle;     ///< what says what is right
    std::string_view unit;       ///< of the worst error; empty: instances are right or wrong
    std::uint64_t instances;     ///< of a full run
    double max_failure_rate;     ///< failures by instances
    double max_worst_error = 0;  ///< in `unit`
    double max_time_ratio = 0;   ///< 0: not timed
    void (*run)(Trial&);
};

/// All of them, in the order in which they are printed.
[[nodiscard]] std::span<const HardCase> all_cases();

/// @param instances  at least so many; 0: those of a full run
[[nodiscard]] Outcome run_case(const HardCase& hard_case, std::uint64_t instances, std::uint32_t seed,
                               Progress* progress = nullptr);

/// The first bound that the outcome exceeds, as a sentence; empty: it holds them all.
/// @param with_time  whether the time ratio counts; it says little of few instances
[[nodiscard]] std::string broken_bound(const HardCase& hard_case, const Outcome& outcome, bool with_time);

}  // namespace ff::hardcases
