#include "engine/effects/lamp_grid.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>

namespace ff::effects {
namespace {

constexpr double kFadeInDeg = 2.0;

/// Whether a ball reaches into the view's pyramid; conservatively.
bool may_be_seen(const PinholeView& view, const Vec3& center, float radius_m) {
    const Vec3 right = view.world_from_camera[0], up = view.world_from_camera[1], back = view.world_from_camera[2];
    const float x = glm::dot(center, right), y = glm::dot(center, up), depth = -glm::dot(center, back);
    if (depth < -radius_m) return false;
    // Of a side plane u = edge, the distance beyond it.
    const auto is_beyond = [&](float at, float edge, float sign) {
        return sign * (at - edge * depth) > radius_m * std::sqrt(1.0f + edge * edge);
    };
    const float left = view.u_first, right_edge = view.u_first + float(view.width) * view.u_step;
    const float top = view.v_first, bottom = view.v_first + float(view.height) * view.v_step;
    return !(is_beyond(x, left, -1.0f) || is_beyond(x, right_edge, 1.0f) || is_beyond(y, top, 1.0f) ||
             is_beyond(y, bottom, -1.0f));
}

}  // namespace

double lamp_brightness(const scene::Lamp& lamp, double sun_elevation_deg) {
    return std::clamp((double(lamp.on_below_sun_deg) - sun_elevation_deg) / kFadeInDeg, 0.0, 1.0);
}

LampGrid::LampGrid(std::span<const scene::Lamp> lamps) : lamps_(lamps) {
    if (lamps.empty()) return;
    double high_x = -std::numeric_limits<double>::infinity(), high_z = high_x;
    low_x_ = low_z_ = -high_x;
    for (const scene::Lamp& lamp : lamps) {
        low_x_ = std::min(low_x_, lamp.position.x), high_x = std::max(high_x, lamp.position.x);
        low_z_ = std::min(low_z_, lamp.position.z), high_z = std::max(high_z, lamp.position.z);
        largest_radius_m_ = std::max(largest_radius_m_, double(lamp.radius_m));
        first_on_below_deg_ = std::max(first_on_below_deg_, double(lamp.on_below_sun_deg));
    }
    // Lamps strewn over a continent get larger squares instead of more memory.
    constexpr double kMostSquares = 1024.0;
    const auto count = [&](double extent) { return 1 + int(std::min(extent / kSquareM, kMostSquares - 1.0)); };
    columns_ = count(high_x - low_x_);
    rows_ = count(high_z - low_z_);
    const auto square_of = [&](const scene::Lamp& lamp) {
        const int i = std::min(int((lamp.position.x - low_x_) / kSquareM), columns_ - 1);
        const int j = std::min(int((lamp.position.z - low_z_) / kSquareM), rows_ - 1);
        return std::size_t(j) * std::size_t(columns_) + std::size_t(i);
    };
    first_.assign(std::size_t(columns_) * std::size_t(rows_) + 1, 0);
    for (const scene::Lamp& lamp : lamps) ++first_[square_of(lamp) + 1];
    for (std::size_t i = 1; i < first_.size(); ++i) first_[i] += first_[i - 1];
    order_.resize(lamps.size());
    std::vector<std::uint32_t> next(first_.begin(), first_.end() - 1);
    for (std::size_t i = 0; i < lamps.size(); ++i) order_[next[square_of(lamps[i])]++] = std::uint32_t(i);
}

/// Calls body(lamp) of the lamps whose light reaches within a distance of the eye, until it returns true.
template <class Body>
void LampGrid::each_within(const WorldPos& eye, double within_m, Body&& body) const {
    if (lamps_.empty()) return;
    const double reach = within_m + largest_radius_m_;
    const auto clamped = [](double at, int count) { return int(std::clamp(at, -1.0, double(count))); };
    // What stands beyond the last square's border is in the last square.
    const int i0 = std::min(clamped(std::floor((eye.x - reach - low_x_) / kSquareM), columns_), columns_ - 1);
    const int i1 = clamped(std::floor((eye.x + reach - low_x_) / kSquareM), columns_);
    const int j0 = std::min(clamped(std::floor((eye.z - reach - low_z_) / kSquareM), rows_), rows_ - 1);
    const int j1 = clamped(std::floor((eye.z + reach - low_z_) / kSquareM), rows_);
    for (int j = std::max(0, j0); j <= std::min(j1, rows_ - 1); ++j)
        for (int i = std::max(0, i0); i <= std::min(i1, columns_ - 1); ++i) {
            const std::size_t square = std::size_t(j) * std::size_t(columns_) + std::size_t(i);
            for (std::uint32_t k = first_[square]; k < first_[square + 1]; ++k) {
                const scene::Lamp& lamp = lamps_[order_[k]];
                const double far = within_m + double(lamp.radius_m);
                const DVec3 apart = lamp.position - eye;
                if (glm::dot(apart, apart) < far * far && body(lamp)) return;
            }
        }
}

bool LampGrid::has_lamp_within(const WorldPos& eye, double within_m) const {
    bool found = false;
    each_within(eye, within_m, [&](const scene::Lamp&) { return found = true; });
    return found;
}

void LampGrid::find_lit(const PinholeView& view, double sun_elevation_deg, double within_m,
                        std::vector<shading::LampLight>& out) const {
    out.clear();
    each_within(view.position, within_m, [&](const scene::Lamp& lamp) {
        const double brightness = lamp_brightness(lamp, sun_elevation_deg);
        if (!(brightness > 0.0)) return false;
        const DVec3 apart = lamp.position - view.position;
        if (!may_be_seen(view, Vec3(apart), lamp.radius_m)) return false;
        constexpr double kFade = 0.2;
        const double nearness = (1.0 - (glm::length(apart) - double(lamp.radius_m)) / within_m) / kFade;
        const double share = brightness * std::clamp(nearness, 0.0, 1.0);
        out.push_back({.position = Vec3(apart),
                       .radius_m = lamp.radius_m,
                       .strength = lamp.color * float(share * double(lamp.lumens * shading::kLitPerLumen))});
        return false;
    });
    std::sort(out.begin(), out.end(), [](const shading::LampLight& a, const shading::LampLight& b) {
        const float da = glm::dot(a.position, a.position), db = glm::dot(b.position, b.position);
        if (da != db) return da < db;
        return a.position.x != b.position.x ? a.position.x < b.position.x : a.position.z < b.position.z;
    });
    if (out.size() > kMaxLamps) out.resize(kMaxLamps);
}

}  // namespace ff::effects
