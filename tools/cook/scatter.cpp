#include "tools/cook/scatter.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <numeric>
#include <tuple>

#include "engine/core/jobs.h"
#include "tools/cook/buildings_facade.h"
#include "tools/cook/terrain_valley.h"

namespace ff::cook {
namespace {

constexpr double kSquare = 32.0, kMaxMargin = 8.0;

long square_of(double v) {
    return std::lround(std::floor(v / kSquare));
}

double distance_to_segment(const DVec2& a, const DVec2& b, const DVec2& p) {
    const DVec2 ab = b - a;
    const double t = std::clamp(glm::dot(p - a, ab) / std::max(glm::dot(ab, ab), 1e-12), 0.0, 1.0);
    return glm::length(p - a - ab * t);
}

}  // namespace

DMat3 world_from_yaw(double yaw_deg, double scale) {
    // Whole turns and halves come out exact; a yaw of 90 turns north (-z) to east (+x).
    const double a = radians_of(yaw_deg), c = std::cos(a) * scale, s = std::sin(a) * scale;
    return DMat3(DVec3(c, 0, s), DVec3(0, scale, 0), DVec3(-s, 0, c));
}

void Obstacles::add(const Footprint& footprint) {
    if (footprint.outer.size() < 3) return;
    DVec2 low = footprint.outer[0], high = low;
    for (const DVec2& p : footprint.outer) low = glm::min(low, p), high = glm::max(high, p);
    const auto id = std::uint32_t(footprints_.size());
    for (long z = square_of(-high.y - kMaxMargin); z <= square_of(-low.y + kMaxMargin); ++z)
        for (long x = square_of(low.x - kMaxMargin); x <= square_of(high.x + kMaxMargin); ++x)
            squares_.push_back({x, z, id});
    footprints_.push_back(footprint);
}

void Obstacles::add(const RectXZ& rect) {
    rects_.push_back(rect);
}

void Obstacles::finish() {
    std::sort(squares_.begin(), squares_.end(), [](const Square& a, const Square& b) {
        return std::tie(a.x, a.z, a.footprint) < std::tie(b.x, b.z, b.footprint);
    });
}

bool Obstacles::is_free(double x, double z, double margin) const {
    for (const RectXZ& r : rects_)
        if (x > r.x0 - margin && x < r.x1 + margin && z > r.z0 - margin && z < r.z1 + margin) return false;
    const long i = square_of(x), j = square_of(z);
    auto at = std::lower_bound(squares_.begin(), squares_.end(), std::pair(i, j), [](const Square& s, const auto& key) {
        return std::tie(s.x, s.z) < std::tie(key.first, key.second);
    });
    const DVec2 p(x, -z);
    for (; at != squares_.end() && at->x == i && at->z == j; ++at) {
        const Footprint& footprint = footprints_[at->footprint];
        if (contains(footprint, p)) return false;
        for (std::size_t k = 0; k < footprint.outer.size(); ++k)
            if (distance_to_segment(footprint.outer[k], footprint.outer[(k + 1) % footprint.outer.size()], p) < margin)
                return false;
    }
    return true;
}

void scatter(std::span<const Model> models, const ScatterRule& rule, const GroundHeight& ground,
             const Obstacles& obstacles, WorldSource& world) {
    if (models.empty() || rule.density_per_km2 <= 0) return;
    const double step = 1000.0 / std::sqrt(rule.density_per_km2);
    const long x0 = std::lround(std::floor(rule.area.x0 / step)), x1 = std::lround(std::ceil(rule.area.x1 / step));
    const long z0 = std::lround(std::floor(rule.area.z0 / step)), z1 = std::lround(std::ceil(rule.area.z1 / step));
    if (x1 <= x0 || z1 <= z0) return;
    const double weight_sum = std::accumulate(rule.weights.begin(), rule.weights.end(), 0.0);
    const double max_tangent = rule.slope_max_deg < 90 ? std::tan(radians_of(rule.slope_max_deg)) : 1e30;

    struct Place {
        std::size_t model;
        DVec3 position;
        double yaw, scale;
    };
    std::vector<RectXZ> boxes;  // of the polygons
    for (const Footprint& polygon : rule.polygons) {
        RectXZ& box = boxes.emplace_back(RectXZ{1e9, 1e9, -1e9, -1e9});
        for (const DVec2& p : polygon.outer) {
            box.x0 = std::min(box.x0, p.x), box.x1 = std::max(box.x1, p.x);
            box.z0 = std::min(box.z0, -p.y), box.z1 = std::max(box.z1, -p.y);
        }
    }
    const auto in_polygons = [&](double x, double z) {
        for (std::size_t i = 0; i < boxes.size(); ++i)
            if (boxes[i].contains(x, z) && contains(rule.polygons[i], DVec2(x, -z))) return true;
        return boxes.empty();
    };
    std::vector<std::vector<Place>> rows(std::size_t(z1 - z0));
    parallel_ranges(rows.size(), 4, [&](std::size_t begin, std::size_t end) {
        for (std::size_t r = begin; r < end; ++r)
            for (long i = x0; i < x1; ++i) {
                const long j = z0 + long(r);
                const std::uint64_t place = hash_mix(rule.seed, std::uint64_t(i), std::uint64_t(j));
                // Jitter within 0.8 of the square keeps neighbours a fifth of a step apart.
                const double x = (double(i) + 0.1 + 0.8 * hash_unit(place, 1)) * step;
                const double z = (double(j) + 0.1 + 0.8 * hash_unit(place, 2)) * step;
                if (!rule.area.contains(x, z)) continue;
                if (rule.clump_m > 0 &&
                    fractal_noise(rule.seed, x / rule.clump_m, z / rule.clump_m, 3) < 0.5 * hash_unit(place, 3) - 0.05)
                    continue;
                if (!in_polygons(x, z)) continue;
                if (!obstacles.is_free(x, z, 1.5)) continue;
                const std::optional<double> y = ground(x, z);
                if (!y || (rule.height_m && (*y < (*rule.height_m)[0] || *y > (*rule.height_m)[1]))) continue;
                const auto rise = [&](double step_x, double step_z) {  // over 1 m; backwards where the ground ends
                    if (const auto ahead = ground(x + step_x, z + step_z)) return *ahead - *y;
                    if (const auto behind = ground(x - step_x, z - step_z)) return *y - *behind;
                    return 0.0;
                };
                const double dx = rise(1, 0), dz = rise(0, 1);
                if (dx * dx + dz * dz > max_tangent * max_tangent) continue;
                double pick = hash_unit(place, 4) * weight_sum;
                std::size_t model = 0;
                while (model + 1 < models.size() && pick >= rule.weights[model]) pick -= rule.weights[model++];
                rows[r].push_back({model, DVec3(x, *y, z), std::floor(hash_unit(place, 5) * 360.0),
                                   rule.scale[0] + (rule.scale[1] - rule.scale[0]) * hash_unit(place, 6)});
            }
    });
    for (const std::vector<Place>& row : rows)
        for (const Place& place : row)
            place_model(models[place.model], place.position, world_from_yaw(place.yaw, place.scale),
                        PlacementKind::instance, world, true);
}

}  // namespace ff::cook
