// Roadways, markings, kerbs, pavements, and what stands along them.

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "tools/cook/city_block.h"
#include "tools/cook/city_cars.h"

namespace ff::cook::city {
namespace {

constexpr double kKerbstone = 0.2;  // width, m

std::uint32_t paint_color() {
    return pack_color(Vec3(0.78f));
}

/// A straight street between two crossings.
struct Street {
    DVec2 left[2], right[2];  ///< kerbs, seen along the street, from start to end
    bool avenue = false;
    bool houses = false;  ///< a quiet one

    [[nodiscard]] DVec2 at(double along, double across) const {
        return glm::mix(glm::mix(left[0], left[1], along), glm::mix(right[0], right[1], along), across);
    }
    [[nodiscard]] double length() const { return glm::length(at(1, 0.5) - at(0, 0.5)); }
    [[nodiscard]] double width() const { return glm::length(right[0] - left[0]); }
    [[nodiscard]] int pieces() const { return std::max(1, int(std::ceil(length() / 10.0))); }
};

/// The roadway's height is that of its pieces, whose corners lie on the ground.
double road_height(const BlockWriter& writer, const Street& street, double along, double across) {
    const int pieces = street.pieces();
    const int piece = std::clamp(int(along * pieces), 0, pieces - 1);
    const double t0 = double(piece) / pieces, t1 = double(piece + 1) / pieces, f = (along - t0) / (t1 - t0);
    const auto edge = [&](double w) {
        return std::lerp(writer.ground_at(street.at(t0, w)), writer.ground_at(street.at(t1, w)), f);
    };
    return std::lerp(edge(0), edge(1), across) + kRoadLift;
}

void add_paint(BlockWriter& writer, const Street& street, double t0, double t1, double w0, double w1) {
    const auto corner = [&](double t, double w) {
        return world_from_plan(street.at(t, w), road_height(writer, street, t, w) + kPaintLift);
    };
    writer.mesh.flat_quad({corner(t0, w0), corner(t0, w1), corner(t1, w1), corner(t1, w0)}, {}, writer.materials.plain,
                          paint_color());
}

/// A line along the street from one metre to another, dashed where `gap_m` is more than 0.
void add_line(BlockWriter& writer, const Street& street, double from_m, double to_m, double across, double dash_m,
              double gap_m) {
    const double length = street.length(), half = 0.075 / street.width();
    for (double s = from_m; s < to_m - 0.5; s += dash_m + gap_m)
        add_paint(writer, street, s / length, std::min(s + dash_m, to_m) / length, across - half, across + half);
}

void add_markings(BlockWriter& writer, const Street& street) {
    const double length = street.length(), width = street.width();
    if (length < 30) return;
    const double clear = 7.0;
    if (street.avenue) {
        for (const double across : {0.5 - 0.2 / width, 0.5 + 0.2 / width})
            add_line(writer, street, clear, length - clear, across, 9.0, 0.0);
        for (const double across : {0.27, 0.73}) add_line(writer, street, clear, length - clear, across, 3.0, 4.5);
    } else {
        add_line(writer, street, clear, length - clear, 0.5, 3.0, street.houses ? 6.0 : 3.0);
    }
    if (street.houses) return;
    // Zebra crossings and stop lines at both ends; traffic keeps right.
    const int stripes = int(width / 1.0);
    for (const bool end : {false, true}) {
        const auto t = [&](double m) { return (end ? length - m : m) / length; };
        for (int i = 0; i < stripes; ++i) {
            const double w0 = (i + 0.25) / stripes, w1 = (i + 0.75) / stripes;
            add_paint(writer, street, std::min(t(1.2), t(4.2)), std::max(t(1.2), t(4.2)), w0, w1);
        }
        const double lane0 = end ? 0.51 : 0.02, lane1 = end ? 0.98 : 0.49;
        add_paint(writer, street, std::min(t(5.4), t(5.8)), std::max(t(5.4), t(5.8)), lane0, lane1);
    }
}

void add_parked_cars(BlockWriter& writer, const Street& street, std::uint64_t seed) {
    const double length = street.length(), width = street.width();
    const double share = street.houses ? 0.25 : 0.55;
    const DVec2 ahead = glm::normalize(street.at(1, 0.5) - street.at(0, 0.5));
    for (const bool right : {false, true}) {
        const double across = right ? 1.0 - 1.25 / width : 1.25 / width;
        int place = 0;
        for (double s = 12.0; s < length - 12.0; s += 6.4, ++place) {
            const std::uint64_t car = hash_mix(seed, right, std::uint64_t(place));
            if (hash_unit(car, 1) > share) continue;
            const double along = (s + 0.8 * hash_unit(car, 2)) / length;
            add_car(writer, street.at(along, across), right ? ahead : -ahead,
                    road_height(writer, street, along, across), car);
        }
    }
}

void add_street(BlockWriter& writer, const Street& street, std::uint64_t seed) {
    const int pieces = street.pieces();
    writer.ground_quad({street.right[0], street.right[1], street.left[1], street.left[0]}, pieces, 1, kRoadLift,
                       writer.materials.asphalt);
    // Skirts, for streets at the city's edge that no kerb bounds.
    for (int i = 0; i < pieces; ++i) {
        const double t0 = double(i) / pieces, t1 = double(i + 1) / pieces;
        const auto skirt = [&](const DVec2& p, const DVec2& q) {
            writer.mesh.flat_quad({writer.on_ground(p, -0.5), writer.on_ground(q, -0.5), writer.on_ground(q, kRoadLift),
                                   writer.on_ground(p, kRoadLift)},
                                  {}, writer.materials.concrete, pack_color(Vec3(0.3f)));
        };
        skirt(street.at(t1, 0), street.at(t0, 0));
        skirt(street.at(t0, 1), street.at(t1, 1));
    }
    add_markings(writer, street);
    add_parked_cars(writer, street, seed);
}

/// The streets around the block that no earlier block has.
void add_own_streets(BlockWriter& writer) {
    const CityPlan& plan = writer.plan;
    const BlockIndex here = writer.block.index;
    const bool houses = writer.block.kind == BlockKind::houses;
    const auto own = [&](int dc, int dr) { return plan.is_before(here, {here.column + dc, here.row + dr}); };
    const Quad& mine = writer.block.kerb;
    const auto kerb = [&](int dc, int dr) { return plan.kerb({here.column + dc, here.row + dr}); };
    const auto avenue = [&](int line, bool west) { return plan.street_width(line, west) > 22.0; };
    const auto seed = [&](std::uint64_t side) { return hash_mix(writer.block.seed, 301, side); };
    if (own(-1, 0)) {
        const Quad west = kerb(-1, 0);
        add_street(writer, {{west[1], west[2]}, {mine[0], mine[3]}, avenue(here.column, true), houses}, seed(0));
    }
    if (own(1, 0)) {
        const Quad east = kerb(1, 0);
        add_street(writer, {{mine[1], mine[2]}, {east[0], east[3]}, avenue(here.column + 1, true), houses}, seed(1));
    }
    if (own(0, -1)) {
        const Quad south = kerb(0, -1);
        add_street(writer, {{mine[0], mine[1]}, {south[3], south[2]}, avenue(here.row, false), houses}, seed(2));
    }
    if (own(0, 1)) {
        const Quad north = kerb(0, 1);
        add_street(writer, {{north[0], north[1]}, {mine[3], mine[2]}, avenue(here.row + 1, false), houses}, seed(3));
    }
    for (const int dc : {-1, 1})
        for (const int dr : {-1, 1}) {
            if (!own(dc, 0) || !own(0, dr) || !own(dc, dr)) continue;
            // The four blocks around this corner, each giving the corner that it has there.
            const int west = dc < 0 ? -1 : 0, south = dr < 0 ? -1 : 0;
            const auto corner = [&](int c, int r, int which) {
                return c == 0 && r == 0 ? mine[which] : kerb(c, r)[which];
            };
            writer.ground_quad({corner(west, south, 2), corner(west + 1, south, 3), corner(west + 1, south + 1, 0),
                                corner(west, south + 1, 1)},
                               2, 2, kRoadLift, writer.materials.asphalt);
        }
}

void add_street_furniture(BlockWriter& writer, const Quad& quad) {
    const BlockKind kind = writer.block.kind;
    const bool quiet = kind == BlockKind::houses;
    for (int side = 0; side < 4; ++side) {
        const DVec2 p = quad[side], q = quad[(side + 1) % 4];
        const double length = glm::length(q - p);
        const DVec2 along = (q - p) / length, out{along.y, -along.x};
        const double spacing = quiet ? 34.0 : 24.0;
        const int lamps = std::max(1, int(length / spacing));
        for (int i = 0; i < lamps; ++i)
            writer.prop(CityProp::Kind::street_lamp, p + along * ((i + 0.5) * length / lamps) - out * 0.6, out);
        if (quiet) continue;
        const int trees = std::max(1, int(length / 12.0));
        const bool planted = hash_unit(writer.block.seed, 310, std::uint64_t(side)) < 0.7;
        for (int i = 0; i < trees && planted; ++i) {
            const double s = (i + 0.5) * length / trees;
            const double from_lamp = std::abs(std::remainder(s - 0.5 * length / lamps, length / lamps));
            if (from_lamp < 2.5) continue;
            writer.prop(CityProp::Kind::street_tree, p + along * s - out * 1.1, out);
        }
        for (int i = 0; i < 2; ++i)
            if (hash_unit(writer.block.seed, 311, std::uint64_t(side), std::uint64_t(i)) < 0.6)
                writer.prop(CityProp::Kind::bench, p + along * ((0.3 + 0.4 * i) * length + 3.0) - out * 1.2, out);
    }
}

}  // namespace

Quad add_streets(BlockWriter& writer) {
    add_own_streets(writer);
    const Quad& kerb = writer.block.kerb;
    const std::array<int, 2> pieces = pieces_of(kerb);
    for (int side = 0; side < 4; ++side)
        for (int i = 0, n = pieces[side % 2]; i < n; ++i) {
            const DVec2 p = glm::mix(kerb[side], kerb[(side + 1) % 4], double(i) / n);
            const DVec2 q = glm::mix(kerb[side], kerb[(side + 1) % 4], double(i + 1) / n);
            writer.mesh.flat_quad({writer.on_ground(p, -0.3), writer.on_ground(q, -0.3),
                                   writer.on_ground(q, kPavementLift), writer.on_ground(p, kPavementLift)},
                                  {}, writer.materials.stone, pack_color(Vec3(0.62f)));
        }
    const Quad stones = inset_quad(kerb, kKerbstone);
    writer.ground_ring(kerb, stones, pieces, kPavementLift, writer.materials.stone, pack_color(Vec3(0.66f)));
    const bool quiet = writer.block.kind == BlockKind::houses;
    const Quad inside = inset_quad(kerb, writer.block.kind == BlockKind::downtown ? 5.0 : quiet ? 2.6 : 4.2);
    writer.ground_ring(stones, inside, pieces, kPavementLift, writer.materials.pavement);
    add_street_furniture(writer, kerb);
    return inside;
}

}  // namespace ff::cook::city
