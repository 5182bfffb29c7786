#include "tools/cook/ground_map.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>
#include <utility>

#include "engine/core/jobs.h"
#include "tools/cook/ground_cells.h"

namespace ff::cook {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();
constexpr double kHalfWindow_m = 256.0;
constexpr double kMargin_m = 24.0;        // of free ground around a world that has none of its own
constexpr double kMostFragments = 150e6;  // cells covered by triangles, all layers
constexpr int kStripRows = 32;
constexpr float kStep_m = 0.4f;          // what a foot steps over
constexpr float kLeavesAtFeet_m = 0.6f;  // grass
constexpr float kHead_m = static_cast<float>(GroundMap::kHeadroom_m);

// What one triangle puts into one column.
struct Fragment {
    std::uint32_t column = 0;  // within the strip
    float low = 0, high = 0;
    SurfaceKind kind = SurfaceKind::wall;
};

struct Floor {
    std::uint32_t column = 0;
    float y = 0, ceiling = 0;
    bool is_open = false;
};

// What comes out of a strip of rows.
struct Strip {
    std::vector<Floor> floors;   // the triangles' own
    std::vector<Floor> made_up;  // on the ground at the feet of things
    std::uint64_t empty_columns = 0;
};

// The ground for worlds without one: the lowest thing around each place, filled and smoothed.
class FootLevel {
  public:
    explicit FootLevel(const DensityMap& map) : map_(map), level_(map.low) {
        const int w = map.width, d = map.depth;
        spread_minimum(w, d);
        fill(w, d);
        for (int pass = 0; pass < 3; ++pass) blur(w, d);
    }

    [[nodiscard]] double at(double x, double z) const {
        const double u = std::clamp((x - map_.low_x) / map_.cell_m - 0.5, 0.0, map_.width - 1.0);
        const double v = std::clamp((z - map_.low_z) / map_.cell_m - 0.5, 0.0, map_.depth - 1.0);
        const int i = std::min(int(u), std::max(0, map_.width - 2)), j = std::min(int(v), std::max(0, map_.depth - 2));
        const int i1 = std::min(i + 1, map_.width - 1), j1 = std::min(j + 1, map_.depth - 1);
        const double a = cell(i, j) + (cell(i1, j) - cell(i, j)) * (u - i);
        const double b = cell(i, j1) + (cell(i1, j1) - cell(i, j1)) * (u - i);
        return a + (b - a) * (v - j);
    }

  private:
    [[nodiscard]] double cell(int x, int z) const { return level_[std::size_t(z) * std::size_t(map_.width) + x]; }

    template <class Combine>
    void combine_squares(int w, int d, Combine&& combine) {
        const std::vector<float> old = level_;
        for (int z = 0; z < d; ++z)
            for (int x = 0; x < w; ++x) {
                float result = 0;
                int count = 0;
                for (int j = std::max(0, z - 1); j <= std::min(d - 1, z + 1); ++j)
                    for (int i = std::max(0, x - 1); i <= std::min(w - 1, x + 1); ++i)
                        combine(result, count, old[std::size_t(j) * std::size_t(w) + i]);
                if (count > 0) level_[std::size_t(z) * std::size_t(w) + x] = result / float(std::max(1, count));
            }
    }
    void spread_minimum(int w, int d) {
        combine_squares(w, d, [](float& lowest, int& count, float value) {
            if (value < kInfinity) lowest = count == 0 ? value : std::min(lowest, value), count = 1;
        });
    }
    void blur(int w, int d) {
        combine_squares(w, d, [](float& sum, int& count, float value) { sum += value, ++count; });
    }
    // Grows the known part ring by ring.
    void fill(int w, int d) {
        std::vector<std::size_t> ring, next;
        for (std::size_t i = 0; i < level_.size(); ++i)
            if (level_[i] < kInfinity) ring.push_back(i);
        for (; !ring.empty(); std::swap(ring, next), next.clear())
            for (const std::size_t i : ring) {
                const int x = int(i % std::size_t(w)), z = int(i / std::size_t(w));
                for (const auto& [dx, dz] : {std::pair(-1, 0), {1, 0}, {0, -1}, {0, 1}}) {
                    if (x + dx < 0 || x + dx >= w || z + dz < 0 || z + dz >= d) continue;
                    const std::size_t other = std::size_t(z + dz) * std::size_t(w) + std::size_t(x + dx);
                    if (level_[other] < kInfinity) continue;
                    level_[other] = level_[i];
                    next.push_back(other);
                }
            }
    }

