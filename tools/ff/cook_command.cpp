#include <cstdio>

#include "engine/core/log.h"
#include "tools/cook/cook.h"
#include "tools/ff/commands.h"

namespace ff::tool {

Status run_cook(const CookOptions& options) {
    cook::CookSettings settings;
    settings.scale = options.scale;
    settings.jobs = options.jobs;
    settings.cache_dir = options.cache_dir;
    FF_ASSIGN(const cook::CookReport report, cook::cook(options.source, options.output, settings));
    log_info("{}", report.to_text());
    if (options.json) std::printf("%s\n", report.to_json().c_str());
    return {};
}

}  // namespace ff::tool
