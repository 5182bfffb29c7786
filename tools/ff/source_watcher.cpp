#include "tools/ff/source_watcher.h"

#include <fmt/format.h>
#include <signal.h>
#include <spawn.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <nlohmann/json.hpp>

#include "engine/core/log.h"

extern char** environ;

namespace ff::tool {
namespace {

constexpr std::chrono::milliseconds kInterval(500);

std::string contents_of(int fd) {
    std::string text(std::size_t(std::max<off_t>(0, ::lseek(fd, 0, SEEK_END))), '\0');
    const ssize_t bytes = ::pread(fd, text.data(), text.size(), 0);
    text.resize(std::size_t(std::max<ssize_t>(0, bytes)));
    return text;
}

/// What a failed command says why: its last line.
std::string last_line(std::string text) {
    while (!text.empty() && (text.back() == '\n' || text.back() == '\r')) text.pop_back();
    const std::size_t at = text.find_last_of("\n\r");
    return at == std::string::npos ? text : text.substr(at + 1);
}

}  // namespace

SourceWatcher::SourceWatcher(std::filesystem::path source, std::filesystem::path pack,
                             const std::vector<std::string>& inputs, std::filesystem::path shaders)
    : source_(std::move(source)), pack_(std::move(pack)), looked_(std::chrono::steady_clock::now()) {
    watch(inputs);
    std::error_code ignored;
    if (!shaders.empty())
        for (const auto& entry : std::filesystem::directory_iterator(shaders, ignored))
            if (entry.path().extension() == ".glsl") shaders_[entry.path()] = stamp_of(entry.path());
}

SourceWatcher::~SourceWatcher() {
    if (cook_ == 0) return;
    ::kill(cook_, SIGTERM);
    ::waitpid(cook_, nullptr, 0);
    ::close(report_fd_);
    ::close(log_fd_);
}

SourceWatcher::Stamp SourceWatcher::stamp_of(const std::filesystem::path& path) {
    struct stat status {};
    if (::stat(path.c_str(), &status) != 0) return {};
    return {std::int64_t(status.st_mtim.tv_sec) * 1'000'000'000 + status.st_mtim.tv_nsec,
            std::uint64_t(status.st_size)};
}

void SourceWatcher::watch(const std::vector<std::string>& inputs) {
    // What is known of a file stays: it may have changed again while it was being cooked.
    for (const std::string& input : inputs)
        if (!inputs_.contains(input)) inputs_[input] = stamp_of(input);
}

bool SourceWatcher::refresh(Stamps& stamps) const {
    bool changed = false;
    for (auto& [path, stamp] : stamps) {
        const Stamp now = stamp_of(path);
        changed |= now != stamp;
        stamp = now;
    }
    return changed;
}

std::optional<host::Change> SourceWatcher::poll() {
    if (cook_ != 0)
        if (auto change = finished_cook()) return change;
    const auto now = std::chrono::steady_clock::now();
    if (now - looked_ < kInterval) return {};
    looked_ = now;
    if (refresh(shaders_)) return host::Change{.pack = {}, .shaders = true, .error = {}};
    // One cook after the other: what changes meanwhile is seen after its end.
    if (cook_ == 0 && refresh(inputs_)) start_cook();
    return {};
}

void SourceWatcher::start_cook() {
    report_fd_ = ::memfd_create("cook report", MFD_CLOEXEC);
    log_fd_ = ::memfd_create("cook log", MFD_CLOEXEC);
    std::error_code ignored;
    const std::string tool = std::filesystem::read_symlink("/proc/self/exe", ignored).string();
    const std::string source = source_.string(), pack = pack_.string();
    const char* const arguments[] = {"nice", "-n",         "10",     tool.c_str(), "cook",   source.c_str(),
                                     "-o",   pack.c_str(), "--jobs", "1",          "--json", nullptr};
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_adddup2(&actions, report_fd_, STDOUT_FILENO);
    posix_spawn_file_actions_adddup2(&actions, log_fd_, STDERR_FILENO);
    const int error = ::posix_spawnp(&cook_, "nice", &actions, nullptr, const_cast<char* const*>(arguments), environ);
    posix_spawn_file_actions_destroy(&actions);
    if (error == 0) {
        log_info("{} changed: cooking it", source);
        return;
    }
    log_warning("{}: cannot be cooked: {}", source, std::strerror(error));
    cook_ = 0;
    ::close(report_fd_);
    ::close(log_fd_);
}

std::optional<host::Change> SourceWatcher::finished_cook() {
    int status = 0;
    if (::waitpid(cook_, &status, WNOHANG) == 0) return {};
    const std::string report = contents_of(report_fd_), log = contents_of(log_fd_);
    ::close(report_fd_);
    ::close(log_fd_);
    cook_ = 0;
    host::Change change;
    if (!WIFEXITED(status) || WEXITSTATUS(status) != 0) {
        change.error = last_line(log);
        if (change.error.empty()) change.error = fmt::format("{}: the cook ended early", source_.string());
        return change;
    }
    const auto json = nlohmann::json::parse(report, nullptr, false);
    if (json.is_object() && json.contains("inputs")) watch(json["inputs"].get<std::vector<std::string>>());
    change.pack = pack_;
    return change;
}

}  // namespace ff::tool
