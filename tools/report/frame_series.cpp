#include "tools/report/frame_series.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numeric>

#include "tools/page/page.h"

namespace ff::report {
namespace {

using nlohmann::json;

/// Four digits after the point; null where there is no bound.
json rounded(double value) {
    return std::isfinite(value) ? json(std::round(value * 1e4) / 1e4) : json(nullptr);
}

}  // namespace

void FrameSeries::add(const Camera& camera, double ms, const FrameWork& work, const frame::FrameStats& stats) {
    rows_.push_back({camera, ms, work, stats});
}

std::vector<std::size_t> FrameSeries::worst_frames(std::size_t count, std::size_t warm_up) const {
    std::vector<std::size_t> order(rows_.size());
    std::iota(order.begin(), order.end(), std::size_t(0));
    std::stable_sort(order.begin(), order.end(),
                     [&](std::size_t a, std::size_t b) { return rows_[a].ms > rows_[b].ms; });
    std::vector<std::size_t> worst;
    for (const std::size_t f : order) {
        const bool is_near_other = std::any_of(worst.begin(), worst.end(), [&](std::size_t other) {
            return std::max(f, other) - std::min(f, other) < kFramesApart;
        });
        if (f >= warm_up && !is_near_other && worst.size() < count) worst.push_back(f);
    }
    return worst;
}

json FrameSeries::to_json() const {
    const auto column = [&](auto&& of) {
        json values = json::array();
        for (const Row& row : rows_) values.push_back(of(row));
        return values;
    };
    const auto add_unless_zero = [&](json& table, std::string_view name, auto&& of) {
        if (std::any_of(rows_.begin(), rows_.end(), [&](const Row& row) { return of(row) != 0; }))
            table[std::string(name)] = column(of);
    };
    json frames{{"count", rows_.size()},
                {"ms", column([](const Row& row) { return rounded(row.ms); })},
                {"position_m", column([](const Row& row) {
                     const WorldPos& p = row.camera.position;
                     return json::array({rounded(p.x), rounded(p.y), rounded(p.z)});
                 })},
                {"yaw_deg", column([](const Row& row) { return rounded(degrees_of(row.camera.yaw)); })},
                {"pass_ms", json::object()},
                {"effect_ms", json::object()},
                {"effect_state", json::object()},
                {"pixels", json::object()},
                {"work", json::object()}};
    for (std::size_t p = 0; p < frame::kPassCount; ++p)
        add_unless_zero(frames["pass_ms"], frame::kPassNames[p],
                        [p](const Row& row) { return rounded(row.stats.pass_ms[p]); });
    for (std::size_t e = 0; e < effects::kEffectCount; ++e) {
        add_unless_zero(frames["effect_ms"], effect_names()[e],
                        [e](const Row& row) { return rounded(row.stats.effect_work[e].ms); });
        add_unless_zero(frames["effect_state"], effect_names()[e],
                        [e](const Row& row) { return int(row.stats.effects.of[e].state); });
    }
    using Pixels = frame::PixelCounts;
    constexpr std::pair<const char*, std::uint64_t Pixels::*> kSources[] = {
        {"near", &Pixels::near_field},   {"sky", &Pixels::sky},           {"panorama", &Pixels::panorama},
        {"verified", &Pixels::verified}, {"cast_hit", &Pixels::cast_hit}, {"cast_miss", &Pixels::cast_miss}};
    for (const auto& [name, source] : kSources)
        add_unless_zero(frames["pixels"], name, [source](const Row& row) { return row.stats.pixels.*source; });
    for (std::size_t w = 0; w < budget::kWorkKeys.size(); ++w)
        add_unless_zero(frames["work"], budget::kWorkKeys[w], [w](const Row& row) { return row.work[w]; });
    frames["plan"] = {{"resolution", column([](const Row& row) { return rounded(row.stats.resolution); })},
                      {"near_m", column([](const Row& row) { return rounded(row.stats.near_m); })},
                      {"ray_budget", column([](const Row& row) {
                           return row.stats.ray_budget == UINT64_MAX ? json(nullptr) : json(row.stats.ray_budget);
                       })}};
    return frames;
}

Result<json> to_json(std::span<const FramePicture> pictures) {
    json list = json::array();
    for (const FramePicture& picture : pictures) {
        FF_ASSIGN(const std::string url, page::picture_url(picture.image));
        list.push_back({{"frame", picture.frame}, {"ms", rounded(picture.ms)}, {"plan", picture.plan}, {"url", url}});
    }
    return list;
}

}  // namespace ff::report
