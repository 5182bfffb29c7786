#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "engine/farfield/moving_shadow.cpp"
#include <hwy/foreach_target.h>  // must come before highway.h
#include <hwy/highway.h>

#include <bit>
#include <limits>

#include "engine/farfield/lane_bits-inl.h"
#include "engine/farfield/moving_shadow.h"

#ifndef FF_MOVING_SHADOW_SHARED_
#define FF_MOVING_SHADOW_SHARED_
namespace ff::farfield::moving {

constexpr int kPixels = kTileSize * kTileSize;
/// Stands for "no surface here": nothing is within so little of anything.
constexpr float kNothing = -1e30f;

/// What casts shadows, by MovingShadows::Column; padded to vectors of kTileSize.
struct Casters {
    const float* columns[MovingShadows::column_count];
    std::size_t count;
    float grow[3];  ///< what a metre more round a box takes up across the axis
};

/// A tile's pixels. A point at depth 1 lies at `first` + i * `column` + j * `row`: its cross product with the sun's
/// direction, and its way along that.
struct Points {
    const std::uint32_t* instances;
    const float* depths;
    std::ptrdiff_t stride;
    const std::uint16_t* rows;
    float first[4], column[4], row[4];
    float margin;  ///< metres round a point that count as it, at depth 1
};

/// What the rays of a tile look like along the sun: a wedge in the plane across it.
struct Wedge {
    float middle_s, middle_t;        ///< unit
    float sine, cosine;              ///< of half of its angle; cosine > 0
    float along_per_least_distance;  ///< of the rays: the least way along the sun for a metre across it, ...
    float along_per_most_distance;   ///< ... for shadows that are met as near, or as far away, as may be
};

}  // namespace ff::farfield::moving
#endif

