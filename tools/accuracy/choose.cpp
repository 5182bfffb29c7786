#include "tools/accuracy/choose.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <vector>

#include "engine/core/write_file.h"
#include "engine/frame/knobs.h"

namespace ff::accuracy {
namespace {

using nlohmann::json;

/// One setting of a table.
struct Candidate {
    json settings;
    double time_ratio = 1.0, displacement_px = 0.0, psnr_db = 0.0;
};

Candidate candidate_of(const json& point, json settings) {
    return {std::move(settings),
            point.at("frame_ms_median").get<double>() / point.at("exact_frame_ms_median").get<double>(),
            point.at("displacement_px").get<double>(), point.at("psnr_exact_db_min").get<double>()};
}

std::vector<Candidate> candidates_of(const json& table) {
    std::vector<Candidate> candidates;
    for (const json& knob : table.at("knobs"))
        for (const json& point : knob.at("points"))
            candidates.push_back(candidate_of(point, {{knob.at("name").get<std::string>(), point.at("value")}}));
    for (const json& point : table.at("pairs")) candidates.push_back(candidate_of(point, point.at("settings")));
    return candidates;
}

/// Whether the knobs stand where they stood: a time other than the exact frames' is noise, however short.
bool changes_nothing(const Candidate& candidate, const frame::FrameSettings& settings) {
    frame::FrameSettings turned = settings;
    for (const auto& [name, value] : candidate.settings.items())
        if (!frame::set_knob(turned, name, value.get<double>())) return false;
    return turned == settings;
}

std::string text_of_limits(const Limits& limits) {
    std::string text;
    if (std::isfinite(limits.max_displacement_px)) text += fmt::format("{} px or less off", limits.max_displacement_px);
    if (limits.min_psnr_db > 0.0)
        text += fmt::format("{}{} dB or more in the worst frame", text.empty() ? "" : ", ", limits.min_psnr_db);
    return text;
}

Result<std::string> choose(const json& table, const std::string& walk, const Limits& limits,
                           frame::FrameSettings& settings) {
    constexpr double kWorthwhileRatio = 0.97;  // a time below that of exact frames by less is noise
    const Candidate* best = nullptr;
    const std::vector<Candidate> candidates = candidates_of(table);
    std::size_t kept = 0;
    for (const Candidate& c : candidates) {
        if (c.displacement_px > limits.max_displacement_px || c.psnr_db < limits.min_psnr_db) continue;
        ++kept;
        if (changes_nothing(c, settings)) continue;
        if (c.time_ratio < (best != nullptr ? best->time_ratio : kWorthwhileRatio)) best = &c;
    }
    const std::string measured_on = table.at("scene").at("walk").get<std::string>();
    const std::string where = measured_on == walk
                                  ? fmt::format("walk {}", walk)
                                  : fmt::format("walk {}, which says little about walk {}", measured_on, walk);
    const std::string counts =
        fmt::format("{} of {} measured settings have {} ({})", kept, candidates.size(), text_of_limits(limits), where);
    if (best == nullptr) return fmt::format("exact frames: {}, and none is faster", counts);
    std::string names;
    for (const auto& [name, value] : best->settings.items()) {
        FF_TRY(frame::set_knob(settings, name, value.get<double>()));
        names +=
            fmt::format("{}{} {}", names.empty() ? "" : ", ", name, frame::find_knob(name)->text(value.get<double>()));
    }
    return fmt::format("{}: {}; this is the fastest, {:.2f} of an exact frame's time at {:.0f} px and {:.1f} dB", names,
                       counts, best->time_ratio, best->displacement_px, best->psnr_db);
}

}  // namespace

std::filesystem::path table_path(const std::filesystem::path& pack) {
    return std::filesystem::path(pack).replace_extension(".accuracy.json");
}

Result<std::string> choose_settings(const std::filesystem::path& pack, std::uint64_t pack_hash, const std::string& walk,
                                    const Limits& limits, frame::FrameSettings& settings) {
    const std::filesystem::path path = table_path(pack);
    if (!std::filesystem::exists(path))
        return bad_input(
            fmt::format("{}: there is no such table; 'ff accuracy {}' measures it", path.string(), pack.string()));
    FF_ASSIGN(const std::string text, read_text_file(path));
    try {
        const json table = json::parse(text);
        const std::string hash = table.at("scene").at("pack_hash").get<std::string>();
        if (const std::string now = fmt::format("{:016x}", pack_hash); hash != now)
            return bad_input(
                fmt::format("{}: measured on another pack ({}; expected {}); 'ff accuracy {}' measures "
                            "this one",
                            path.string(), hash, now, pack.string()));
        return choose(table, walk, limits, settings);
    } catch (const json::exception& error) {
        return bad_input(fmt::format("{}: not a table of ff accuracy: {}; make it again", path.string(), error.what()));
    }
}

}  // namespace ff::accuracy
