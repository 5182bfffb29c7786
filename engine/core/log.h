#pragma once
// Messages for people, on stderr; stdout belongs to results. Progress of everything that takes over two seconds.

#include <fmt/core.h>

#include <chrono>
#include <cstdint>
#include <string>
#include <string_view>

namespace ff {

void log_line(std::string_view level, const std::string& text);

template <class... Args>
void log_info(fmt::format_string<Args...> format, Args&&... args) {
    log_line("", fmt::format(format, std::forward<Args>(args)...));
}
template <class... Args>
void log_warning(fmt::format_string<Args...> format, Args&&... args) {
    log_line("warning: ", fmt::format(format, std::forward<Args>(args)...));
}

/// A bar on stderr for one long step. On a terminal it redraws in place at most 10 times a second; elsewhere it prints
/// a line every two seconds. Says nothing about steps that end within the first half second.
/// Threads: advance() may be called from many at once.
class Progress {
  public:
    Progress(std::string step, std::uint64_t total);
    ~Progress();
    Progress(const Progress&) = delete;
    Progress& operator=(const Progress&) = delete;
    void advance(std::uint64_t by = 1);

  private:
    struct State;
    State* state_;
};

}  // namespace ff
