#pragma once
// Hot reload: watches the files that a world was cooked from, and cooks it anew beside the running game.

#include <sys/types.h>

#include <chrono>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "engine/host/play.h"

namespace ff::tool {

class SourceWatcher {
  public:
    /// @param inputs   that `source` was cooked from into `pack`
    /// @param shaders  folder of GLSL files that are watched too; empty: none
    SourceWatcher(std::filesystem::path source, std::filesystem::path pack, const std::vector<std::string>& inputs,
                  std::filesystem::path shaders);
    SourceWatcher(const SourceWatcher&) = delete;
    SourceWatcher& operator=(const SourceWatcher&) = delete;
    /// Ends a cook that goes on.
    ~SourceWatcher();

    /// What became of changes since the last call. Looks at the files twice a second; a cook runs as a process of its
    /// own with low priority, so that neither its time nor its end are the game's. Does not wait.
    std::optional<host::Change> poll();

  private:
    struct Stamp {
        std::int64_t time_ns = 0;
        std::uint64_t bytes = 0;
        friend bool operator==(const Stamp&, const Stamp&) = default;
    };
    using Stamps = std::map<std::filesystem::path, Stamp>;
    static Stamp stamp_of(const std::filesystem::path& path);
    void watch(const std::vector<std::string>& inputs);
    [[nodiscard]] bool refresh(Stamps& stamps) const;
    void start_cook();
    std::optional<host::Change> finished_cook();

    std::filesystem::path source_, pack_;
    Stamps inputs_, shaders_;
    std::chrono::steady_clock::time_point looked_;
    pid_t cook_ = 0;                    ///< 0: none runs
    int report_fd_ = -1, log_fd_ = -1;  ///< what it prints
};

}  // namespace ff::tool