    const DensityMap& map_;
    std::vector<float> level_;
};

double covered_cells(const StaticTriangles& triangles, const GroundMap& map) {
    const double high_x = map.low_x + map.width * map.cell_m, high_z = map.low_z + map.depth * map.cell_m;
    std::vector<double> sums(triangles.pieces().size(), 0.0);
    parallel_ranges(sums.size(), 64, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            const DBox3& box = triangles.pieces()[i].bounds;
            if (box.high.x < map.low_x || box.low.x > high_x || box.high.z < map.low_z || box.low.z > high_z) continue;
            triangles.visit(triangles.pieces()[i], [&](const WorldTriangle& t) {
                const auto [x0, x1] = std::minmax({t.corners[0].x, t.corners[1].x, t.corners[2].x});
                const auto [z0, z1] = std::minmax({t.corners[0].z, t.corners[1].z, t.corners[2].z});
                const double dx = std::min(x1, high_x) - std::max(x0, map.low_x);
                const double dz = std::min(z1, high_z) - std::max(z0, map.low_z);
                if (dx >= 0.0 && dz >= 0.0) sums[i] += (dx / map.cell_m + 1.0) * (dz / map.cell_m + 1.0);
            });
        }
    });
    double sum = 0;
    for (const double s : sums) sum += s;
    return sum;
}

// Turns the fragments of one column, sorted by their low ends, into floors.
void find_floors(const Fragment* begin, const Fragment* end, std::uint32_t column, float foot_level, float top,
                 Strip& out) {
    const auto blocked_by_leaves = [&](float y) {
        return std::any_of(begin, end, [&](const Fragment& f) {
            return f.kind == SurfaceKind::foliage && f.high > y + kLeavesAtFeet_m && f.low < y + kHead_m;
        });
    };
    float high = -kInfinity, floor_below = -kInfinity, made_up_ceiling = kInfinity;
    bool is_floor = false, made_up_free = true;
    const auto close_span = [&](float ceiling) {
        // A low thing upon a floor is stepped over.
        const bool stands = is_floor || (floor_below > -kInfinity && high - floor_below <= kStep_m);
        if (high > -kInfinity && stands) {
            floor_below = high;
            if (ceiling - high >= kHead_m && !blocked_by_leaves(high))
                out.floors.push_back({column, high, ceiling, top <= high + kLeavesAtFeet_m});
        }
    };
    for (const Fragment* f = begin; f != end; ++f) {
        if (f->kind == SurfaceKind::foliage) continue;
        const bool is_flat = f->kind == SurfaceKind::floor;
        if (f->high > foot_level + kStep_m) {
            made_up_free = made_up_free && f->low >= foot_level + kHead_m;
            made_up_ceiling = std::min(made_up_ceiling, f->low);
        }
        if (f->low > high) {
            close_span(f->low);
            high = f->high;
            is_floor = is_flat;
        } else if (f->high > high + 0.1f) {
            high = f->high;
            is_floor = is_flat;
        } else if (f->high >= high - 0.1f) {
            high = std::max(high, f->high);
            is_floor = is_floor || is_flat;
        }
    }
    close_span(kInfinity);
    if (made_up_free && !blocked_by_leaves(foot_level))
        out.made_up.push_back({column, foot_level, made_up_ceiling, top <= foot_level + kLeavesAtFeet_m});
}

