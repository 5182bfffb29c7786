#include "tools/report/report.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "tools/report/page_assets.h"

namespace ff::report {
namespace {

using nlohmann::json;

/// A column of numbers or nulls, a value a frame.
bool is_column(const json& values, std::size_t count) {
    if (!values.is_array() || values.size() != count) return false;
    for (const json& value : values)
        if (!value.is_number() && !value.is_null()) return false;
    return true;
}

/// What the page needs of a run's frames: columns of one length. Empty where it is so.
std::string find_problem(const json& run) {
    if (!run.is_object() || !run.contains("frames"))
        return "no 'frames'; expected every frame: ask for them with --each-frame or --json";
    const json& frames = run["frames"];
    if (!frames.is_object() || !frames.contains("ms") || !frames["ms"].is_array() || frames["ms"].empty())
        return "'frames' without 'ms'; expected the time of each frame";
    const std::size_t count = frames["ms"].size();
    if (!is_column(frames["ms"], count)) return "frames.ms: expected numbers";
    if (!frames.contains("position_m") || !frames["position_m"].is_array() || frames["position_m"].size() != count)
        return fmt::format("frames.position_m: expected {} places", count);
    for (const json& place : frames["position_m"])
        if (!is_column(place, 3)) return "frames.position_m: expected [x, y, z]";
    for (const char* table : {"pass_ms", "effect_ms", "effect_state", "pixels", "work", "plan"}) {
        if (!frames.contains(table) || !frames[table].is_object())
            return fmt::format("frames.{}: expected a table", table);
        for (const auto& [name, column] : frames[table].items())
            if (!is_column(column, count)) return fmt::format("frames.{}.{}: expected {} numbers", table, name, count);
    }
    return {};
}

/// The runs of an input, each with a title.
Result<json> runs_of(const Input& input, const json& data) {
    json runs = json::array();
    const std::string kind = data.is_object() ? data.value("kind", data.contains("modes") ? "bench" : "") : "";
    const auto add = [&](const std::string& title, const json& run) -> Status {
        if (const std::string problem = find_problem(run); !problem.empty())
            return bad_input(fmt::format("{}: {}: {}", input.file, title, problem));
        json entry{{"file", input.file}, {"kind", kind}, {"title", title}, {"frames", run["frames"]}};
        entry["pictures"] = run.value("pictures", json::array());
        entry["limits"] = run.value("limits", json::array());
        entry["markers"] = run.value("markers", json::array());
        if (run.contains("calibration")) entry["calibration"] = run["calibration"];
        runs.push_back(std::move(entry));
        return {};
    };
    if (kind == "bench") {
        for (const auto& [mode, run] : data["modes"].items()) FF_TRY(add(mode, run));
    } else if (kind == "budget" || kind == "replay") {
        FF_TRY(add(kind, data));
    } else if (kind == "compare" && data.contains("packs") && data["packs"].is_array()) {
        for (const json& pack : data["packs"])
            FF_TRY(add(pack.is_object() ? pack.value("pack", "pack") : std::string("pack"), pack));
    } else {
        return bad_input(
            fmt::format("{}: expected what ff bench --each-frame, ff budget --json, ff replay --bench "
                        "--each-frame --json or ff compare --json prints",
                        input.file));
    }
    return runs;
}

}  // namespace

Result<std::string> make_page(std::span<const Input> inputs) {
    json page{{"runs", json::array()}, {"inputs", json::array()}};
    for (const Input& input : inputs) {
        json data;
        try {
            data = json::parse(input.text);
            FF_ASSIGN(const json runs, runs_of(input, data));
            for (const json& run : runs) page["runs"].push_back(run);
        } catch (const json::exception& error) {
            return bad_input(fmt::format("{}: not the JSON that it should be: {}", input.file, error.what()));
        }
        json about{{"file", input.file}};
        for (const char* key :
             {"kind", "scene", "machine", "settings", "image", "ratio", "recording", "game", "pack", "parted_tick"})
            if (data.contains(key)) about[key] = data[key];
        page["inputs"].push_back(std::move(about));
    }
    return page::fill_page(kPage, page.dump());
}

}  // namespace ff::report
