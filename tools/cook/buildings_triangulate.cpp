#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "tools/cook/buildings_footprint.h"

namespace ff::cook {
namespace {

double cross(const DVec2& o, const DVec2& a, const DVec2& b) {
    return (a.x - o.x) * (b.y - o.y) - (a.y - o.y) * (b.x - o.x);
}

/// Inclusive of the border; a, b, c counter-clockwise.
bool in_triangle(const DVec2& a, const DVec2& b, const DVec2& c, const DVec2& p) {
    return cross(a, b, p) >= 0 && cross(b, c, p) >= 0 && cross(c, a, p) >= 0;
}

/// One closed outline as a list of point ids; bridges visit their ends twice.
class EarClipper {
  public:
    EarClipper(const Ring& outer, std::span<const Ring> holes) {
        points_ = outer;
        outline_.resize(outer.size());
        std::iota(outline_.begin(), outline_.end(), 0u);
        std::vector<std::vector<std::uint32_t>> hole_ids;
        for (const Ring& hole : holes) {
            std::vector<std::uint32_t> ids(hole.size());
            std::iota(ids.begin(), ids.end(), std::uint32_t(points_.size()));
            points_.insert(points_.end(), hole.begin(), hole.end());
            // Begin at the hole's easternmost point.
            const auto east = std::max_element(
                ids.begin(), ids.end(), [&](std::uint32_t a, std::uint32_t b) { return points_[a].x < points_[b].x; });
            std::rotate(ids.begin(), east, ids.end());
            if (ids.size() >= 3) hole_ids.push_back(std::move(ids));
        }
        // From east to west, so that a bridge never needs to cross a hole that is not joined yet.
        std::stable_sort(hole_ids.begin(), hole_ids.end(),
                         [&](const auto& a, const auto& b) { return points_[a[0]].x > points_[b[0]].x; });
        for (const auto& ids : hole_ids) join(ids);
    }

    std::vector<std::uint32_t> clip() {
        std::vector<std::uint32_t> triangles;
        std::size_t at = 0, since_ear = 0;
        while (outline_.size() > 3) {
            at %= outline_.size();
            if (is_ear(at) || since_ear > outline_.size()) {
                if (since_ear > outline_.size()) at = least_bad_corner();
                cut(at, triangles);
                since_ear = 0;
                // Going on behind the next corner spreads the cuts, which makes fewer slivers than a fan.
            } else {
                ++since_ear;
            }
            ++at;
        }
        if (outline_.size() == 3) cut(1, triangles);
        return triangles;
    }

  private:
    const DVec2& point(std::size_t place) const { return points_[outline_[place % outline_.size()]]; }

    void join(const std::vector<std::uint32_t>& hole) {
        // A ray to the east from the hole's easternmost point hits the outline's edge (q, q + 1) nearest.
        const DVec2 m = points_[hole[0]];
        double nearest = std::numeric_limits<double>::infinity();
        std::size_t bridge = 0;
        for (std::size_t i = 0; i < outline_.size(); ++i) {
            const DVec2 &a = point(i), &b = point(i + 1);
            if (a == m && sees(i, points_[hole[1]])) {  // the hole touches a corner: joined by a bridge of no length
                insert_hole(i, hole);
                return;
            }
            if ((a.y > m.y) == (b.y > m.y) && a.y != m.y && b.y != m.y) continue;
            if (a.y == b.y) continue;
            const double t = (m.y - a.y) / (b.y - a.y);
            if (t < 0 || t > 1) continue;
            const double x = a.x + t * (b.x - a.x);
            if (x < m.x || x >= nearest) continue;
            nearest = x;
            bridge = a.x > b.x ? i : (i + 1) % outline_.size();
        }
        // The edge's eastern end is visible unless a reflex corner stands in the triangle (m, hit, end); then the one
        // nearest in angle is.
        if (std::isfinite(nearest)) {
            const DVec2 hit{nearest, m.y}, end = point(bridge);
            double best = std::numeric_limits<double>::infinity();
            for (std::size_t i = 0; i < outline_.size(); ++i) {
                if (point(i) == end) continue;
                const DVec2& p = point(i);
                const bool inside = end.y > m.y ? in_triangle(m, hit, end, p) : in_triangle(m, end, hit, p);
                if (!inside || p.x < m.x) continue;
                if (!sees(i, m)) continue;
                const double dx = p.x - m.x, dy = std::abs(p.y - m.y);
                const double slope = dx > 0 ? dy / dx : (dy > 0 ? 1e300 : 0.0);
                if (slope < best) {
                    best = slope;
                    bridge = i;
                }
            }
        }
        // Earlier bridges visit a corner several times: take the visit on whose side the hole lies.
        if (!sees(bridge, m))
            for (std::size_t i = 0; i < outline_.size(); ++i)
                if (point(i) == point(bridge) && sees(i, m)) {
                    bridge = i;
                    break;
                }
        insert_hole(bridge, hole);
    }