Strip rasterise_strip(const StaticTriangles& triangles, const std::vector<std::uint32_t>& pieces, int first_row,
                      const FootLevel& foot_level, GroundMap& map) {
    const CellRect rect{0, first_row, map.width, std::min(map.depth, first_row + kStripRows)};
    const std::size_t first_column = std::size_t(first_row) * std::size_t(map.width);
    const std::size_t columns = std::size_t(rect.z1 - rect.z0) * std::size_t(map.width);
    std::vector<Fragment> fragments;
    for (const std::uint32_t piece : pieces)
        triangles.visit(triangles.pieces()[piece], [&](const WorldTriangle& triangle) {
            std::array<DVec3, 3> corners;
            for (std::size_t c = 0; c < 3; ++c) {
                const DVec3& p = triangle.corners[c];
                corners[c] = DVec3((p.x - map.low_x) / map.cell_m, p.y - map.base_y, (p.z - map.low_z) / map.cell_m);
            }
            for_each_cell(corners, rect, [&](int x, int z, double low, double high) {
                const auto column = static_cast<std::uint32_t>((z - first_row) * map.width + x);
                fragments.push_back({column, float(low), float(high), triangle.kind});
            });
        });

    // By column, and by height in each.
    std::vector<std::uint32_t> first(columns + 1, 0);
    for (const Fragment& f : fragments) ++first[f.column + 1];
    for (std::size_t c = 0; c < columns; ++c) first[c + 1] += first[c];
    std::vector<Fragment> sorted(fragments.size());
    std::vector<std::uint32_t> next(first.begin(), first.end() - 1);
    for (const Fragment& f : fragments) sorted[next[f.column]++] = f;
    fragments = {};

    Strip strip;
    for (std::size_t c = 0; c < columns; ++c) {
        Fragment *begin = sorted.data() + first[c], *end = sorted.data() + first[c + 1];
        std::sort(begin, end, [](const Fragment& a, const Fragment& b) {
            return std::tie(a.low, a.high, a.kind) < std::tie(b.low, b.high, b.kind);
        });
        float top = -kInfinity;
        for (const Fragment* f = begin; f != end; ++f) top = std::max(top, f->high);
        map.top[first_column + c] = top;
        strip.empty_columns += begin == end;
        const double x = map.low_x + (double(c % std::size_t(map.width)) + 0.5) * map.cell_m;
        const double z = map.low_z + (first_row + double(c / std::size_t(map.width)) + 0.5) * map.cell_m;
        find_floors(begin, end, static_cast<std::uint32_t>(first_column + c), float(foot_level.at(x, z) - map.base_y),
                    top, strip);
    }
    return strip;
}

void take_floors(const std::vector<Strip>& strips, std::vector<Floor> Strip::*which, GroundMap& map) {
    map.nodes.clear();
    map.first_node.assign(std::size_t(map.width) * std::size_t(map.depth) + 1, 0);
    for (const Strip& strip : strips)
        for (const Floor& floor : strip.*which) {
            map.nodes.push_back(
                {.y = floor.y, .ceiling = floor.ceiling, .is_open = floor.is_open, .column = floor.column});
            ++map.first_node[floor.column + 1];
        }
    for (std::size_t c = 0; c + 1 < map.first_node.size(); ++c) map.first_node[c + 1] += map.first_node[c];
}

void join_neighbours(GroundMap& map) {
    const auto step = static_cast<float>(map.step_m());
    parallel_ranges(map.nodes.size(), 1 << 16, [&](std::size_t begin, std::size_t end) {
        for (std::size_t n = begin; n < end; ++n) {
            GroundNode& node = map.nodes[n];
            const int x = int(node.column % std::uint32_t(map.width)), z = int(node.column / std::uint32_t(map.width));
            constexpr std::array<std::pair<int, int>, 4> kSides{{{-1, 0}, {0, -1}, {1, 0}, {0, 1}}};
            for (std::size_t side = 0; side < 4; ++side) {
                const int i = x + kSides[side].first, j = z + kSides[side].second;
                if (i < 0 || i >= map.width || j < 0 || j >= map.depth) continue;
                const std::size_t column = std::size_t(j) * std::size_t(map.width) + std::size_t(i);
                float best = step;
                for (std::uint32_t m = map.first_node[column]; m < map.first_node[column + 1]; ++m) {
                    const GroundNode& other = map.nodes[m];
                    const float gap = std::min(node.ceiling, other.ceiling) - std::max(node.y, other.y);
                    const float difference = std::abs(other.y - node.y);
                    if (difference <= best && gap >= kHead_m - kStep_m) best = difference, node.neighbours[side] = m;
                }
            }
        }
    });
}

