// HorizonMap: what is traced when, and the tables of the wedges. The walk itself is in horizon_trace.cpp.
#include "engine/farfield/horizon.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>

#include "engine/core/check.h"
#include "engine/core/jobs.h"
#include "engine/farfield/horizon_azimuth.h"
#include "engine/farfield/horizon_near.h"
#include "engine/farfield/horizon_trace.h"

namespace ff::farfield {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();
constexpr int kPadding = 16;  ///< elements that kernels may read beyond the columns

/// Columns by which intervals are widened: several times the rounding error of azimuth_turn.
float margin_of(int columns) {
    return 1e-3f + 1e-6f * float(columns);
}

int modulo(int value, int count) {
    const int rest = value % count;
    return rest < 0 ? rest + count : rest;
}

/// The smallest range that holds both, or nothing (count 0) where they do not touch.
ColumnRange joined(ColumnRange a, ColumnRange b, int columns) {
    const int from_a = modulo(b.first - a.first, columns), from_b = modulo(a.first - b.first, columns);
    if (from_a <= a.count) return {a.first, std::min(columns, std::max(a.count, from_a + b.count))};
    if (from_b <= b.count) return {b.first, std::min(columns, std::max(b.count, from_b + a.count))};
    return {};
}

bool contains(ColumnRange outer, int column, int columns) {
    return modulo(column - outer.first, columns) < outer.count;
}

}  // namespace

HorizonMap::HorizonMap(const HorizonSettings& settings) : settings_(settings) {
    FF_CHECK(settings.frames_ahead >= 0 && settings.frames_ahead <= 64, "horizon of {} frames ahead",
             settings.frames_ahead);
    FF_CHECK(settings.fine_squares >= 0 && settings.fine_squares <= 16, "{} fine squares", settings.fine_squares);
    FF_CHECK(settings.columns >= 64 && settings.columns <= kMaxHorizonColumns && settings.columns % 4 == 0,
             "{} horizon columns", settings.columns);
    const std::size_t size = std::size_t(settings.columns) + kPadding;
    for (std::vector<float>* table : {&max_x_, &max_z_, &min_x_, &min_z_}) table->resize(size);
    border_x_.resize(size);
    border_z_.resize(size);
    traced_.assign(size, kInfinity);
    tangents_.assign(size, kInfinity);
    winner_.assign(size, kNoSquare);
    for (Half& half : halves_) {
        half.traced.reserve(size);
        half.winner.reserve(size);
    }
    settings_.near_distance_m = 0.0f;
    settings_.subsample = 0;
    set_quality(settings.near_distance_m, settings.subsample);
}

void HorizonMap::set_quality(float near_distance_m, int subsample) {
    FF_CHECK(near_distance_m >= 0.0f, "near distance {} m", near_distance_m);
    FF_CHECK(subsample == 1 || subsample == 2 || subsample == 4, "subsample {}", subsample);
    if (near_distance_m == settings_.near_distance_m && subsample == settings_.subsample) return;
    const bool other_wedges = subsample != settings_.subsample;
    settings_.near_distance_m = near_distance_m;
    settings_.subsample = subsample;
    if (other_wedges) make_wedges();
    invalidate();
}

void HorizonMap::invalidate() {
    valid_ = {};
    roam_m_ = climb_m_ = 0.0;
    heights_ = nullptr;
    boxes_ = nullptr;
    std::fill(winner_.begin(), winner_.end(), kNoSquare);
    std::fill(tangents_.begin(), tangents_.end(), kInfinity);
}

