#include "tools/cook/cook_context.h"

#include "engine/core/log.h"

namespace ff::cook {

void CookContext::warn(const std::string& text) {
    {
        const std::lock_guard lock(mutex_);
        if (!warnings_.insert(text).second) return;
    }
    log_warning("{}", text);
}

std::vector<std::string> CookContext::warnings() const {
    const std::lock_guard lock(mutex_);
    return {warnings_.begin(), warnings_.end()};
}

void CookContext::add_input(const std::filesystem::path& path, std::optional<std::uint64_t> bytes) {
    std::error_code ignored;
    const std::uint64_t size = bytes ? *bytes : std::filesystem::file_size(path, ignored);
    const std::lock_guard lock(mutex_);
    inputs_[path.lexically_normal()] = size;
}

std::vector<std::filesystem::path> CookContext::inputs() const {
    const std::lock_guard lock(mutex_);
    std::vector<std::filesystem::path> paths;
    for (const auto& [path, bytes] : inputs_) paths.push_back(path);
    return paths;
}

std::uint64_t CookContext::bytes_in() const {
    const std::lock_guard lock(mutex_);
    std::uint64_t sum = 0;
    for (const auto& [path, bytes] : inputs_) sum += bytes;
    return sum;
}

void CookContext::end_stage(const char* name) {
    stages_.push_back({name, stage_.seconds()});
    stage_.restart();
}

}  // namespace ff::cook
