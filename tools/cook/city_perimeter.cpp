// Blocks whose houses stand wall to wall along the streets around a courtyard.

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "tools/cook/city_buildings.h"

namespace ff::cook::city {
namespace {

constexpr double kFloorBelowParapet = 0.8, kWallBelowRoof = 1.6;  // m

enum class Top : std::uint8_t { flat, gabled };

struct Lot {
    Quad corners{};  ///< side 0 along the street, 2 along the court
    std::uint64_t seed = 0;
    FacadeStyle style;
    Top top = Top::flat;
    double floor_y = 0, foot_y = 0, top_y = 0;
};

Lot plan_lot(const BlockWriter& writer, const Quad& corners, std::uint64_t seed) {
    Lot lot;
    lot.corners = corners;
    lot.seed = seed;
    const double dice = hash_unit(seed, 100);
    lot.style = city_facade(writer,
                            dice < 0.45  ? WallKind::plaster
                            : dice < 0.8 ? WallKind::brick
                                         : WallKind::stone,
                            seed);
    lot.style.bay_m *= 1.25;
    lot.style.shops = hash_unit(seed, 101) < 0.55;
    lot.style.balcony_share = hash_unit(seed, 102) < 0.3 ? 0.22 : 0.0;
    const int storeys = 4 + int(hash_mix(seed, 104) % 3);
    const auto [low, high] = ground_range(writer, corners);
    lot.floor_y = high + kPavementLift, lot.foot_y = low - 0.5;
    lot.top = hash_unit(seed, 105) < 0.55 ? Top::gabled : Top::flat;
    lot.top_y = lot.floor_y + lot.style.ground_storey_m + (storeys - 1) * lot.style.storey_m +
                (lot.top == Top::flat ? kFloorBelowParapet : 0.5);
    return lot;
}

void build_lot(BlockWriter& writer, const Lot& lot, const Lot& before, const Lot& after) {
    Body body;
    body.corners = lot.corners;
    body.foot_y = lot.foot_y, body.floor_y = lot.floor_y, body.top_y = lot.top_y;
    body.sides[0] = {SideKind::front, 0, true};
    // Party walls show where the neighbour is lower.
    const auto party = [&](const Lot& neighbour) {
        return BodySide{SideKind::party, lot.top_y > neighbour.top_y ? neighbour.top_y - kWallBelowRoof : lot.top_y};
    };
    body.sides[1] = party(after);
    body.sides[2] = {SideKind::back, 0, true};
    body.sides[3] = party(before);
    add_body_walls(writer, body, lot.style, lot.seed);
    writer.buildings.push_back(lot.corners);

    const DVec2 axis = glm::normalize(lot.corners[1] - lot.corners[0]);
    if (lot.top == Top::flat) {
        add_parapet_roof(writer.mesh, lot.corners, lot.top_y, kFloorBelowParapet,
                         city_roof(writer, lot.style, lot.seed, false));
        add_roof_plant(writer, inset_quad(lot.corners, 0.8), lot.top_y - kFloorBelowParapet, lot.seed, false);
        return;
    }
    RoofLook roof = city_roof(writer, lot.style, lot.seed, true);
    roof.rise = 0.6 + 0.25 * hash_unit(lot.seed, 106);
    // The ridge has to run along the street, also over narrow houses: a gable towards the street would do as well,
    // but not with dormers.
    const Quad sorted = long_side_first(lot.corners);
    add_gabled_roof(writer.mesh, lot.corners, lot.top_y, roof);
    const double ridge_y = lot.top_y + ridge_rise(lot.corners, roof);
    const DVec2 ridge0 = 0.5 * (sorted[0] + sorted[3]), ridge1 = 0.5 * (sorted[1] + sorted[2]);
    add_chimney(writer, glm::mix(ridge0, ridge1, 0.15 + 0.15 * hash_unit(lot.seed, 107)), axis, lot.top_y + 0.5,
                ridge_y, lot.style.wall_color);
    if (sorted[0] == lot.corners[0]) add_dormers(writer, lot.corners, lot.top_y, roof, lot.style, 3.6, 4.5);
}

void furnish_court(BlockWriter& writer, const Quad& court) {
    const CityMaterials& m = writer.materials;
    const std::uint64_t seed = writer.block.seed;
    const Quad lawn = inset_quad(court, 4.0);
    const double wide = std::min(glm::length(lawn[1] - lawn[0]), glm::length(lawn[2] - lawn[1]));
    if (wide < 10) return;
    const std::array<int, 2> n = pieces_of(lawn);
    writer.ground_quad(lawn, n[0], n[1], kPavementLift + 0.05, m.grass);
    for (int i = 0; i < 10; ++i) {
        const double u = 0.1 + 0.8 * hash_unit(seed, 110, std::uint64_t(i), 1),
                     v = 0.1 + 0.8 * hash_unit(seed, 110, std::uint64_t(i), 2);
        writer.prop(i % 3 == 0 ? CityProp::Kind::bush : CityProp::Kind::garden_tree, point_in(lawn, u, v),
                    {u - 0.5, v - 0.4}, kPavementLift + 0.05);
    }
    // Sheds for bicycles and bins against the lawn's edge.
    const DVec2 axis = glm::normalize(court[1] - court[0]);
    for (int i = 0; i < 3; ++i) {
        const DVec2 p = point_in(court, 0.3 + 0.2 * i, 0.0) + DVec2(-axis.y, axis.x) * 2.2;
        const double y = writer.ground_at(p) + kPavementLift;
        add_box(writer.mesh, p, axis, {2.2, 0.9}, y - 0.1, y + 2.1, m.plain, pack_color({0.22f, 0.17f, 0.12f}));
        add_box(writer.mesh, p, axis, {2.4, 1.1}, y + 2.08, y + 2.2, m.plain, pack_color(Vec3(0.12f)));
    }
}

}  // namespace

void add_perimeter(BlockWriter& writer, const Quad& inside) {
    const Quad outer = inset_quad(inside, 0.3);
    const double shortest = std::min({glm::length(outer[1] - outer[0]), glm::length(outer[2] - outer[1]),
                                      glm::length(outer[3] - outer[2]), glm::length(outer[0] - outer[3])});
    const double depth = std::min(12.5, 0.24 * shortest);
    const Quad court = inset_quad(outer, depth);
    const std::array<int, 2> pieces = pieces_of(inside);
    writer.ground_quad(inside, pieces[0], pieces[1], kPavementLift, writer.materials.pavement,
                       pack_color({0.8f, 0.78f, 0.74f}));
    furnish_court(writer, court);

    std::vector<Lot> lots;
    for (int side = 0; side < 4; ++side) {
        const int next = (side + 1) % 4;
        const double length = glm::length(outer[next] - outer[side]);
        const int count = std::max(2, int(std::round(length / 19.0)));
        // Corner lots lose a triangle to the mitre, so they are longer.
        const double extra = 0.5 * depth / length;
        const auto cut = [&](int i) {
            if (i <= 0 || i >= count) return i <= 0 ? 0.0 : 1.0;
            const double even = extra + (1 - 2 * extra) * i / count;
            return even +
                   0.1 / count * (hash_unit(writer.block.seed, 111, std::uint64_t(side), std::uint64_t(i)) - 0.5);
        };
        for (int i = 0; i < count; ++i) {
            const auto foot = [&](double t) { return glm::mix(outer[side], outer[next], t); };
            // Cuts are square to the street: as far along the court's side as along the street's.
            const auto back = [&](double t) {
                if (t <= 0) return court[side];
                if (t >= 1) return court[next];
                const DVec2 along = glm::normalize(court[next] - court[side]);
                return court[side] + along * glm::dot(foot(t) - court[side], along);
            };
            const double t0 = cut(i), t1 = cut(i + 1);
            lots.push_back(plan_lot(writer, {foot(t0), foot(t1), back(t1), back(t0)},
                                    hash_mix(writer.block.seed, 112, std::uint64_t(side), std::uint64_t(i))));
        }
    }
    for (std::size_t i = 0; i < lots.size(); ++i)
        build_lot(writer, lots[i], lots[(i + lots.size() - 1) % lots.size()], lots[(i + 1) % lots.size()]);
}

}  // namespace ff::cook::city
