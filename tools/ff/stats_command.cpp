// ff stats: which effects a walk calls for, why, and what they cost.

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "engine/nearfield/near_renderer.h"
#include "tools/ff/effect_table.h"
#include "tools/ff/effect_walk.h"
#include "tools/picture/picture_file.h"

namespace ff::tool {
namespace {

using nlohmann::json;

/// One row of the report.
json report_of(const effects::Effect& effect, const EffectWalk& walk, std::uint64_t shaders,
               const EffectDifference* difference) {
    const EffectSum& sum = walk.of[std::size_t(effect.id)];
    const auto frames = double(walk.frames);
    json row{{"name", effect.name},
             {"state", effects::kStateNames[std::size_t(sum.decision.state)]},
             {"reason", sum.decision.reason},
             {"called_by", effect.called_by},
             {"needs", effect.needs},
             {"frames", {{"off", sum.frames_in[0]}, {"idle", sum.frames_in[1]}, {"active", sum.frames_in[2]}}},
             {"ms_per_frame", sum.work.ms / frames},
             {"allocations", sum.work.allocations},
             {"steady_allocations", sum.steady_allocations},
             {"shaders", shaders},
             {"systems", sum.work.systems},
             {"rays_per_frame", double(sum.work.rays) / frames}};
    if (difference != nullptr)
        row["difference"] = {{"ms_with", difference->ms_with},
                             {"ms_without", difference->ms_without},
                             {"ms_added", difference->ms_added},
                             {"psnr_db", difference->psnr_db},
                             {"frame", difference->frame}};
    return row;
}

Status write_pictures(const std::filesystem::path& folder, std::span<const EffectDifference> differences) {
    std::error_code error;
    std::filesystem::create_directories(folder, error);
    if (error) return failure(fmt::format("{}: cannot create: {}", folder.string(), error.message()));
    for (const EffectDifference& difference : differences) {
        const std::string_view name = effects::registry()[std::size_t(difference.id)].name;
        FF_TRY(write_image(folder / fmt::format("{}_with.png", name), difference.with));
        FF_TRY(write_image(folder / fmt::format("{}_without.png", name), difference.without));
    }
    return {};
}

void print_table(const json& report) {
    fmt::print("{:<14} {:<7} {:>9} {:>9} {:>7} {:>8} {:>8}  {}\n", "effect", "state", "ms/frame", "ms added", "allocs",
               "shaders", "rays", "why");
    for (const json& row : report["effects"]) {
        const auto number = [&](const char* key) { return row[key].get<double>(); };
        const std::string added = row.contains("difference")
                                      ? fmt::format("{:.2f}", row["difference"]["ms_added"].get<double>())
                                      : std::string("-");
        fmt::print("{:<14} {:<7} {:>9.2f} {:>9} {:>7} {:>8} {:>8.0f}  {}\n", row["name"].get<std::string>(),
                   row["state"].get<std::string>(), number("ms_per_frame"), added,
                   row["allocations"].get<std::uint64_t>(), row["shaders"].get<std::uint64_t>(),
                   number("rays_per_frame"), row["reason"].get<std::string>());
    }
}

}  // namespace

Status run_stats(const StatsOptions& options) {
    FF_ASSIGN(const std::unique_ptr<Session> session,
              Session::open(options.view, std::span(&options.view.frame.mode, 1)));
    const std::size_t all = session->walk().frames.size();
    const std::size_t frames = options.max_frames > 0 ? std::min(std::size_t(options.max_frames), all) : all;
    FF_ASSIGN(const EffectWalk walk, walk_effects(*session, options.view.size, frames));
    const bool wants_table = !options.table.empty();
    // Pictures alone are those of one lap.
    const int laps = std::max(options.compare_laps, options.pictures.empty() && !wants_table ? 0 : 1);
    std::vector<EffectDifference> differences;
    if (laps > 0) differences = compare_effects(*session, options.view.size, frames, laps, walk, wants_table);
    if (!options.pictures.empty()) FF_TRY(write_pictures(options.pictures, differences));
    if (wants_table) {
        FF_TRY(write_pictures(options.table, differences));
        FF_TRY(write_effect_table(options.table / "effects.md", {session->world().info().name, session->walk().name},
                                  laps, walk, differences));
    }

    json report{
        {"scene", session->world().info().name}, {"walk", session->walk().name},       {"frames", frames},
        {"width", options.view.size.width},      {"height", options.view.size.height}, {"effects", json::array()}};
    report["frame_ms"] = {{"median", walk.median_ms}, {"p99", walk.p99_ms}, {"max", walk.max_ms}};
    report["changes"] = {{"frames", walk.changes},
                         {"p99_ms", walk.change_p99_ms},
                         {"most_allocations_elsewhere", walk.most_allocations}};
    for (const effects::Effect& effect : effects::registry()) {
        const auto difference = std::find_if(differences.begin(), differences.end(),
                                             [&](const EffectDifference& d) { return d.id == effect.id; });
        const bool draws_by_gl = session->near_renderer() != nullptr && !effect.shader.empty();
        report["effects"].push_back(report_of(effect, walk,
                                              draws_by_gl ? session->near_renderer()->programs_with(effect.shader) : 0,
                                              difference == differences.end() ? nullptr : &*difference));
    }
    if (options.json)
        fmt::print("{}\n", report.dump(2));
    else
        print_table(report);
    return {};
}

}  // namespace ff::tool
