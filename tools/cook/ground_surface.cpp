#include "tools/cook/ground_surface.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>

#include "engine/math/bounds.h"

namespace ff::cook {

GroundSurface::GroundSurface(const WorldSource& world, std::size_t first, std::size_t end) {
    DBox3 bounds;
    for (std::size_t place = first; place < end; ++place) {
        const Placement& placement = world.placements[place];
        if (placement.kind == PlacementKind::dynamic) continue;
        const scene::MeshSource& mesh = world.meshes[placement.mesh].geometry;
        const DMat3 turn(placement.world_from_mesh);
        const bool mirrored = glm::dot(turn[0], glm::cross(turn[1], turn[2])) < 0;
        const auto corner = [&](std::size_t c) {
            return placement.position + turn * DVec3(mesh.positions[mesh.indices[c]]);
        };
        for (std::size_t i = 0; i + 2 < mesh.indices.size(); i += 3) {
            Triangle t{corner(i), corner(i + 1), corner(i + 2)};
            if (mirrored) std::swap(t.b, t.c);
            const DVec3 normal = glm::cross(t.b - t.a, t.c - t.a);
            if (!(normal.y > 0.2 * glm::length(normal))) continue;
            for (const DVec3& p : {t.a, t.b, t.c}) bounds.add(p);
            triangles_.push_back(t);
        }
    }
    if (triangles_.empty()) return;
    const double width = bounds.high.x - bounds.low.x, depth = bounds.high.z - bounds.low.z;
    // About one triangle a square, at most 2048 squares a side.
    square_m_ = std::max({std::sqrt(width * depth / double(triangles_.size())), width / 2048, depth / 2048, 1e-3});
    low_x_ = bounds.low.x, low_z_ = bounds.low.z;
    columns_ = int(width / square_m_) + 1, rows_ = int(depth / square_m_) + 1;
    const auto each_square = [&](const Triangle& t, const auto& visit) {
        const auto range = [&](double low, double high, double origin, int count) {
            return std::pair(std::clamp(int((low - origin) / square_m_), 0, count - 1),
                             std::clamp(int((high - origin) / square_m_), 0, count - 1));
        };
        const auto [x0, x1] = range(std::min({t.a.x, t.b.x, t.c.x}), std::max({t.a.x, t.b.x, t.c.x}), low_x_, columns_);
        const auto [z0, z1] = range(std::min({t.a.z, t.b.z, t.c.z}), std::max({t.a.z, t.b.z, t.c.z}), low_z_, rows_);
        for (int z = z0; z <= z1; ++z)
            for (int x = x0; x <= x1; ++x) visit(std::size_t(z) * std::size_t(columns_) + std::size_t(x));
    };
    first_.assign(std::size_t(columns_) * std::size_t(rows_) + 1, 0);
    for (const Triangle& t : triangles_) each_square(t, [&](std::size_t s) { ++first_[s + 1]; });
    for (std::size_t s = 1; s < first_.size(); ++s) first_[s] += first_[s - 1];
    members_.resize(first_.back());
    std::vector<std::uint32_t> next(first_.begin(), first_.end() - 1);
    for (std::size_t i = 0; i < triangles_.size(); ++i)
        each_square(triangles_[i], [&](std::size_t s) { members_[next[s]++] = std::uint32_t(i); });
}

std::optional<double> GroundSurface::height_at(double x, double z) const {
    const double u = (x - low_x_) / square_m_, v = (z - low_z_) / square_m_;
    if (!(u >= 0 && v >= 0 && u < columns_ && v < rows_)) return std::nullopt;
    const std::size_t square = std::size_t(v) * std::size_t(columns_) + std::size_t(u);
    double top = -std::numeric_limits<double>::infinity();
    for (std::uint32_t m = first_[square]; m < first_[square + 1]; ++m) {
        const Triangle& t = triangles_[members_[m]];
        // Seen from above, z down the page, an upward-facing triangle has these three areas of one sign.
        const auto area = [&](const DVec3& p, const DVec3& q) {
            return (q.z - p.z) * (x - p.x) - (q.x - p.x) * (z - p.z);
        };
        const double wa = area(t.b, t.c), wb = area(t.c, t.a), wc = area(t.a, t.b);
        const double total = wa + wb + wc;
        if (wa < 0 || wb < 0 || wc < 0 || total <= 0) continue;
        top = std::max(top, (wa * t.a.y + wb * t.b.y + wc * t.c.y) / total);
    }
    if (!std::isfinite(top)) return std::nullopt;
    return top;
}

void GrowingGround::update(const WorldSource& world, std::size_t end) {
    const std::size_t first = parts_.empty() ? 0 : parts_.back().end;
    if (first == end) return;
    const auto add = [&](std::size_t from) {
        parts_.push_back({from, end, std::make_shared<const GroundSurface>(world, from, end)});
    };
    add(first);
    while (parts_.size() > 1 &&
           2 * parts_.back().surface->triangle_count() >= parts_[parts_.size() - 2].surface->triangle_count()) {
        const std::size_t from = parts_[parts_.size() - 2].first;
        parts_.resize(parts_.size() - 2);
        add(from);
    }
}

std::function<std::optional<double>(double x, double z)> GrowingGround::now() const {
    return [parts = parts_](double x, double z) {
        std::optional<double> top;
        for (const Part& part : parts)
            if (const auto y = part.surface->height_at(x, z); y && (!top || *y > *top)) top = y;
        return top;
    };
}

}  // namespace ff::cook
