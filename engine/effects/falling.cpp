#include "engine/effects/falling.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "engine/shading/shading_model.h"

namespace ff::effects {
namespace {

/// Bits that look random. Based on: Steele, Lea, Flood, "Fast Splittable Pseudorandom Number Generators", OOPSLA 2014.
std::uint64_t mixed_bits(std::uint64_t n) {
    n += 0x9E3779B97F4A7C15u;
    n = (n ^ n >> 30) * 0xBF58476D1CE4E5B9u;
    n = (n ^ n >> 27) * 0x94D049BB133111EBu;
    return n ^ n >> 31;
}

/// How one kind falls.
struct Kind {
    double speed_m_s;    ///< downwards
    double sway_m;       ///< to the sides, while it falls
    double shutter_s;    ///< it shows along the way of so long
    double size_m;       ///< across
    double most_per_m3;  ///< at strength 1
    float opacity;       ///< of one that covers a pixel
    std::uint64_t seed;
};
constexpr Kind kRain{9.0, 0.0, 1.0 / 50.0, 0.004, 2.0, 0.45f, 1};
constexpr Kind kSnow{1.1, 0.25, 0.0, 0.018, 3.0, 0.9f, 2};

std::uint32_t encoded(const Vec3& linear, bool by_film) {
    const DVec3 color = shading::encode_color(DVec3(linear), by_film);
    std::uint32_t out = 0;
    for (int k = 0; k < 3; ++k) out |= std::uint32_t(255.0 * color[k] + 0.5) << 8 * k;
    return out;
}

void blend(std::uint32_t color, float alpha, std::uint32_t& pixel) {
    const auto weight = std::uint32_t(alpha * 256.0f + 0.5f);
    std::uint32_t out = 0xFF000000u;
    for (int shift = 0; shift < 24; shift += 8) {
        const std::uint32_t a = color >> shift & 255u, b = pixel >> shift & 255u;
        out |= (a * weight + b * (256u - weight) + 128u) >> 8 << shift;
    }
    pixel = out;
}

/// Draws a frame's drops, one after the other: later ones over earlier ones.
class Painter {
  public:
    Painter(const PinholeView& view, const farfield::VisibilityBuffer& visible, const Shelter& shelter,
            const Fall& fall, shading::Image& out)
        : view_(view), visible_(visible), shelter_(shelter), color_(encoded(fall.light, fall.by_film)), out_(out) {}

    std::uint64_t draw(const Kind& kind, float strength, const Fall& fall) {
        const double side = kFallSideM;
        const auto count = std::uint64_t(double(strength * fall.density) * kind.most_per_m3 * side * side * side);
        const DVec3 velocity(fall.weather.wind_m_s.x, -kind.speed_m_s, fall.weather.wind_m_s.y);
        const DVec3 drift = velocity * fall.time_s;
        std::uint64_t shown = 0;
        for (std::uint64_t i = 0; i < count; ++i) {
            const std::uint64_t bits = mixed_bits(kind.seed << 40 | i);
            constexpr double kUnit = 1.0 / double(1 << 21);
            const DVec3 start(double(bits & 0x1FFFFF) * kUnit, double(bits >> 21 & 0x1FFFFF) * kUnit,
                              double(bits >> 42 & 0x1FFFFF) * kUnit);
            // The cube goes with the eye, what falls does not: it comes in again where it left.
            DVec3 at = start * side + drift - view_.position;
            at -= glm::floor(at / side + 0.5) * side;
            if (kind.sway_m > 0.0) {
                const double phase = 2.0 * kPi * start.x + fall.time_s * (0.7 + start.z);
                at += kind.sway_m * DVec3(std::sin(phase), 0.0, std::cos(1.3 * phase));
            }
            shown += drop(kind, Vec3(at), Vec3(velocity * kind.shutter_s));
        }
        return shown;
    }

