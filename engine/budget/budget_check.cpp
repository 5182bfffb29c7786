#include "engine/budget/budget_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace ff::budget {
namespace {

constexpr double kSmallestShare = 0.01;  // of the median frame, that a pass needs to be limited

const Figure* find(std::span<const Figure> figures, LimitKind kind, std::string_view key) {
    const auto at = std::find_if(figures.begin(), figures.end(),
                                 [&](const Figure& figure) { return figure.kind == kind && figure.key == key; });
    return at == figures.end() ? nullptr : &*at;
}

/// Times to a ten-thousandth of a millisecond, upwards: who reads the file wants no sixteen digits.
double rounded_up(double ms) {
    return std::ceil(ms * 1e4) / 1e4;
}

std::string escaped(std::string_view text) {
    std::string out;
    for (const char c : text) {
        if (c == '&')
            out += "&amp;";
        else if (c == '<')
            out += "&lt;";
        else if (c == '"')
            out += "&quot;";
        else if (static_cast<unsigned char>(c) < 0x20)
            out += ' ';  // most of them XML cannot hold at all
        else
            out += c;
    }
    return out;
}

}  // namespace

double Verdict::excess() const {
    if (allowed > 0.0) return measured / allowed - 1.0;
    return measured > 0.0 ? HUGE_VAL : 0.0;
}

std::vector<Verdict> check(const Budget& budget, std::span<const Figure> figures, double scale) {
    std::vector<Verdict> verdicts;
    for (const Limit& limit : budget.limits) {
        const Figure* figure = find(figures, limit.kind, limit.key);
        verdicts.push_back({.limit = limit,
                            .allowed = limit.kind == LimitKind::work ? limit.value : limit.value * scale,
                            .measured = figure != nullptr ? figure->value : 0.0,
                            .frame = figure != nullptr ? figure->frame : 0});
    }
    return verdicts;
}

Budget make_budget(std::span<const Figure> figures, double calibration_ms, double margin) {
    Budget budget{.calibration_ms = calibration_ms, .limits = {}};
    const Figure* median = find(figures, LimitKind::time, kTimeKeys[0]);
    const double smallest_ms = median != nullptr ? kSmallestShare * median->value : 0.0;
    for (const Figure& figure : figures) {
        const bool is_work = figure.kind == LimitKind::work;
        const bool is_part = figure.kind == LimitKind::pass || figure.kind == LimitKind::effect;
        if (is_part && !(figure.value > smallest_ms)) continue;
        const double times = figure.key == "worst_ms" ? 3.0 : figure.key == "p99_ms" ? 2.0 : 1.0;
        const double value = is_work ? figure.value : rounded_up(figure.value * (1.0 + times * margin));
        budget.limits.push_back({.kind = figure.kind, .key = figure.key, .value = value});
    }
    return budget;
}

std::string to_text(const Verdict& verdict) {
    const bool is_work = verdict.limit.kind == LimitKind::work;
    std::string text =
        is_work ? fmt::format("{}: {:.0f} of {:.0f}", verdict.limit.name(), verdict.measured, verdict.allowed)
                : fmt::format("{}: {:.3f} of {:.3f} ms", verdict.limit.name(), verdict.measured, verdict.allowed);
    if (verdict.allowed > 0.0) text += fmt::format(" ({:+.1f} %)", 100.0 * verdict.excess());
    return text + fmt::format(", worst in frame {}", verdict.frame);
}

std::string to_junit(std::span<const Verdict> verdicts, std::string_view suite, double seconds) {
    const auto failures = std::count_if(verdicts.begin(), verdicts.end(), [](const Verdict& v) { return !v.held(); });
    std::string text = fmt::format(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<testsuites>\n<testsuite name=\"{}\" tests=\"{}\" failures=\"{}\" "
        "errors=\"0\" time=\"{:.3f}\">\n",
        escaped(suite), verdicts.size(), failures, seconds);
    for (const Verdict& verdict : verdicts) {
        const std::string head = fmt::format("<testcase classname=\"{}\" name=\"{}\" time=\"{:.6f}\"", escaped(suite),
                                             escaped(verdict.limit.name()),
                                             verdict.limit.kind == LimitKind::work ? 0.0 : 1e-3 * verdict.measured);
        if (verdict.held())
            text += head + "/>\n";
        else
            text += fmt::format("{}>\n<failure type=\"limit\" message=\"{}\"/>\n</testcase>\n", head,
                                escaped(to_text(verdict)));
    }
    return text + "</testsuite>\n</testsuites>\n";
}

}  // namespace ff::budget