void HorizonMap::make_wedges() {
    const int columns = settings_.columns / settings_.subsample;
    const double margin = 2.0 * double(margin_of(columns));
    for (int c = 0; c <= columns; ++c) {
        double x, z;
        azimuth_direction(double(c) / columns, x, z);
        border_x_[std::size_t(c)] = float(x);
        border_z_[std::size_t(c)] = float(z);
    }
    for (int c = 0; c < columns; ++c) {
        double x0, z0, x1, z1;
        azimuth_direction((c - margin) / columns, x0, z0);
        azimuth_direction((c + 1 + margin) / columns, x1, z1);
        // Within a wedge |x| and |z| are monotone but where it crosses an axis.
        double max_x = std::max(std::abs(x0), std::abs(x1)), min_x = std::min(std::abs(x0), std::abs(x1));
        double max_z = std::max(std::abs(z0), std::abs(z1)), min_z = std::min(std::abs(z0), std::abs(z1));
        if (x0 * x1 <= 0.0) min_x = 0.0, max_z = 1.0;
        if (z0 * z1 <= 0.0) min_z = 0.0, max_x = 1.0;
        max_x_[std::size_t(c)] = float(max_x * (1.0 + 1e-6));
        max_z_[std::size_t(c)] = float(max_z * (1.0 + 1e-6));
        min_x_[std::size_t(c)] = float(min_x * (1.0 - 1e-6));
        min_z_[std::size_t(c)] = float(min_z * (1.0 - 1e-6));
    }
}

HorizonCost HorizonMap::update(const scene::StaticScene& scene, const PinholeView& view) {
    return trace(&scene, scene.height_grid, view.position, with_margin(&scene, scene.height_grid, view));
}
HorizonCost HorizonMap::update(const scene::StaticScene& scene, const WorldPos& eye, ColumnRange wanted) {
    return trace(&scene, scene.height_grid, eye, wanted);
}
HorizonCost HorizonMap::update(const scene::HeightGrid& grid, const PinholeView& view) {
    return trace(nullptr, grid, view.position, with_margin(nullptr, grid, view));
}
HorizonCost HorizonMap::update(const scene::HeightGrid& grid, const WorldPos& eye, ColumnRange wanted) {
    return trace(nullptr, grid, eye, wanted);
}

bool HorizonMap::is_of(const scene::StaticScene* scene, const scene::HeightGrid& grid) const {
    return heights_ == grid.heights.data() && boxes_ == (scene ? scene->instance_nodes.data() : nullptr);
}

/// The view's columns; where some have to be traced, a little more, so that a turning head does not ask every frame.
ColumnRange HorizonMap::with_margin(const scene::StaticScene* scene, const scene::HeightGrid& grid,
                                    const PinholeView& view) const {
    const int all = settings_.columns;
    const ColumnRange wanted = columns_of_view(view, all);
    const bool known = is_of(scene, grid) && holds_for(view.position) &&
                       (valid_.count == all || modulo(wanted.first - valid_.first, all) + wanted.count <= valid_.count);
    if (known) return wanted;
    const int margin = all / 64;
    return {modulo(wanted.first - margin, all), std::min(all, wanted.count + 2 * margin)};
}

bool HorizonMap::holds_for(const WorldPos& eye) const {
    if (roam_m_ == 0.0) return eye == middle_;
    if (eye == eye_) return false;  // one who stands shall have the best
    const DVec3 from_middle = eye - middle_;
    return std::hypot(from_middle.x, from_middle.z) <= roam_m_ && std::abs(from_middle.y) <= climb_m_;
}

/// Forgets the skyline; what is traced next holds for the eye.
void HorizonMap::move_to(const WorldPos& eye) {
    constexpr double kMostM = 4.0;    // more would hide most of the sky between houses
    constexpr double kUneven = 0.05;  // of the way: what ground and steps do to an eye
    valid_ = {};
    middle_ = eye;
    roam_m_ = climb_m_ = 0.0;
    const DVec3 half = 0.5 * settings_.frames_ahead * (eye - eye_);
    const double roam = std::hypot(half.x, half.z);
    const bool was_here = heights_ != nullptr && roam > 0.0 && glm::length(half) <= kMostM;
    if (!was_here || settings_.near_distance_m > 0.0f) return;
    middle_ += half;
    roam_m_ = roam * (1.0 + 1e-3);
    climb_m_ = std::abs(half.y) * (1.0 + 1e-3) + kUneven * roam;
}

HorizonWedges HorizonMap::wedges(float near_distance) const {
    const int columns = settings_.columns / settings_.subsample;
    return {columns,       max_x_.data(),      max_z_.data(), min_x_.data(),
            min_z_.data(), margin_of(columns), near_distance, 1.0f / near_distance};
}