  private:
    /// @param at  relative to the eye, world axes. @return whether it shows
    bool drop(const Kind& kind, const Vec3& at, const Vec3& way) {
        constexpr float kNearestM = 0.4f;
        const Vec3 right = view_.world_from_camera[0], up = view_.world_from_camera[1];
        const Vec3 back = view_.world_from_camera[2];
        const float depth = -glm::dot(at, back);
        if (depth < kNearestM) return false;
        const Vec3 end = at - way;
        const float end_depth = std::max(-glm::dot(end, back), kNearestM);
        const auto column = [&](const Vec3& p, float d) {
            return (glm::dot(p, right) / d - view_.u_first) / view_.u_step;
        };
        const auto row = [&](const Vec3& p, float d) { return (glm::dot(p, up) / d - view_.v_first) / view_.v_step; };
        const float x0 = column(at, depth), y0 = row(at, depth);
        const float x1 = column(end, end_depth), y1 = row(end, end_depth);
        const float width = float(out_.width), height = float(out_.height);
        if (std::max(x0, x1) < 0 || std::min(x0, x1) >= width || std::max(y0, y1) < 0 || std::min(y0, y1) >= height)
            return false;
        const WorldPos place = view_.position + DVec3(at);
        if (!(place.y > double(shelter_.top_at(place.x, place.z)))) return false;

        // Thinner than a pixel it covers part of one; and it fades where its cube ends.
        const float size = float(kind.size_m) / (depth * view_.pixel_angle());
        const float border = glm::length(at) / (0.5f * float(kFallSideM));
        const float alpha = kind.opacity * std::min(1.0f, size) * std::clamp(2.0f - 2.0f * border, 0.0f, 1.0f);
        if (alpha < 1.0f / 256.0f) return false;
        const int thick = std::clamp(int(size + 0.5f), 1, 5);
        const float steps = std::max(1.0f, std::ceil(std::max(std::abs(x1 - x0), std::abs(y1 - y0)) / float(thick)));
        bool shows = false;
        for (float s = 0.0f; s < std::min(steps, 4096.0f); ++s) {
            const float t = s / steps;
            shows |= dot(int(std::floor(x0 + t * (x1 - x0))), int(std::floor(y0 + t * (y1 - y0))), thick, depth, alpha);
        }
        return shows;
    }

    bool dot(int x, int y, int thick, float depth, float alpha) {
        bool shows = false;
        const int x0 = x - thick / 2, y0 = y - thick / 2;
        for (int j = std::max(0, y0); j < std::min(out_.height, y0 + thick); ++j)
            for (int i = std::max(0, x0); i < std::min(out_.width, x0 + thick); ++i) {
                // Round, from three pixels on.
                const bool corner = thick > 2 && (i == x0 || i == x0 + thick - 1) && (j == y0 || j == y0 + thick - 1);
                if (corner || !(depth < visible_.depth[visible_.index(i, j)])) continue;
                blend(color_, alpha, out_.pixels[std::size_t(j) * std::size_t(out_.stride) + std::size_t(i)]);
                shows = true;
            }
        return shows;
    }

    const PinholeView& view_;
    const farfield::VisibilityBuffer& visible_;
    const Shelter& shelter_;
    std::uint32_t color_;
    shading::Image& out_;
};

}  // namespace

Shelter::Shelter() {
    rays_.reserve(kRaysAFrame);
    hits_.resize(kRaysAFrame);
}

std::size_t Shelter::index_of(std::int64_t x, std::int64_t z) {
    const auto place = [](std::int64_t i) { return std::size_t((i % kSide + kSide) % kSide); };
    return place(z) * kSide + place(x);
}

float Shelter::top_at(double x, double z) const {
    const auto i = std::int64_t(std::floor(x)), j = std::int64_t(std::floor(z));
    const Square& known = squares_[index_of(i, j)];
    return known.x == i && known.z == j ? known.top : std::numeric_limits<float>::infinity();
}

void Shelter::clear() {
    squares_.fill({});
}

std::uint64_t Shelter::update(const WorldPos& eye, farfield::RayCaster& caster) {
    constexpr double kSkyM = 400.0;  // above the eye: nothing that shelters starts higher
    const auto i0 = std::int64_t(std::floor(eye.x)), j0 = std::int64_t(std::floor(eye.z));
    rays_.clear();
    std::array<Square*, kRaysAFrame> asked;
    // Rings round the viewer's square, so that the nearest are known first.
    for (int ring = 0; ring < kSide / 2; ++ring)
        for (int dz = -ring; dz <= ring; ++dz)
            for (int dx = -ring; dx <= ring; dx += (dz == -ring || dz == ring) ? 1 : std::max(1, 2 * ring)) {
                Square& known = squares_[index_of(i0 + dx, j0 + dz)];
                if (known.x == i0 + dx && known.z == j0 + dz) continue;
                if (rays_.size() == kRaysAFrame) break;
                known = {i0 + dx, j0 + dz, 0.0f};
                asked[rays_.size()] = &known;
                rays_.push_back({.origin = {double(i0 + dx) + 0.5, eye.y + kSkyM, double(j0 + dz) + 0.5},
                                 .direction = {0.0f, -1.0f, 0.0f}});
            }
    if (rays_.empty()) return 0;
    caster.cast_rays(rays_, std::span(hits_).first(rays_.size()));
    for (std::size_t i = 0; i < rays_.size(); ++i) asked[i]->top = float(eye.y + kSkyM - double(hits_[i].t));
    return rays_.size();
}

std::uint64_t draw_fall(const Fall& fall, const PinholeView& view, const farfield::VisibilityBuffer& visible,
                        const Shelter& shelter, shading::Image& out) {
    Painter painter(view, visible, shelter, fall, out);
    std::uint64_t shown = 0;
    if (fall.weather.rain > 0.0f) shown += painter.draw(kRain, fall.weather.rain, fall);
    if (fall.weather.snow > 0.0f) shown += painter.draw(kSnow, fall.weather.snow, fall);
    return shown;
}

}  // namespace ff::effects
