#pragma once

#include <filesystem>
#include <memory>
#include <string_view>

#include "engine/core/result.h"
#include "engine/replay/recording.h"

namespace ff::replay {

/// Writes a session as it happens. A command is in the system's hands before its tick runs, so whatever ends the
/// process, the file replays up to there. Steady ticks allocate nothing.
class Recorder {
  public:
    /// Errors: the folder cannot be written; the message names it.
    static Result<Recorder> create(const std::filesystem::path& path, const SessionHeader& header);

    Recorder(Recorder&&) noexcept;
    Recorder& operator=(Recorder&&) noexcept;
    /// As close(), without saying whether it worked.
    ~Recorder();

    /// Before the tick.
    void begin_tick(const loop::UserCommand& command);
    /// After it.
    void end_tick(const StateDigest& digest);
    /// @param comment  cut after Recording::kMaxCommentBytes
    void mark(std::string_view comment);
    /// Errors: something could not be written, the disk is full. The game goes on without a recording from there on.
    Status close();

    /// Success, or why recording has ended.
    [[nodiscard]] const Status& status() const;

  private:
    struct Impl;
    explicit Recorder(std::unique_ptr<Impl> impl);
    std::unique_ptr<Impl> impl_;
};

}  // namespace ff::replay
