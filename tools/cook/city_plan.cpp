#include "tools/cook/city_plan.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "tools/cook/buildings_facade.h"

namespace ff::cook::city {
namespace {

constexpr double kAvenueWidth = 26.0;
constexpr int kAvenueSpacing = 5;        // one line of so many is an avenue
constexpr double kLineJitter = 0.06;     // of the pitch
constexpr double kCrossingJitter = 3.5;  // m

// Which of the plan's random numbers is meant.
enum Purpose : std::uint64_t {
    kLines = 1,
    kCrossingsX,
    kCrossingsY,
    kWidths,
    kAvenues,
    kEdge,
    kCenters,
    kBlocks,
    kKinds
};

int floor_divide(int a, int b) {
    return a >= 0 ? a / b : -((-a + b - 1) / b);
}

std::uint64_t word(int value) {
    return std::uint64_t(std::int64_t(value));
}

}  // namespace

DVec2 point_in(const Quad& quad, double u, double v) {
    return glm::mix(glm::mix(quad[0], quad[1], u), glm::mix(quad[3], quad[2], u), v);
}

Quad part_of(const Quad& quad, double u0, double u1, double v0, double v1) {
    return {point_in(quad, u0, v0), point_in(quad, u1, v0), point_in(quad, u1, v1), point_in(quad, u0, v1)};
}

Quad inset_quad(const Quad& quad, const std::array<double, 4>& distances) {
    Quad out;
    for (int i = 0; i < 4; ++i) {
        // The corner solves n0 . x = d0, n1 . x = d1 for the inward normals of the two sides that meet in it.
        const int before = (i + 3) % 4;
        const DVec2 a = glm::normalize(quad[i] - quad[before]), b = glm::normalize(quad[(i + 1) % 4] - quad[i]);
        const double cross = a.x * b.y - a.y * b.x;
        out[i] = quad[i] + (b * distances[before] - a * distances[i]) / cross;
    }
    return out;
}

double CityPlan::pitch() const {
    return settings_.block_m + settings_.street_m + (kAvenueWidth - settings_.street_m) / kAvenueSpacing;
}

double CityPlan::street_width(int line, bool west) const {
    const int group = floor_divide(line, kAvenueSpacing);
    const std::uint64_t avenue = hash_mix(settings_.seed, kAvenues, word(group), west) % (kAvenueSpacing - 2);
    if (std::uint64_t(line - group * kAvenueSpacing) == avenue + 1) return kAvenueWidth;
    const double vary = hash_unit(settings_.seed, kWidths, word(line), west) - 0.5;
    return std::clamp(settings_.street_m + 5.0 * vary, 12.0, 20.0);
}

double CityPlan::line_position(int line, bool west) const {
    const double jitter = 2.0 * hash_unit(settings_.seed, kLines, word(line), west) - 1.0;
    return (line - 0.5 + kLineJitter * jitter) * pitch();
}

DVec2 CityPlan::crossing(int column, int row) const {
    const std::uint64_t x = hash_mix(settings_.seed, kCrossingsX, word(column), word(row));
    const std::uint64_t y = hash_mix(settings_.seed, kCrossingsY, word(column), word(row));
    const DVec2 jitter(2.0 * hash_unit(x, 0) - 1.0, 2.0 * hash_unit(y, 0) - 1.0);
    return DVec2(settings_.center_x, -settings_.center_z) +
           DVec2(line_position(column, true), line_position(row, false)) + kCrossingJitter * jitter;
}

Quad CityPlan::kerb(BlockIndex index) const {
    const auto [c, r] = index;
    const Quad nodes{crossing(c, r), crossing(c + 1, r), crossing(c + 1, r + 1), crossing(c, r + 1)};
    return inset_quad(nodes, {0.5 * street_width(r, false), 0.5 * street_width(c + 1, true),
                              0.5 * street_width(r + 1, false), 0.5 * street_width(c, true)});
}

Quad CityPlan::with_streets(BlockIndex index) const {
    const auto [c, r] = index;
    return inset_quad(kerb(index), {-street_width(r, false), -street_width(c + 1, true), -street_width(r + 1, false),
                                    -street_width(c, true)});
}

DVec2 CityPlan::middle(BlockIndex index) const {
    return DVec2(index.column, index.row) * pitch();
}

double CityPlan::reach(BlockIndex index) const {
    const DVec2 p = middle(index);
    const double fray = 1.0 + 0.05 * (hash_unit(settings_.seed, kEdge, word(index.column), word(index.row)) - 0.5);
    // The norm of order 4, between a square and a disc; square roots are the same on every machine, powers are not.
    return fray * std::sqrt(std::sqrt(p.x * p.x * p.x * p.x + p.y * p.y * p.y * p.y));
}

bool CityPlan::is_before(BlockIndex a, BlockIndex b) const {
    const double ra = reach(a), rb = reach(b);
    return ra != rb ? ra < rb : a < b;
}

std::vector<BlockIndex> CityPlan::blocks_within(double limit_m) const {
    const int side = int(limit_m * 1.1 / pitch()) + 1;
    std::vector<std::pair<double, BlockIndex>> keyed;
    for (int row = -side; row <= side; ++row)
        for (int column = -side; column <= side; ++column) {
            const BlockIndex index{column, row};
            if (const double key = reach(index); key <= limit_m) keyed.emplace_back(key, index);
        }
    std::sort(keyed.begin(), keyed.end());
    std::vector<BlockIndex> blocks;
    for (const auto& [key, index] : keyed) blocks.push_back(index);
    return blocks;
}

CityBlock CityPlan::block(BlockIndex index) const {
    CityBlock block;
    block.index = index;
    block.kerb = kerb(index);
    block.seed = hash_mix(settings_.seed, kBlocks, word(index.column), word(index.row));
    // Every square of the city's first size has a centre of its own, so that what grows is as dense as what was.
    const DVec2 p = middle(index);
    const int a = int(std::floor(p.x / settings_.size_m + 0.5)), b = int(std::floor(p.y / settings_.size_m + 0.5));
    DVec2 center = DVec2(a, b) * settings_.size_m;
    double radius = settings_.downtown_m;
    if (a != 0 || b != 0) {
        const std::uint64_t place = hash_mix(settings_.seed, kCenters, word(a), word(b));
        center += 0.12 * settings_.size_m * DVec2(2 * hash_unit(place, 1) - 1, 2 * hash_unit(place, 2) - 1);
        radius *= 0.85 + 0.3 * hash_unit(place, 3);
    }
    block.centrality = glm::length(p - center) / std::max(radius, 1.0);

    const double dice = hash_unit(block.seed, kKinds, 1), blur = 0.3 * (hash_unit(block.seed, kKinds, 2) - 0.5);
    if (index == BlockIndex{1, 0})
        block.kind = BlockKind::square;
    else if (block.centrality > 0.45 && dice < 0.05)
        block.kind = BlockKind::park;
    else if (block.centrality + 0.5 * blur < 1.0)
        block.kind = BlockKind::downtown;
    else if (block.centrality + blur < 1.45)
        block.kind = BlockKind::perimeter;
    return block;
}

}  // namespace ff::cook::city
