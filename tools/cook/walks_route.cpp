#include "tools/cook/walks_route.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <glm/geometric.hpp>
#include <limits>
#include <queue>
#include <tuple>

#include "engine/core/jobs.h"

namespace ff::cook {
namespace {

constexpr double kLongestWay_m = 150.0;
constexpr double kSmallestRegion_m2 = 200.0;  // less is a shelf or a crate
constexpr double kSpawnClearance_m = 3.0;
constexpr double kBranch_m = 62.0;  // each side of the spawn point
constexpr int kBearings = 32;
constexpr float kInfinity = std::numeric_limits<float>::infinity();

bool is_roomy(const GroundNode& node) {
    return node.region != GroundNode::kNone;
}

// Regions that count: not small, and not small beside the largest (a roof beside the streets).
std::vector<bool> regions_worth_the_name(const GroundMap& map) {
    std::uint32_t largest = 0;
    for (const std::uint32_t cells : map.region_cells) largest = std::max(largest, cells);
    std::vector<bool> worth(map.region_cells.size());
    for (std::size_t r = 0; r < worth.size(); ++r)
        worth[r] = map.region_cells[r] >= 0.25 * largest &&
                   map.region_cells[r] * map.cell_m * map.cell_m >= kSmallestRegion_m2;
    return worth;
}

// The node and the distance walked of everything that is reached from a start, ways in the middle of streets first.
struct Reach {
    std::vector<float> cost, length_m;
    std::vector<std::uint32_t> from;
    std::vector<std::uint32_t> order;  // as reached
};

Reach explore(const GroundMap& map, std::uint32_t start, double limit_m) {
    Reach reach{std::vector<float>(map.nodes.size(), kInfinity),
                std::vector<float>(map.nodes.size(), 0.0f),
                std::vector<std::uint32_t>(map.nodes.size(), GroundNode::kNone),
                {}};
    using Entry = std::pair<float, std::uint32_t>;
    std::priority_queue<Entry, std::vector<Entry>, std::greater<>> open;
    reach.cost[start] = 0;
    open.emplace(0.0f, start);
    const auto cell = static_cast<float>(map.cell_m);
    while (!open.empty()) {
        const auto [cost, n] = open.top();
        open.pop();
        if (cost > reach.cost[n]) continue;
        reach.order.push_back(n);
        if (reach.length_m[n] >= limit_m) continue;
        const GroundNode& node = map.nodes[n];
        const auto go = [&](std::uint32_t m, float step) {
            if (m == GroundNode::kNone || !is_roomy(map.nodes[m])) return;
            const GroundNode& next = map.nodes[m];
            const float narrow = 3.0f / std::min(next.clearance_m, 6.0f);
            const float effort =
                1.0f + narrow * narrow + 4.0f * std::abs(next.y - node.y) / step + (next.is_outdoors() ? 0.0f : 3.0f);
            if (const float total = cost + step * effort; total < reach.cost[m]) {
                reach.cost[m] = total;
                reach.length_m[m] = reach.length_m[n] + step;
                reach.from[m] = n;
                open.emplace(total, m);
            }
        };
        for (std::size_t side = 0; side < 4; ++side) {
            const std::uint32_t straight = node.neighbours[side];
            go(straight, cell);
            if (straight != GroundNode::kNone) go(map.nodes[straight].neighbours[(side + 1) % 4], cell * 1.41421356f);
        }
    }
    return reach;
}

// From the start to a node, start first.
std::vector<DVec3> trace(const GroundMap& map, const Reach& reach, std::uint32_t node) {
    std::vector<DVec3> points;
    for (; node != GroundNode::kNone; node = reach.from[node]) {
        const PointXZ at = map.middle_of(map.nodes[node]);
        points.emplace_back(at.x, map.nodes[node].y + map.base_y, at.z);
    }
    std::reverse(points.begin(), points.end());
    return points;
}

double bearing_deg(const DVec3& from, const DVec3& to) {
    return degrees_of(std::atan2(to.x - from.x, from.z - to.z));
}
double angle_between(double a_deg, double b_deg) {
    return std::abs(std::remainder(a_deg - b_deg, 360.0));
}

struct Branch {
    std::vector<DVec3> points;
    double bearing = 0, length_m = 0, effort = 0;
};

// The easiest way of about `length_m` towards each side, or the longest ones where none is so long.
std::vector<Branch> branches_from(const GroundMap& map, std::uint32_t start, double length_m) {
    const Reach reach = explore(map, start, length_m);
    const PointXZ here = map.middle_of(map.nodes[start]);
    float farthest = 0;
    for (const std::uint32_t n : reach.order) farthest = std::max(farthest, reach.length_m[n]);
    const double wanted = std::min(length_m, double(farthest)) - 2.0 * map.cell_m;
    std::array<std::uint32_t, 48> best;
    best.fill(GroundNode::kNone);
    for (const std::uint32_t n : reach.order) {  // cheapest first
        if (reach.length_m[n] < wanted || n == start) continue;
        const PointXZ at = map.middle_of(map.nodes[n]);
        const double turn = degrees_of(std::atan2(at.x - here.x, here.z - at.z)) / 360.0 + 1.0;
        std::uint32_t& slot = best[std::size_t((turn - std::floor(turn)) * 48.0) % 48];
        if (slot == GroundNode::kNone) slot = n;
    }
    std::vector<Branch> branches;
    for (const std::uint32_t n : best) {
        if (n == GroundNode::kNone) continue;
        Branch branch{.points = trace(map, reach, n)};
        branch.length_m = reach.length_m[n];
        branch.effort = reach.cost[n] / std::max(1.0, branch.length_m);
        const std::size_t ahead = std::min(branch.points.size() - 1, std::size_t(12.0 / map.cell_m));
        branch.bearing = bearing_deg(branch.points[0], branch.points[ahead]);
        branches.push_back(std::move(branch));
    }
    return branches;
}

std::vector<DVec3> resample(const std::vector<DVec3>& points, double spacing) {
    std::vector<DVec3> out{points.front()};
    double left = spacing;  // until the next sample
    for (std::size_t i = 1; i < points.size(); ++i) {
        const DVec3 edge = points[i] - points[i - 1];
        const double length = std::hypot(edge.x, edge.z);
        double at = left;
        for (; at <= length; at += spacing) out.push_back(points[i - 1] + edge * (at / length));
        left = at - length;
    }
    return out;
}

// Evens out corners without leaving the roomy ground.
void smooth(const GroundMap& map, std::vector<DVec3>& points) {
    constexpr int kPasses = 300;  // of 0.25 m points: about 3 m to each side
    const double reach = 2.0 * map.step_m();
    for (int pass = 0; pass < kPasses; ++pass)
        for (std::size_t i = 1; i + 1 < points.size(); ++i) {
            DVec3 moved = points[i] * 0.5 + (points[i - 1] + points[i + 1]) * 0.25;
            const std::uint32_t n = map.node_at(moved.x, moved.z, points[i].y, reach);
            if (n == GroundNode::kNone || !is_roomy(map.nodes[n])) continue;
            moved.y = map.nodes[n].y + map.base_y;
            points[i] = moved;
        }
}

// Floors rise in steps; walkers rise smoothly.
void smooth_heights(std::vector<DVec3>& points, int half_width) {
    for (int pass = 0; pass < 3; ++pass) {
        std::vector<double> sums(points.size() + 1, 0.0);
        for (std::size_t i = 0; i < points.size(); ++i) sums[i + 1] = sums[i] + points[i].y - points[0].y;
        const double base = points[0].y;
        for (std::size_t i = 0; i < points.size(); ++i) {
            const auto half = std::min({std::size_t(half_width), i, points.size() - 1 - i});
            points[i].y = base + (sums[i + half + 1] - sums[i - half]) / double(2 * half + 1);
        }
    }
}

}  // namespace

double free_way_m(const GroundMap& map, std::uint32_t node, double bearing) {
    const PointXZ start = map.middle_of(map.nodes[node]);
    const double dx = std::sin(radians_of(bearing)), dz = -std::cos(radians_of(bearing));
    double y = map.nodes[node].y + map.base_y, way = 0;
    while (way < kLongestWay_m) {
        const double next = way + map.cell_m;
        const std::uint32_t n = map.node_at(start.x + dx * next, start.z + dz * next, y, map.step_m() * 1.5);
        if (n == GroundNode::kNone || !is_roomy(map.nodes[n])) break;
        y = map.nodes[n].y + map.base_y;
        way = next;
    }
    return way;
}

FreeWays free_ways(const GroundMap& map, std::uint32_t node) {
    std::array<double, kBearings> ways;
    FreeWays result;
    for (int i = 0; i < kBearings; ++i) {
        ways[std::size_t(i)] = free_way_m(map, node, i * 360.0 / kBearings);
        if (ways[std::size_t(i)] > result.longest_m)
            result.longest_m = ways[std::size_t(i)], result.longest_deg = i * 360.0 / kBearings;
    }
    for (int i = 0; i < kBearings; ++i) {
        const double angle = angle_between(i * 360.0 / kBearings, result.longest_deg);
        if (angle >= 60.0 && angle <= 120.0) result.across_m = std::max(result.across_m, ways[std::size_t(i)]);
    }
    return result;
}

std::uint32_t find_spawn_node(const GroundMap& map, const DensityMap& density) {
    const std::vector<bool> worth = regions_worth_the_name(map);
    struct Candidate {
        double score = 0;
        std::uint32_t node = GroundNode::kNone;
    };
    constexpr std::size_t kMostCandidates = 400;
    std::vector<Candidate> candidates;
    for (const double clearance : {kSpawnClearance_m, GroundMap::kRegionClearance_m}) {
        double most_far = 1, most_near = 1;
        const auto for_each = [&](auto&& use) {
            for (std::uint32_t n = 0; n < map.nodes.size(); ++n) {
                const GroundNode& node = map.nodes[n];
                const auto x = node.column % std::uint32_t(map.width), z = node.column / std::uint32_t(map.width);
                if (!is_roomy(node) || !worth[node.region] || node.clearance_m < clearance) continue;
                if (clearance == kSpawnClearance_m && (x % 6 != 0 || z % 6 != 0)) continue;
                const PointXZ at = map.middle_of(node);
                use(n, double(density.triangles_near(at.x, at.z, 150.0)),
                    double(density.triangles_near(at.x, at.z, 40.0)));
            }
        };
        for_each([&](std::uint32_t, double far, double near) {
            most_far = std::max(most_far, far);
            most_near = std::max(most_near, near);
        });
        for_each([&](std::uint32_t n, double far, double near) {
            const GroundNode& node = map.nodes[n];
            const double sky = node.is_open ? 1.0 : node.is_outdoors() ? 0.7 : 0.3;
            candidates.push_back({sky * (2.0 * far / most_far + near / most_near), n});
        });
        if (!candidates.empty()) break;
    }
    if (candidates.empty()) return GroundNode::kNone;
    const auto better = [](const Candidate& a, const Candidate& b) {
        return std::tuple(-a.score, a.node) < std::tuple(-b.score, b.node);
    };
    const std::size_t kept = std::min(candidates.size(), kMostCandidates);
    std::partial_sort(candidates.begin(), candidates.begin() + std::ptrdiff_t(kept), candidates.end(), better);
    candidates.resize(kept);
    parallel_for(kept, [&](std::size_t i) {
        const FreeWays ways = free_ways(map, candidates[i].node);
        candidates[i].score += 0.5 * std::min(ways.longest_m, 80.0) / 80.0 + 0.7 * std::min(ways.across_m, 60.0) / 60.0;
    });
    return std::min_element(candidates.begin(), candidates.end(), better)->node;
}

std::uint32_t find_node_near(const GroundMap& map, const DVec3& place) {
    const std::vector<bool> worth = regions_worth_the_name(map);
    std::uint32_t best = GroundNode::kNone;
    double best_distance = 60.0;
    for (std::uint32_t n = 0; n < map.nodes.size(); ++n) {
        const GroundNode& node = map.nodes[n];
        if (!is_roomy(node) || !worth[node.region]) continue;
        const PointXZ at = map.middle_of(node);
        const double distance =
            std::hypot(at.x - place.x, at.z - place.z) + 2.0 * std::abs(node.y + map.base_y - place.y);
        if (distance < best_distance) best = n, best_distance = distance;
    }
    return best;
}

DVec3 WalkRoute::at(double s_m) const {
    const double u = std::clamp(s_m / kSpacing_m, 0.0, double(points.size() - 1));
    const auto i = std::min(std::size_t(u), points.size() - 1), j = std::min(i + 1, points.size() - 1);
    return points[i] + (points[j] - points[i]) * (u - double(i));
}

WalkRoute plan_route(const GroundMap& map, std::uint32_t through) {
    const std::vector<Branch> branches = branches_from(map, through, kBranch_m);
    if (branches.empty()) return {};
    // In by one branch, out by another: best around a corner of about 90 degrees, and not back the same way.
    double best_score = -1e30;
    std::pair<std::size_t, std::size_t> best{0, 0};
    for (std::size_t a = 0; a < branches.size(); ++a)
        for (std::size_t b = 0; b < branches.size(); ++b) {
            const double apart = angle_between(branches[a].bearing, branches[b].bearing);  // 180: straight on
            if (a == b || apart < 50.0) continue;
            const double score = -std::abs(apart - 90.0) / 30.0 - branches[a].effort - branches[b].effort;
            if (score > best_score) best_score = score, best = {a, b};
        }
    std::vector<DVec3> points;
    if (best.first != best.second) {
        points.assign(branches[best.first].points.rbegin(), branches[best.first].points.rend());
        points.pop_back();
    }
    const std::vector<DVec3>& out = branches[best.second].points;
    points.insert(points.end(), out.begin(), out.end());
    points = resample(points, 0.25);
    smooth(map, points);
    WalkRoute route{resample(points, WalkRoute::kSpacing_m)};
    smooth_heights(route.points, static_cast<int>(1.0 / WalkRoute::kSpacing_m));
    return route;
}

double find_corner_start(const WalkRoute& route, double length_m, double needed_m) {
    const double last = route.length_m() - needed_m;
    if (last <= 0.0) return 0.0;
    double best = 0, best_score = -1e30;
    for (double s = 0; s <= last; s += 1.0) {
        double turned = 0;
        for (double t = s + 0.2 * length_m; t < s + 0.8 * length_m; t += 4.0)
            turned += angle_between(bearing_deg(route.at(t - 2.0), route.at(t + 2.0)),
                                    bearing_deg(route.at(t + 2.0), route.at(t + 6.0)));
        const double score = std::min(turned, 150.0) - std::abs(s + length_m / 2 - route.length_m() / 2);
        if (score > best_score) best_score = score, best = s;
    }
    return best;
}

}  // namespace ff::cook
