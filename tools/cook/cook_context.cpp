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

void CookContext::end_stage(const char* name) {
    stages_.push_back({name, stage_.seconds()});
    stage_.restart();
}

}  // namespace ff::cook
