#include "tools/cook/city_cars.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace ff::cook::city {
namespace {

constexpr double kHalfWidth = 0.88;

struct Station {
    double x, y;  // along the car, above the road
};

/// An outline seen from the right, swept over the car's width: each part is a band across, with its ends as flanks.
class CarWriter {
  public:
    CarWriter(BlockWriter& writer, const DVec2& middle, const DVec2& ahead, double y)
        : mesh_(writer.mesh), middle_(middle), ahead_(ahead), left_(-ahead.y, ahead.x), y_(y) {}

    [[nodiscard]] DVec3 at(const Station& s, double side) const {
        return world_from_plan(middle_ + ahead_ * s.x + left_ * side, y_ + s.y);
    }
    /// From station a to b, b further back on the upper side: its normal points up or outwards.
    void across(const Station& a, const Station& b, double half_a, double half_b, std::uint32_t material,
                std::uint32_t color) {
        mesh_.flat_quad({at(a, half_a), at(b, half_b), at(b, -half_b), at(a, -half_a)}, {}, material, color);
    }
    /// Both flanks of the area between corners given counter-clockwise as seen from the right, ahead to the right.
    void flanks(const std::array<Station, 4>& c, const std::array<double, 4>& half, std::uint32_t material,
                std::uint32_t color) {
        mesh_.flat_quad({at(c[0], -half[0]), at(c[1], -half[1]), at(c[2], -half[2]), at(c[3], -half[3])}, {}, material,
                        color);
        mesh_.flat_quad({at(c[3], half[3]), at(c[2], half[2]), at(c[1], half[1]), at(c[0], half[0])}, {}, material,
                        color);
    }
    /// A wheel on each side. What the body hides is left out: the tread and the inner face above the axle.
    void wheels(double x, double radius, std::uint32_t material, std::uint32_t color) {
        constexpr int kSides = 8;
        constexpr double kWidth = 0.2, kOut = 0.01;
        const auto rim = [&](int i) {
            const double angle = 2 * M_PI * i / kSides;
            return Station{x + radius * std::cos(angle), radius + radius * std::sin(angle)};
        };
        for (const double side : {-1.0, 1.0}) {
            const double out = side * (kHalfWidth + kOut), in = out - side * kWidth;
            const double left = std::max(out, in), right = std::min(out, in);
            // Counter-clockwise seen from the right.
            const auto face = [&](double at_side, int a, int b, int c, bool from_right) {
                const DVec3 p = at(rim(a), at_side), q = at(rim(b), at_side), r = at(rim(c), at_side);
                mesh_.flat_triangle({p, from_right ? q : r, from_right ? r : q}, {}, material, color);
            };
            for (int i = 1; i + 1 < kSides; ++i) face(out, 0, i, i + 1, side < 0);
            for (int i = kSides / 2; i < kSides; ++i) {
                if (i + 1 < kSides) face(in, kSides, i, i + 1, side > 0);
                mesh_.flat_quad({at(rim(i), left), at(rim(i + 1), left), at(rim(i + 1), right), at(rim(i), right)}, {},
                                material, color);
            }
        }
    }

  private:
    MeshBuilder& mesh_;
    DVec2 middle_, ahead_, left_;
    double y_;
};

std::uint32_t body_color(std::uint64_t seed) {
    static constexpr std::array<std::array<float, 3>, 9> kColors{{{0.75f, 0.75f, 0.74f},
                                                                  {0.42f, 0.43f, 0.45f},
                                                                  {0.05f, 0.05f, 0.06f},
                                                                  {0.16f, 0.17f, 0.19f},
                                                                  {0.36f, 0.03f, 0.03f},
                                                                  {0.04f, 0.08f, 0.24f},
                                                                  {0.08f, 0.16f, 0.12f},
                                                                  {0.5f, 0.42f, 0.3f},
                                                                  {0.62f, 0.64f, 0.66f}}};
    const auto& c = kColors[hash_mix(seed, 5) % kColors.size()];
    return pack_color({c[0], c[1], c[2]});
}

}  // namespace

void add_car(BlockWriter& writer, const DVec2& middle, const DVec2& ahead, double y, std::uint64_t seed) {
    const std::uint32_t paint = writer.materials.metal, glass = writer.materials.glass;
    const std::uint32_t color = body_color(seed);
    CarWriter car(writer, middle, ahead, y);
    const bool van = hash_unit(seed, 6) < 0.2;
    const double h = kHalfWidth, top = van ? 1.85 : 1.42, g = 0.62;
    const double back = van ? -2.25 : -1.95 + 0.5 * hash_unit(seed, 7);
    const Station front_low{2.15, 0.25}, front{2.2, 0.62}, hood{1.95, 0.8}, screen{0.95, 0.92};
    const Station roof_front{0.25, top}, roof_back{back + 0.55, top}, rear{back - 0.2, 0.95}, boot{-2.2, 0.88};
    const Station rear_low{-2.2, 0.25};
    const Station tail = van ? Station{-2.25, 0.95} : rear;
    // Over the top from front to rear.
    car.across(front_low, front, h, h, paint, color);
    car.across(front, hood, h, h, paint, color);
    car.across(hood, screen, h, h, paint, color);
    car.across(screen, roof_front, h, g, glass, kWhite);
    car.across(roof_front, roof_back, g, g, paint, color);
    car.across(roof_back, tail, g, h, glass, kWhite);
    if (tail.x > boot.x + 0.05) car.across(tail, boot, h, h, paint, color);
    car.across(tail.x > boot.x + 0.05 ? boot : tail, rear_low, h, h, paint, color);
    // Flanks below the waist, then the windows, which lean inwards.
    const double waist = 0.92;
    car.flanks({Station{-2.2, 0.25}, Station{2.15, 0.25}, front, Station{-2.2, 0.62}}, {h, h, h, h}, paint, color);
    car.flanks({Station{-2.2, 0.62}, front, hood, boot}, {h, h, h, h}, paint, color);
    car.flanks({boot, hood, Station{screen.x, waist}, tail}, {h, h, h, h}, paint, color);
    car.flanks({tail, screen, roof_front, roof_back}, {h, h, g, g}, glass, kWhite);
    // The floor, seen in no view but closing the body.
    car.across(rear_low, front_low, h, h, writer.materials.plain, pack_color(Vec3(0.02f)));
    for (const double x : {-1.35, 1.4}) car.wheels(x, 0.32, writer.materials.plain, pack_color(Vec3(0.025f)));
}

}  // namespace ff::cook::city
