#pragma once
// The sweep as accuracy.json and as one page that opens without a network.

#include <filesystem>
#include <string>

#include "engine/core/result.h"
#include "tools/accuracy/sweep.h"

namespace ff::accuracy {

struct ReportInfo {
    std::string cpu = "unknown", gl_renderer = "none";
    int threads = 1;
};

/// accuracy.json (docs/accuracy-lab.md says what its parts mean).
[[nodiscard]] std::string report_json(const Bench& bench, const Sweep& sweep, const ReportInfo& info);

/// Writes accuracy.json, accuracy.html and the pictures that the page shows into a folder, which is made.
/// Errors: something cannot be written.
Status write_report(const Bench& bench, const Sweep& sweep, const ReportInfo& info,
                    const std::filesystem::path& folder);

}  // namespace ff::accuracy
