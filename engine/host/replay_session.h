#pragma once
// A recorded session run again.

#include <memory>
#include <optional>

#include "engine/host/game.h"
#include "engine/replay/recording.h"

namespace ff::host {

/// Where a replay left what was recorded.
struct Divergence {
    std::uint64_t tick = 0;               ///< the first one after which the states differ
    std::optional<std::uint32_t> entity;  ///< index, where a single one explains it
    std::string description;              ///< of it
};

class ReplaySession {
  public:
    /// Borrows all but the game; they must outlive it. Errors (bad input): of another game or tick rate, of another
    /// world unless `any_world`, a start that cannot be loaded.
    static Result<ReplaySession> begin(const GameInfo& info, const scene::World& world,
                                       const replay::Recording& recording, bool any_world = false);

    /// The next recorded tick. @return false after the last one
    bool step();
    [[nodiscard]] std::uint64_t tick() const { return tick_; }  ///< steps made
    [[nodiscard]] Game& game() { return *game_; }
    /// The first difference so far.
    [[nodiscard]] const std::optional<Divergence>& divergence() const { return divergence_; }

  private:
    ReplaySession(std::unique_ptr<Game> game, const replay::Recording& recording)
        : game_(std::move(game)), recording_(&recording) {}

    std::unique_ptr<Game> game_;
    const replay::Recording* recording_;
    std::uint64_t tick_ = 0;
    std::optional<Divergence> divergence_;
};

/// "differs first after tick 41 (0.3 s), in boat 2"
[[nodiscard]] std::string to_text(const Divergence& divergence);

}  // namespace ff::host
