#pragma once
// The command lines of ff budget, ff compare and ff report.

#include "tools/ff/command_options.h"

namespace ff::tool {

void add_budget_options(CLI::App& app, BudgetOptions& options);
void add_compare_options(CLI::App& app, CompareOptions& options);
void add_report_options(CLI::App& app, ReportOptions& options);

}  // namespace ff::tool
