// ff report: one page of what bench, budget, replay and compare measured.

#include "engine/core/log.h"
#include "engine/core/write_file.h"
#include "tools/ff/commands.h"
#include "tools/report/report.h"

namespace ff::tool {

Status run_report(const ReportOptions& options) {
    std::vector<report::Input> inputs;
    for (const std::filesystem::path& path : options.inputs) {
        FF_ASSIGN(std::string text, read_text_file(path));
        inputs.push_back({path.string(), std::move(text)});
    }
    FF_ASSIGN(const std::string page, report::make_page(inputs));
    FF_TRY(write_file_whole(options.output, page));
    log_info("{}: open it in a browser", std::filesystem::absolute(options.output).string());
    return {};
}

}  // namespace ff::tool