// Chamfer distances, twice over all nodes.
void measure_clearance(GroundMap& map) {
    constexpr float kDiagonal = 1.41421356f;
    for (GroundNode& node : map.nodes) {
        const bool is_border =
            std::find(node.neighbours.begin(), node.neighbours.end(), GroundNode::kNone) != node.neighbours.end();
        node.clearance_m = is_border ? 0.0f : kInfinity;
    }
    const auto relax = [&](GroundNode& node, std::size_t side, std::size_t turn_a, std::size_t turn_b) {
        const std::uint32_t straight = node.neighbours[side];
        if (straight == GroundNode::kNone) return;
        const GroundNode& next = map.nodes[straight];
        node.clearance_m = std::min(node.clearance_m, next.clearance_m + 1.0f);
        for (const std::size_t turn : {turn_a, turn_b})
            if (next.neighbours[turn] != GroundNode::kNone)
                node.clearance_m = std::min(node.clearance_m, map.nodes[next.neighbours[turn]].clearance_m + kDiagonal);
    };
    for (std::size_t n = 0; n < map.nodes.size(); ++n) {
        relax(map.nodes[n], 0, 1, 3);
        relax(map.nodes[n], 1, 0, 2);
    }
    for (std::size_t n = map.nodes.size(); n-- > 0;) {
        relax(map.nodes[n], 2, 1, 3);
        relax(map.nodes[n], 3, 0, 2);
    }
    // The border's own middle is half a cell away from what ends it.
    for (GroundNode& node : map.nodes)
        node.clearance_m = (std::min(node.clearance_m, 1e6f) + 0.5f) * static_cast<float>(map.cell_m);
}

void find_regions(GroundMap& map) {
    map.region_cells.clear();
    std::vector<std::uint32_t> stack;
    for (std::uint32_t seed = 0; seed < map.nodes.size(); ++seed) {
        const auto is_free = [&](const GroundNode& node) {
            return node.region == GroundNode::kNone && node.clearance_m >= float(GroundMap::kRegionClearance_m);
        };
        if (!is_free(map.nodes[seed])) continue;
        const auto region = static_cast<std::uint32_t>(map.region_cells.size());
        map.region_cells.push_back(0);
        map.nodes[seed].region = region;
        stack.push_back(seed);
        while (!stack.empty()) {
            const GroundNode& node = map.nodes[stack.back()];
            stack.pop_back();
            ++map.region_cells[region];
            for (const std::uint32_t m : node.neighbours)
                if (m != GroundNode::kNone && is_free(map.nodes[m])) {
                    map.nodes[m].region = region;
                    stack.push_back(m);
                }
        }
    }
}

void connect(const std::vector<Strip>& strips, std::vector<Floor> Strip::*which, GroundMap& map) {
    take_floors(strips, which, map);
    join_neighbours(map);
    measure_clearance(map);
    find_regions(map);
}

// A city without ground: one could walk nowhere but on roofs, each for itself and high above the feet of the walls, and
// between them is a lot of nothing.
bool lacks_ground(const GroundMap& map, const std::vector<Strip>& strips, const FootLevel& foot_level) {
    std::uint64_t empty = 0, all = 0;
    for (const Strip& strip : strips) empty += strip.empty_columns;
    for (const std::uint32_t cells : map.region_cells) all += cells;
    const auto largest = std::max_element(map.region_cells.begin(), map.region_cells.end());
    if (largest == map.region_cells.end()) return true;
    if (2 * std::uint64_t(*largest) > empty || 6 * std::uint64_t(*largest) > all) return false;
    const auto region = static_cast<std::uint32_t>(largest - map.region_cells.begin());
    double height = 0;
    for (const GroundNode& node : map.nodes)
        if (node.region == region) {
            const PointXZ at = map.middle_of(node);
            height += node.y + map.base_y - foot_level.at(at.x, at.z);
        }
    return height / *largest > kHead_m;
}

}  // namespace