template <class RaiseBy>
void HorizonMap::raise_halves(RaiseBy&& raise_by, HorizonCost& cost) {
    constexpr std::uint32_t kLeastColumns = 64;  // fewer are not worth a second walk from the root
    if (cost.columns < kLeastColumns) return raise_by(traced_.data(), winner_.data(), cost);
    const auto columns = std::size_t(settings_.columns / settings_.subsample);
    const auto all = std::ptrdiff_t(columns + kPadding);
    for (Half& half : halves_) {
        half.traced.assign(traced_.begin(), traced_.begin() + all);
        half.winner.assign(winner_.begin(), winner_.begin() + all);
        half.cost = {};
    }
    // A column that is not wanted enters as +inf: each half leaves the other's columns out.
    std::uint32_t wanted = 0;
    for (std::size_t c = 0; c < columns; ++c)
        if (traced_[c] != kInfinity) halves_[wanted++ < cost.columns / 2 ? 1 : 0].traced[c] = kInfinity;
    parallel_ranges(halves_.size(), 1, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i)
            raise_by(halves_[i].traced.data(), halves_[i].winner.data(), halves_[i].cost);
    });
    wanted = 0;
    for (std::size_t c = 0; c < columns; ++c) {
        if (traced_[c] == kInfinity) continue;
        const Half& half = halves_[wanted++ < cost.columns / 2 ? 0 : 1];
        traced_[c] = half.traced[c];
        winner_[c] = half.winner[c];
    }
    for (const Half& half : halves_) {
        cost.squares += half.cost.squares;
        cost.boxes += half.cost.boxes;
    }
}

HorizonCost HorizonMap::trace(const scene::StaticScene* scene, const scene::HeightGrid& grid, const WorldPos& eye,
                              ColumnRange wanted) {
    const int all = settings_.columns, step = settings_.subsample;
    if (!is_of(scene, grid)) invalidate();
    if (!holds_for(eye)) move_to(eye);
    heights_ = grid.heights.data();
    boxes_ = scene ? scene->instance_nodes.data() : nullptr;
    eye_ = eye;

    // Whole wedges only.
    const int low = modulo(wanted.first, all) / step * step;
    wanted = {low, std::min(all, (modulo(wanted.first, all) + wanted.count - low + step - 1) / step * step)};

    const ColumnRange before = valid_;
    const ColumnRange after = before.count == 0 ? wanted : joined(before, wanted, all);
    if (after.count == before.count) return {};
    valid_ = after.count == 0 ? wanted : after;
    const bool keep = after.count != 0 && before.count != 0;

    // Columns that are not wanted enter as +inf, so that no square can raise them.
    HorizonCost cost;
    for (int c = 0; c < all / step; ++c) {
        const bool missing = contains(valid_, c * step, all) && !(keep && contains(before, c * step, all));
        traced_[std::size_t(c)] = missing ? -kInfinity : kInfinity;
        cost.columns += missing ? 1u : 0u;
    }
    const double eye_x = (middle_.x - grid.low_x) / grid.square_m, eye_z = (middle_.z - grid.low_z) / grid.square_m;
    const double eye_height = middle_.y - grid.base_y;
    constexpr double kFarthestSquares = 1 << 22;  // beyond, floats no longer tell squares apart
    const bool known = grid.size >= 1 && std::isfinite(eye_height) && std::abs(eye_x) < kFarthestSquares &&
                       std::abs(eye_z) < kFarthestSquares;
    if (known) {
        FF_CHECK(std::has_single_bit(grid.size) && grid.size <= 4096, "height grid of {} squares", grid.size);
        HorizonTraceInput input;
        input.size_log2 = std::countr_zero(grid.size);
        std::size_t offset = 0;
        for (int level = 0; level <= input.size_log2; ++level) {
            input.level_heights[level] = grid.heights.data() + offset;
            offset += (std::size_t(grid.size) >> level) * (std::size_t(grid.size) >> level);
        }
        FF_CHECK(grid.heights.size() >= offset, "height grid has {} heights; its mips need {}", grid.heights.size(),
                 offset);
        input.finest_level = std::min(step / 2, input.size_log2);
        input.eye_x = int(std::floor(eye_x));
        input.eye_z = int(std::floor(eye_z));
        input.frac_x = float(eye_x - std::floor(eye_x));
        input.frac_z = float(eye_z - std::floor(eye_z));
        input.eye_height_m = std::nextafter(float(eye_height), -kInfinity);
        input.squares_per_m = float(1.0 / grid.square_m);
        input.roam = float(roam_m_ / grid.square_m * (1.0 + 1e-6));
        input.climb = float(climb_m_ / grid.square_m * (1.0 + 1e-6));
        // Around the eye the scene itself, beyond it the grid.
        const double near_m = double(settings_.near_distance_m), reach_m = settings_.fine_squares * grid.square_m;
        const bool fine = scene != nullptr && reach_m > near_m;
        input.wedges = wedges(float((fine ? reach_m : near_m) / grid.square_m * (1.0 - 1e-6)));
        if (input.roam > 0.0f)
            input.wedges.inverse_near = 1.0f / std::max(input.wedges.near_distance - input.roam, 0.0f);
        for (int c = input.wedges.columns; c < input.wedges.columns + kPadding; ++c)
            traced_[std::size_t(c)] = kInfinity;
        const HorizonNearInput around{scene,
                                      middle_,
                                      float(roam_m_ * (1.0 + 1e-6)),
                                      float(climb_m_ * (1.0 + 1e-6)),
                                      float(reach_m * (1.0 + 1e-5) + 1e-3),
                                      wedges(settings_.near_distance_m * (1.0f - 1e-6f)),
                                      border_x_.data(),
                                      border_z_.data()};
        raise_halves(
            [&](float* tangents, std::uint32_t* winner, HorizonCost& part) {
                if (fine) part.boxes += trace_horizon_near(around, tangents);
                part.squares += trace_horizon(input, tangents, winner);
            },
            cost);
    }

    for (int c = 0; c < all; ++c) {
        const bool inside = contains(valid_, c, all);
        float& tangent = tangents_[std::size_t(c)];
        if (!inside || !known) {
            tangent = kInfinity;
        } else if (!(keep && contains(before, c, all))) {
            tangent = traced_[std::size_t(c / step)];
            // The rounding of everything above, and of whoever compares against it.
            if (std::isfinite(tangent)) tangent += std::abs(tangent) * 4e-6f + 1e-6f;
        }
    }
    return cost;
}