HWY_BEFORE_NAMESPACE();
namespace ff::farfield::moving {
namespace HWY_NAMESPACE {
namespace {
namespace hn = hwy::HWY_NAMESPACE;

using F = hn::CappedTag<float, kTileSize>;
using U = hn::RebindToUnsigned<F>;
constexpr F f;
constexpr U ui;
using VF = hn::Vec<F>;

VF splat(float x) {
    return hn::Set(f, x);
}

/// A tile's points, and what they take up.
struct Seen {
    alignas(64) float place[4][kPixels];  ///< three across the sun's direction, one along it
    alignas(64) float margin[kPixels];    ///< kNothing where nobody asks, or no surface is
    float low[3], high[3];
    float least_along, most_margin;
};

/// @return whether there are any
bool gather(const Points& points, Seen& seen) {
    constexpr float kInfinity = std::numeric_limits<float>::infinity();
    const VF infinity = splat(kInfinity), minus_infinity = splat(-kInfinity);
    VF low[4] = {infinity, infinity, infinity, infinity};
    VF high[3] = {minus_infinity, minus_infinity, minus_infinity};
    VF most_margin = splat(kNothing);
    const int lanes = int(hn::Lanes(f));
    for (int j = 0; j < kTileSize; ++j) {
        if (points.rows[j] == 0) continue;
        const std::uint32_t* const instances = points.instances + j * points.stride;
        const float* const depths = points.depths + j * points.stride;
        for (int i = 0; i < kTileSize; i += lanes) {
            const std::uint8_t bits[8] = {std::uint8_t(points.rows[j] >> i), std::uint8_t(points.rows[j] >> i >> 8)};
            const auto is_surface =
                hn::And(hn::LoadMaskBits(f, bits),
                        hn::RebindMask(f, hn::Lt(hn::LoadU(ui, instances + i), hn::Set(ui, kUnresolved))));
            const VF depth = hn::LoadU(f, depths + i);
            const VF x = hn::ConvertTo(f, hn::Iota(hn::RebindToSigned<F>(), i));
            const int at = j * kTileSize + i;
            for (int k = 0; k < 4; ++k) {
                const VF at_one =
                    hn::MulAdd(x, splat(points.column[k]), splat(points.first[k] + float(j) * points.row[k]));
                const VF place = hn::Mul(at_one, depth);
                hn::Store(place, f, seen.place[k] + at);
                low[k] = hn::Min(low[k], hn::IfThenElse(is_surface, place, infinity));
                if (k < 3) high[k] = hn::Max(high[k], hn::IfThenElse(is_surface, place, minus_infinity));
            }
            const VF margin = hn::IfThenElse(is_surface, hn::Mul(splat(points.margin), depth), splat(kNothing));
            hn::Store(margin, f, seen.margin + at);
            most_margin = hn::Max(most_margin, margin);
        }
    }
    for (int k = 0; k < 3; ++k) {
        seen.low[k] = hn::GetLane(hn::MinOfLanes(f, low[k]));
        seen.high[k] = hn::GetLane(hn::MaxOfLanes(f, high[k]));
    }
    seen.least_along = hn::GetLane(hn::MinOfLanes(f, low[3]));
    seen.most_margin = hn::GetLane(hn::MaxOfLanes(f, most_margin));
    return seen.least_along < kInfinity;
}

/// Adds the asked pixels that a caster's shadow falls on.
void add_shadow(const Casters& casters, std::size_t caster, const Seen& seen, const std::uint16_t* asked,
                std::uint16_t* shaded) {
    const auto of = [&](int column) HWY_ATTR { return splat(casters.columns[column][caster]); };
    const VF radius = of(MovingShadows::radius);
    for (int p = 0; p < kPixels; p += int(hn::Lanes(f))) {
        const int row = p / kTileSize;
        if (asked[row] == 0) continue;
        const VF margin = hn::Load(f, seen.margin + p), reach = hn::Add(radius, margin);
        auto hit = hn::Ge(hn::Sub(of(MovingShadows::along), hn::Load(f, seen.place[3] + p)), hn::Neg(reach));
        VF square = hn::Zero(f);
        for (int k = 0; k < 3; ++k) {
            const VF beside = hn::Sub(of(MovingShadows::axis_x + k), hn::Load(f, seen.place[k] + p));
            const VF half = hn::MulAdd(splat(casters.grow[k]), margin, of(MovingShadows::half_x + k));
            hit = hn::And(hit, hn::Le(hn::Abs(beside), half));
            square = hn::MulAdd(beside, beside, square);
        }
        hit = hn::And(hit, hn::Le(square, hn::Mul(reach, reach)));
        shaded[row] = std::uint16_t(shaded[row] | farfield::HWY_NAMESPACE::lane_bits(f, hit) << p % kTileSize);
    }
}

}  // namespace

/// Whether one of the shadows passes through a wedge before the eye.
bool MeetsWedge(const Casters& casters, const Wedge& wedge) {
    const VF zero = hn::Zero(f);
    for (std::size_t c = 0; c < casters.count; c += hn::Lanes(f)) {
        const auto of = [&](int column) HWY_ATTR { return hn::LoadU(f, casters.columns[column] + c); };
        const VF beside = hn::MulAdd(of(MovingShadows::to_axis_s), splat(wedge.middle_s),
                                     hn::Mul(of(MovingShadows::to_axis_t), splat(wedge.middle_t)));
        const VF outermost = hn::NegMulAdd(of(MovingShadows::ball_sine), splat(wedge.sine),
                                           hn::Mul(of(MovingShadows::ball_cosine), splat(wedge.cosine)));
        const VF along =
            hn::Add(hn::Mul(hn::Max(of(MovingShadows::least_distance), zero), splat(wedge.along_per_least_distance)),
                    hn::Mul(of(MovingShadows::most_distance), splat(wedge.along_per_most_distance)));
        const auto hit =
            hn::And(hn::Ge(beside, hn::Sub(outermost, splat(1e-5f))), hn::Ge(of(MovingShadows::reach), along));
        if (!hn::AllFalse(f, hit)) return true;
    }
    return false;
}

/// Leaves in `rows`, which ask, the pixels that a shadow may fall on.
/// @return whether there are any
bool FindShaded(const Casters& casters, const Points& points, std::uint16_t* rows) {
    Seen seen;
    std::uint16_t shaded[kTileSize] = {};
    bool any = false;
    const VF margin = gather(points, seen) ? splat(seen.most_margin) : splat(kNothing);
    for (std::size_t c = 0; c < casters.count; c += hn::Lanes(f)) {
        const auto of = [&](int column) HWY_ATTR { return hn::LoadU(f, casters.columns[column] + c); };
        auto hit = hn::Ge(hn::Sub(of(MovingShadows::along), splat(seen.least_along)),
                          hn::Neg(hn::Add(of(MovingShadows::radius), margin)));
        for (int k = 0; k < 3; ++k) {
            const VF axis = of(MovingShadows::axis_x + k);
            const VF half = hn::MulAdd(splat(casters.grow[k]), margin, of(MovingShadows::half_x + k));
            hit = hn::And(hit, hn::And(hn::Ge(hn::Add(axis, half), splat(seen.low[k])),
                                       hn::Le(hn::Sub(axis, half), splat(seen.high[k]))));
        }
        for (std::uint32_t left = farfield::HWY_NAMESPACE::lane_bits(f, hit); left != 0; left &= left - 1)
            add_shadow(casters, c + std::size_t(std::countr_zero(left)), seen, rows, shaded);
    }
    for (int j = 0; j < kTileSize; ++j) {
        rows[j] = shaded[j];
        any |= shaded[j] != 0;
    }
    return any;
}

}  // namespace HWY_NAMESPACE
}  // namespace ff::farfield::moving
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