std::uint32_t GroundMap::node_at(double x, double z, double y, double reach_m) const {
    const double u = std::floor((x - low_x) / cell_m), v = std::floor((z - low_z) / cell_m);
    if (!(u >= 0 && u < width && v >= 0 && v < depth)) return GroundNode::kNone;
    const std::size_t column = std::size_t(v) * std::size_t(width) + std::size_t(u);
    std::uint32_t best = GroundNode::kNone;
    for (std::uint32_t n = first_node[column]; n < first_node[column + 1]; ++n)
        if (const double d = std::abs(nodes[n].y + base_y - y); d <= reach_m) best = n, reach_m = d;
    return best;
}

double GroundMap::top_near(double x, double z, double half_side_m) const {
    const auto cell = [&](double v, double low, int count) {
        return static_cast<int>(std::clamp(std::floor((v - low) / cell_m), 0.0, double(count - 1)));
    };
    double highest = -std::numeric_limits<double>::infinity();
    for (int j = cell(z - half_side_m, low_z, depth); j <= cell(z + half_side_m, low_z, depth); ++j)
        for (int i = cell(x - half_side_m, low_x, width); i <= cell(x + half_side_m, low_x, width); ++i)
            highest = std::max(highest, base_y + top[std::size_t(j) * std::size_t(width) + std::size_t(i)]);
    return highest;
}

GroundMap make_ground_map(const StaticTriangles& triangles, const DensityMap& density, PointXZ center) {
    GroundMap map;
    const DBox3& bounds = triangles.bounds();
    if (bounds.is_empty()) return map;
    map.low_x = std::max(bounds.low.x - kMargin_m, center.x - kHalfWindow_m);
    map.low_z = std::max(bounds.low.z - kMargin_m, center.z - kHalfWindow_m);
    const double high_x = std::min(bounds.high.x + kMargin_m, center.x + kHalfWindow_m);
    const double high_z = std::min(bounds.high.z + kMargin_m, center.z + kHalfWindow_m);
    if (high_x <= map.low_x || high_z <= map.low_z) return map;  // the place is far outside of the world
    map.low_x = std::floor(map.low_x), map.low_z = std::floor(map.low_z);
    const FootLevel foot_level(density);
    map.base_y = std::round(foot_level.at(center.x, center.z));
    for (const double cell : {0.5, 0.7, 1.0, 1.4, 2.0, 3.0, 4.0, 6.0, 8.0}) {
        map.cell_m = cell;
        map.width = static_cast<int>(std::ceil((high_x - map.low_x) / cell));
        map.depth = static_cast<int>(std::ceil((high_z - map.low_z) / cell));
        if (covered_cells(triangles, map) <= kMostFragments) break;
    }
    map.top.assign(std::size_t(map.width) * std::size_t(map.depth), -kInfinity);

    const int count = (map.depth + kStripRows - 1) / kStripRows;
    const auto pieces = pieces_by_strip(triangles, map.low_x, map.low_x + map.width * map.cell_m, map.low_z,
                                        kStripRows * map.cell_m, count);
    std::vector<Strip> strips(static_cast<std::size_t>(count));
    parallel_for(strips.size(), [&](std::size_t s) {
        strips[s] = rasterise_strip(triangles, pieces[s], int(s) * kStripRows, foot_level, map);
    });
    connect(strips, &Strip::floors, map);
    if (lacks_ground(map, strips, foot_level)) {
        map.is_made_up = true;
        connect(strips, &Strip::made_up, map);
    }
    return map;
}

}  // namespace ff::cook
