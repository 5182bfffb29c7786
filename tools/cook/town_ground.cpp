#include "tools/cook/town_ground.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace ff::cook {
namespace {

constexpr double kLattice = 160.0;  // m between the heights that the soft ground runs through
constexpr double kSunk = 1.0;       // m

/// Uniform B-spline: smooth, and never beyond the values that it runs between.
double spline(const double h[4], double t) {
    const double u = 1 - t;
    return (h[0] * u * u * u + h[1] * (3 * t * t * t - 6 * t * t + 4) + h[2] * (3 * u * u * u - 6 * u * u + 4) +
            h[3] * t * t * t) /
           6;
}

}  // namespace

TownGround::TownGround(double center_x, double center_z, double flat_radius_m,
                       std::function<double(double, double)> landscape)
    : center_x_(center_x), center_z_(center_z), radius_(flat_radius_m), landscape_(std::move(landscape)) {
    const RectXZ e = extent();
    lattice_x_ = int(std::floor(e.x0 / kLattice)) - 2, lattice_z_ = int(std::floor(e.z0 / kLattice)) - 2;
    columns_ = int(std::ceil(e.x1 / kLattice)) + 4 - lattice_x_;
    const int rows = int(std::ceil(e.z1 / kLattice)) + 4 - lattice_z_;
    lattice_.reserve(std::size_t(columns_) * std::size_t(rows));
    for (int j = 0; j < rows; ++j)
        for (int i = 0; i < columns_; ++i)
            lattice_.push_back(landscape_((lattice_x_ + i) * kLattice, (lattice_z_ + j) * kLattice));
}

RectXZ TownGround::extent() const {
    const double r = radius_ + kBlend;
    return {center_x_ - r, center_z_ - r, center_x_ + r, center_z_ + r};
}

double TownGround::height_at(double x, double z) const {
    const double from_center = std::hypot(x - center_x_, z - center_z_);
    if (from_center >= radius_ + kBlend) return landscape_(x, z);
    const double u = x / kLattice - lattice_x_, v = z / kLattice - lattice_z_;
    const int i = int(u), j = int(v);
    double rows[4];
    for (int r = 0; r < 4; ++r)
        rows[r] = spline(&lattice_[std::size_t(j - 1 + r) * std::size_t(columns_) + std::size_t(i - 1)], u - i);
    const double soft = spline(rows, v - j);
    const double t = std::clamp((from_center - radius_) / kBlend, 0.0, 1.0);
    return t <= 0 ? soft : soft + t * t * (3 - 2 * t) * (landscape_(x, z) - soft);
}

void shape_ground(HeightField& field, const TownGround& ground, std::span<const std::array<DVec2, 4>> blocks) {
    const RectXZ e = ground.extent();
    const auto column = [&](double x) {
        return std::clamp(int(std::ceil((x - field.low_x) / field.spacing_x)), 0, field.columns);
    };
    const auto row = [&](double z) {
        return std::clamp(int(std::ceil((z - field.low_z) / field.spacing_z)), 0, field.rows);
    };
    const int c0 = column(e.x0), c1 = column(e.x1), r0 = row(e.z0), r1 = row(e.z1);
    const int width = c1 - c0, depth = r1 - r0;
    if (width <= 0 || depth <= 0) return;
    // Which samples lie in a block; all heights first, as the ground may read the field.
    std::vector<char> covered(std::size_t(width) * std::size_t(depth), 0);
    for (const std::array<DVec2, 4>& block : blocks) {
        DVec2 low = block[0], high = block[0];
        for (const DVec2& p : block) low = glm::min(low, p), high = glm::max(high, p);
        for (int r = std::max(row(low.y), r0); r < std::min(row(high.y), r1); ++r)
            for (int c = std::max(column(low.x), c0); c < std::min(column(high.x), c1); ++c)
                if (contains(block, DVec2(field.low_x + c * field.spacing_x, field.low_z + r * field.spacing_z)))
                    covered[std::size_t(r - r0) * std::size_t(width) + std::size_t(c - c0)] = 1;
    }
    std::vector<float> heights(covered.size());
    for (int r = 0; r < depth; ++r)
        for (int c = 0; c < width; ++c) {
            bool inside = r > 0 && c > 0 && r + 1 < depth && c + 1 < width;
            for (int dr = -1; dr <= 1 && inside; ++dr)
                for (int dc = -1; dc <= 1 && inside; ++dc)
                    inside = covered[std::size_t(r + dr) * std::size_t(width) + std::size_t(c + dc)] != 0;
            const double y =
                ground.height_at(field.low_x + (c0 + c) * field.spacing_x, field.low_z + (r0 + r) * field.spacing_z);
            heights[std::size_t(r) * std::size_t(width) + std::size_t(c)] = float(inside ? y - kSunk : y);
        }
    for (int r = 0; r < depth; ++r)
        std::copy_n(&heights[std::size_t(r) * std::size_t(width)], width,
                    &field.heights[std::size_t(r0 + r) * std::size_t(field.columns) + std::size_t(c0)]);
}

std::vector<RectXZ> bounds_of(std::span<const std::array<DVec2, 4>> blocks, double margin) {
    if (blocks.empty()) return {};
    RectXZ rect{1e18, 1e18, -1e18, -1e18};
    for (const std::array<DVec2, 4>& block : blocks)
        for (const DVec2& p : block) {
            rect.x0 = std::min(rect.x0, p.x - margin), rect.x1 = std::max(rect.x1, p.x + margin);
            rect.z0 = std::min(rect.z0, p.y - margin), rect.z1 = std::max(rect.z1, p.y + margin);
        }
    return {rect};
}

}  // namespace ff::cook