ColumnRange columns_of_view(const PinholeView& view, int columns) {
    const float u0 = view.u_first, u1 = view.u_first + view.u_step * float(view.width);
    const float v0 = view.v_first, v1 = view.v_first + view.v_step * float(view.height);
    const Mat3& m = view.world_from_camera;
    // Where the vertical through the eye meets the image plane; inside the image every azimuth is seen.
    const Vec3 pole(m[0].y, m[1].y, m[2].y);
    const float margin_u = 4.0f * std::abs(view.u_step), margin_v = 4.0f * std::abs(view.v_step);
    if (std::abs(pole.z) > 1e-6f) {
        const float u = pole.x / -pole.z, v = pole.y / -pole.z;
        if (u >= std::min(u0, u1) - margin_u && u <= std::max(u0, u1) + margin_u && v >= std::min(v0, v1) - margin_v &&
            v <= std::max(v0, v1) + margin_v)
            return {0, columns};
    }
    // Else the image projects to a convex quadrilateral beside the eye, whose extremes are its corners.
    const float corner_u[4] = {u0, u1, u0, u1}, corner_v[4] = {v0, v0, v1, v1};
    float first_turn = 0.0f, low = 0.0f, high = 0.0f;
    for (int i = 0; i < 4; ++i) {
        const Vec3 direction = m * Vec3(corner_u[i], corner_v[i], -1.0f);
        const float turn = azimuth_turn(direction.x, direction.z);
        if (i == 0) first_turn = turn;
        float offset = turn - first_turn;
        offset -= std::round(offset);
        low = std::min(low, offset);
        high = std::max(high, offset);
    }
    const int first = int(std::floor((first_turn + low) * float(columns))) - 2;
    const int last = int(std::floor((first_turn + high) * float(columns))) + 2;
    const int count = std::min(columns, last - first + 1);
    return {modulo(first, columns), count};
}

}  // namespace ff::farfield