namespace ff::farfield {
namespace moving {
HWY_EXPORT(FindShaded);
HWY_EXPORT(MeetsWedge);
bool find_shaded(const Casters& casters, const Points& points, std::uint16_t* rows) {
    return HWY_DYNAMIC_DISPATCH(FindShaded)(casters, points, rows);
}
bool meets_wedge(const Casters& casters, const Wedge& wedge) {
    return HWY_DYNAMIC_DISPATCH(MeetsWedge)(casters, wedge);
}
}  // namespace moving

namespace {

/// Rounding of numbers that are made in float32 from metres round the eye, as a share of them.
constexpr double kRounding = 2.5e-7;
/// Neighbours' light is taken for a pixel's, so two pixels beside the shadow count as in it.
constexpr double kMarginPx = 2.5;

/// What a box takes up across an axis, as the cross product of both spans it.
DVec3 across(const DVec3& half, const DVec3& axis) {
    const DVec3 a = glm::abs(axis);
    return {half.y * a.z + half.z * a.y, half.z * a.x + half.x * a.z, half.x * a.y + half.y * a.x};
}

/// The casters' columns, as kernels want them.
moving::Casters casters_of(std::span<const std::vector<float>> columns) {
    moving::Casters casters{};
    for (std::size_t k = 0; k < columns.size(); ++k) casters.columns[k] = columns[k].data();
    casters.count = columns[0].size();
    return casters;
}

}  // namespace

void MovingShadows::begin(const PinholeView& view, std::span<const MovingSphere> moving, const Vec3& to_sun) {
    view_ = view;
    to_sun_ = to_sun;
    count_ = moving.size();
    const std::size_t padded = (count_ + kTileSize - 1) / kTileSize * kTileSize;
    // A radius of kNothing touches nothing.
    for (std::size_t k = 0; k < data_.size(); ++k)
        data_[k].assign(padded, k == radius || k == reach ? moving::kNothing : 0.0f);
    const DVec3 sun(to_sun);
    across_[0] = glm::normalize(glm::cross(std::abs(sun.y) < 0.9 ? DVec3(0, 1, 0) : DVec3(1, 0, 0), sun));
    across_[1] = glm::cross(sun, across_[0]);
    for (std::size_t i = 0; i < count_; ++i) {
        const MovingSphere& ball = moving[i];
        const DVec3 center = ball.center - view.position;
        const DVec3 in_box = ball.box.is_empty() ? center : ball.box.center() - view.position;
        // The box lies in the ball, so both may be asked round the ball's centre: the box is widened to reach it.
        const DVec3 half =
            ball.box.is_empty() ? DVec3(ball.radius) : ball.box.extent() * 0.5 + glm::abs(in_box - center);
        const double slack = kRounding * glm::length(center);
        const DVec3 axis = glm::cross(center, sun), taken = across(half, sun) + slack;
        for (int k = 0; k < 3; ++k) {
            data_[std::size_t(axis_x + k)][i] = float(axis[k]);
            data_[std::size_t(half_x + k)][i] = float(taken[k]);
        }
        data_[along][i] = float(glm::dot(center, sun));
        data_[radius][i] = float(ball.radius + slack);

        const double s = glm::dot(center, across_[0]), t = glm::dot(center, across_[1]);
        const double distance = std::sqrt(s * s + t * t), reached = ball.radius + slack;
        const bool is_within = distance <= reached;  // of its shadow the eye is: every wedge meets it
        data_[to_axis_s][i] = is_within ? 0.0f : float(s / distance);
        data_[to_axis_t][i] = is_within ? 0.0f : float(t / distance);
        data_[ball_sine][i] = is_within ? 0.0f : float(reached / distance);
        data_[ball_cosine][i] = is_within ? -1.0f : float(std::sqrt(1.0 - reached * reached / (distance * distance)));
        data_[least_distance][i] = float(distance - reached);
        data_[most_distance][i] = float(distance + reached);
        data_[reach][i] = float(glm::dot(center, sun) + reached + 4.0 * slack);  // compared with a product
    }
}

bool MovingShadows::may_fall_into(const TileRequest& tile) const {
    if (is_empty()) return false;
    // A little beyond the tile, as the pixels' points count for what is near them.
    constexpr double kLow = -0.5 - kMarginPx, kHigh = kTileSize - 0.5 + kMarginPx;
    const DMat3 to_world(view_.world_from_camera);
    double s[4], t[4], least = std::numeric_limits<double>::infinity(), most = 0.0, along_sun = least;
    double middle_s = 0.0, middle_t = 0.0;
    for (int k = 0; k < 4; ++k) {
        const DVec3 ray =
            to_world *
            DVec3((double(tile.x) + 0.5 + ((k & 1) != 0 ? kHigh : kLow)) * double(view_.u_step) + double(view_.u_first),
                  (double(tile.y) + 0.5 + ((k & 2) != 0 ? kHigh : kLow)) * double(view_.v_step) + double(view_.v_first),
                  -1.0);
        s[k] = glm::dot(ray, across_[0]);
        t[k] = glm::dot(ray, across_[1]);
        const double length = std::sqrt(s[k] * s[k] + t[k] * t[k]);
        if (!(length > 1e-6)) return true;
        least = std::min(least, length);
        most = std::max(most, length);
        along_sun = std::min(along_sun, glm::dot(ray, DVec3(to_sun_)));
        middle_s += s[k] / length;
        middle_t += t[k] / length;
    }
    // Towards the sun, or away from it, a tile looks every way across it.
    constexpr double kLeastCosine = 0.1;
    const double length = std::sqrt(middle_s * middle_s + middle_t * middle_t);
    if (!(length > kLeastCosine)) return true;
    middle_s /= length;
    middle_t /= length;
    double cosine = 1.0;
    for (int k = 0; k < 4; ++k)
        cosine = std::min(cosine, (s[k] * middle_s + t[k] * middle_t) / std::sqrt(s[k] * s[k] + t[k] * t[k]));
    if (cosine < kLeastCosine) return true;
    least *= cosine;  // of a chord between two of the corners
    const moving::Wedge wedge{.middle_s = float(middle_s),
                              .middle_t = float(middle_t),
                              .sine = float(std::sqrt(std::max(0.0, 1.0 - cosine * cosine))),
                              .cosine = float(cosine),
                              .along_per_least_distance = along_sun > 0.0 ? float(along_sun / most) : 0.0f,
                              .along_per_most_distance = along_sun > 0.0 ? 0.0f : float(along_sun / least)};
    return moving::meets_wedge(casters_of(data_), wedge);
}

bool MovingShadows::find(const VisibilityBuffer& visibility, TileRequest& tile) const {
    if (!may_fall_into(tile)) {
        std::fill(std::begin(tile.rows), std::end(tile.rows), std::uint16_t(0));
        return false;
    }
    const std::size_t at = visibility.index(tile.x, tile.y);
    const DVec3 sun(to_sun_), grow = across(DVec3(1.0), sun);
    const DMat3 to_world(view_.world_from_camera);
    const DVec3 first = to_world * DVec3((double(tile.x) + 0.5) * double(view_.u_step) + double(view_.u_first),
                                         (double(tile.y) + 0.5) * double(view_.v_step) + double(view_.v_first), -1.0);
    const DVec3 rays[3] = {first, to_world[0] * double(view_.u_step), to_world[1] * double(view_.v_step)};
    moving::Casters casters = casters_of(data_);
    moving::Points points{.instances = visibility.instance.data() + at,
                          .depths = visibility.depth.data() + at,
                          .stride = visibility.stride,
                          .rows = tile.rows,
                          .margin = float(kMarginPx) * view_.pixel_angle()};
    float* const places[3] = {points.first, points.column, points.row};
    for (int i = 0; i < 3; ++i) {
        const DVec3 axis = glm::cross(rays[i], sun);
        for (int k = 0; k < 3; ++k) places[i][k] = float(axis[k]);
        places[i][3] = float(glm::dot(rays[i], sun));
    }
    for (int k = 0; k < 3; ++k) casters.grow[k] = float(grow[k]);
    return moving::find_shaded(casters, points, tile.rows);
}

}  // namespace ff::farfield
#endif