    // outline .. b [hole[0] .. hole[n-1] hole[0]] b ..
    void insert_hole(std::size_t bridge, const std::vector<std::uint32_t>& hole) {
        std::vector<std::uint32_t> inserted(hole);
        inserted.push_back(hole[0]);
        inserted.push_back(outline_[bridge]);
        outline_.insert(outline_.begin() + std::ptrdiff_t(bridge) + 1, inserted.begin(), inserted.end());
    }

    /// Whether p lies within the angle of the corner at `at`, on the polygon's side.
    bool sees(std::size_t at, const DVec2& p) const {
        const DVec2 &before = point(at + outline_.size() - 1), &corner = point(at), &after = point(at + 1);
        const bool left_of_before = cross(before, corner, p) > 0, left_of_after = cross(corner, after, p) > 0;
        return cross(before, corner, after) > 0 ? left_of_before && left_of_after : left_of_before || left_of_after;
    }

    bool is_ear(std::size_t at) const {
        const std::size_t n = outline_.size();
        const DVec2 &a = point(at + n - 1), &b = point(at), &c = point(at + 1);
        if (cross(a, b, c) <= 0) return false;
        const double low_x = std::min({a.x, b.x, c.x}), high_x = std::max({a.x, b.x, c.x});
        const double low_y = std::min({a.y, b.y, c.y}), high_y = std::max({a.y, b.y, c.y});
        for (std::size_t i = 0; i < n; ++i) {
            const DVec2& p = point(i);
            if (p.x < low_x || p.x > high_x || p.y < low_y || p.y > high_y) continue;
            if (p == a || p == b || p == c) continue;
            if (!in_triangle(a, b, c, p)) continue;
            if (cross(point(i + n - 1), p, point(i + 1)) <= 0) return false;
        }
        return true;
    }

    /// No ear: the outline crosses or touches itself. Prefer corners without area, then the smallest convex one.
    std::size_t least_bad_corner() const {
        const std::size_t n = outline_.size();
        std::size_t best = 0;
        double best_cost = std::numeric_limits<double>::infinity();
        for (std::size_t i = 0; i < n; ++i) {
            const double area = cross(point(i + n - 1), point(i), point(i + 1));
            const double cost = area >= 0 ? area : 1e9 - area;
            if (cost < best_cost) {
                best_cost = cost;
                best = i;
            }
        }
        return best;
    }

    void cut(std::size_t at, std::vector<std::uint32_t>& triangles) {
        const std::size_t n = outline_.size();
        const std::uint32_t a = outline_[(at + n - 1) % n], b = outline_[at], c = outline_[(at + 1) % n];
        if (cross(points_[a], points_[b], points_[c]) > 0) triangles.insert(triangles.end(), {a, b, c});
        outline_.erase(outline_.begin() + std::ptrdiff_t(at));
    }

    std::vector<DVec2> points_;
    std::vector<std::uint32_t> outline_;
};

}  // namespace

double signed_area(std::span<const DVec2> ring) {
    if (ring.empty()) return 0.0;
    double twice = 0;
    for (std::size_t i = 0; i < ring.size(); ++i) twice += cross(ring[0], ring[i], ring[(i + 1) % ring.size()]);
    return 0.5 * twice;
}

bool contains(std::span<const DVec2> ring, const DVec2& p) {
    bool inside = false;
    for (std::size_t i = 0, j = ring.size() - 1; i < ring.size(); j = i++) {
        const DVec2 &a = ring[i], &b = ring[j];
        if ((a.y > p.y) != (b.y > p.y) && p.x < (b.x - a.x) * (p.y - a.y) / (b.y - a.y) + a.x) inside = !inside;
    }
    return inside;
}

bool contains(const Footprint& footprint, const DVec2& point) {
    if (footprint.outer.empty() || !contains(footprint.outer, point)) return false;
    return std::none_of(footprint.holes.begin(), footprint.holes.end(),
                        [&](const Ring& hole) { return !hole.empty() && contains(hole, point); });
}

void normalize_ring(Ring& ring, bool counter_clockwise) {
    constexpr double kMinDistance = 0.01, kMinTwiceArea = 1e-4;
    bool changed = true;
    while (changed && ring.size() >= 3) {
        changed = false;
        for (std::size_t i = 0; i < ring.size() && ring.size() >= 3;) {
            const DVec2 &a = ring[(i + ring.size() - 1) % ring.size()], &b = ring[i], &c = ring[(i + 1) % ring.size()];
            const bool repeated = std::hypot(b.x - a.x, b.y - a.y) < kMinDistance;
            if (repeated || std::abs(cross(a, b, c)) < kMinTwiceArea) {
                ring.erase(ring.begin() + std::ptrdiff_t(i));
                changed = true;
            } else {
                ++i;
            }
        }
    }
    const double area = signed_area(ring);
    if (ring.size() < 3 || std::abs(area) < 1e-3) {
        ring.clear();
        return;
    }
    if ((area > 0) != counter_clockwise) std::reverse(ring.begin(), ring.end());
}

std::vector<std::uint32_t> triangulate(const Ring& outer, std::span<const Ring> holes) {
    if (outer.size() < 3) return {};
    return EarClipper(outer, holes).clip();
}

}  // namespace ff::cook
