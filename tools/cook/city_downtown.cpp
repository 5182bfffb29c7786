// High-rises that step back as they rise, on podiums or on their own, and the square among them.

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "tools/cook/city_buildings.h"

namespace ff::cook::city {
namespace {

WallKind downtown_wall(std::uint64_t seed) {
    const double dice = hash_unit(seed, 80);
    return dice < 0.42   ? WallKind::curtain
           : dice < 0.66 ? WallKind::concrete
           : dice < 0.86 ? WallKind::stone
                         : WallKind::brick;
}

double whole_storeys(double height, const FacadeStyle& style) {
    const double above = std::max(0.0, std::round((height - style.ground_storey_m) / style.storey_m));
    return style.ground_storey_m + above * style.storey_m;
}

/// A tower in up to three tiers over a lot. @param floor_y  its first floor @param foot_y  where its walls begin
void add_tower(BlockWriter& writer, const Quad& lot, double foot_y, double floor_y, double height, WallKind kind,
               std::uint64_t seed, bool doors) {
    FacadeStyle style = city_facade(writer, kind, seed);
    const RoofLook roof = city_roof(writer, style, seed, false);
    const double size = std::min(glm::length(lot[1] - lot[0]), glm::length(lot[2] - lot[1]));
    const int tiers = height > 60 && size > 24 ? 3 : height > 32 && size > 18 ? 2 : 1;
    const double parapet = 0.9;
    style.shops = doors;
    Quad corners = lot;
    double remaining = height;
    for (int tier = 0; tier < tiers; ++tier) {
        const std::uint64_t place = hash_mix(seed, 81, std::uint64_t(tier));
        const bool last = tier + 1 == tiers;
        const double share = last ? 1.0 : 0.5 + 0.2 * hash_unit(place, 1);
        Body body;
        body.corners = corners;
        body.foot_y = foot_y, body.floor_y = floor_y;
        const double tall = whole_storeys(remaining * share, style);
        body.top_y = floor_y + tall + parapet;
        for (int i = 0; i < 4; ++i) body.sides[i].door = doors && tier == 0;
        add_body_walls(writer, body, style, place, doors && tier == 0 ? floor_y + 15.0 : floor_y);
        add_parapet_roof(writer.mesh, corners, body.top_y, parapet, roof);
        remaining -= tall;
        foot_y = body.top_y - parapet - 0.2, floor_y = body.top_y - parapet;
        if (last || remaining < 8) {
            add_roof_plant(writer, inset_quad(corners, 1.0), floor_y, seed, height > 70 && hash_unit(seed, 82) < 0.6);
            break;
        }
        // The next tier stands back, by different distances, and on one side hardly.
        const double back = size * (0.07 + 0.08 * hash_unit(place, 2));
        std::array<double, 4> distances{back, back, back, back};
        distances[hash_mix(place, 3) % 4] = 1.0;
        corners = inset_quad(corners, distances);
        style.shops = false;
        style.ground_storey_m = style.storey_m;
    }
}

double tower_height(const BlockWriter& writer, std::uint64_t seed) {
    const double most = writer.plan.settings().max_height_m;
    const double away = std::clamp(writer.block.centrality, 0.0, 1.0);
    const double fall = 1.0 - 0.75 * away * std::sqrt(away);
    return std::max(16.0, most * fall * (0.5 + 0.5 * hash_unit(seed, 83)));
}

void add_standing_tower(BlockWriter& writer, const Quad& lot, double height, std::uint64_t seed) {
    const auto [low, high] = ground_range(writer, lot);
    writer.buildings.push_back(lot);
    add_tower(writer, lot, low - 0.5, high + kPavementLift, height, downtown_wall(seed), seed, true);
}

void add_podium_tower(BlockWriter& writer, const Quad& lot, std::uint64_t seed) {
    const auto [low, high] = ground_range(writer, lot);
    writer.buildings.push_back(lot);
    const WallKind kind = downtown_wall(seed);
    FacadeStyle style = city_facade(writer, kind, seed);
    style.shops = true;
    Body podium;
    podium.corners = lot;
    podium.foot_y = low - 0.5, podium.floor_y = high + kPavementLift;
    podium.top_y = podium.floor_y + whole_storeys(11.0 + 7.0 * hash_unit(seed, 84), style) + 1.0;
    for (BodySide& side : podium.sides) side.door = true;
    add_body_walls(writer, podium, style, seed);
    add_parapet_roof(writer.mesh, lot, podium.top_y, 1.0, city_roof(writer, style, seed, false));
    const double back = 0.2 + 0.06 * hash_unit(seed, 85), roof_y = podium.top_y - 1.0;
    // One tower in the middle or, less high, two beside each other.
    if (hash_unit(seed, 86) < 0.6) {
        add_tower(writer, part_of(lot, back, 1 - back, back, 1 - back), roof_y - 0.2, roof_y,
                  tower_height(writer, seed), kind, hash_mix(seed, 1), false);
    } else {
        add_tower(writer, part_of(lot, 0.1, 0.42, 0.2, 0.8), roof_y - 0.2, roof_y, tower_height(writer, seed), kind,
                  hash_mix(seed, 2), false);
        add_tower(writer, part_of(lot, 0.58, 0.9, 0.2, 0.8), roof_y - 0.2, roof_y, 0.8 * tower_height(writer, seed),
                  kind, hash_mix(seed, 3), false);
    }
}

/// A vessel of eight sides: its rim, its inner wall, and what fills it.
void add_basin(BlockWriter& writer, const DVec2& middle, double radius, double wall, double y0, double y1,
               double fill_y, std::uint32_t fill_material, std::uint32_t fill_color) {
    constexpr int kSides = 16;
    const CityMaterials& m = writer.materials;
    const std::uint32_t stone = pack_color(Vec3(0.7f));
    const auto at = [&](int i, double r, double y) {
        const double a = 2 * M_PI * i / kSides;
        return world_from_plan(middle + r * DVec2(std::cos(a), std::sin(a)), y);
    };
    const double inner = radius - wall;
    for (int i = 0; i < kSides; ++i) {
        writer.mesh.flat_quad({at(i, radius, y0), at(i + 1, radius, y0), at(i + 1, radius, y1), at(i, radius, y1)}, {},
                              m.stone, stone);
        writer.mesh.flat_quad({at(i, radius, y1), at(i + 1, radius, y1), at(i + 1, inner, y1), at(i, inner, y1)}, {},
                              m.stone, stone);
        writer.mesh.flat_quad({at(i + 1, inner, fill_y), at(i, inner, fill_y), at(i, inner, y1), at(i + 1, inner, y1)},
                              {}, m.stone, stone);
        writer.mesh.flat_triangle({world_from_plan(middle, fill_y), at(i, inner, fill_y), at(i + 1, inner, fill_y)}, {},
                                  fill_material, fill_color);
    }
}

}  // namespace

void add_downtown(BlockWriter& writer, const Quad& inside) {
    const std::array<int, 2> pieces = pieces_of(inside);
    writer.ground_quad(inside, pieces[0], pieces[1], kPavementLift, writer.materials.pavement,
                       pack_color(Vec3(0.85f, 0.84f, 0.82f)));
    const std::uint64_t seed = writer.block.seed;
    const double dice = hash_unit(seed, 90);
    const Quad lots = inset_quad(inside, 0.6);
    if (dice < 0.3) {
        add_podium_tower(writer, lots, seed);
        return;
    }
    // Two by two lots, or two slabs, with alleys between.
    const bool slabs = dice < 0.5;
    const double cut = 0.5 + 0.12 * (hash_unit(seed, 91) - 0.5), alley = 0.035;
    const bool turned = hash_unit(seed, 92) < 0.5;
    for (int i = 0; i < (slabs ? 2 : 4); ++i) {
        const std::uint64_t lot_seed = hash_mix(seed, 93, std::uint64_t(i));
        const auto span = [&](bool second) {
            return second ? std::array<double, 2>{cut + alley, 1.0} : std::array<double, 2>{0.0, cut - alley};
        };
        std::array<double, 2> u = span(i % 2 == 1), v = slabs ? std::array<double, 2>{0.0, 1.0} : span(i / 2 == 1);
        if (slabs && turned) std::swap(u, v);
        Quad lot = part_of(lots, u[0], u[1], v[0], v[1]);
        const double height = tower_height(writer, lot_seed) * (slabs ? 0.75 : 0.8);
        if (slabs) lot = inset_quad(lot, 3.0);
        if (!slabs && hash_unit(lot_seed, 2) < 0.12) {  // a pocket park instead
            const Quad lawn = inset_quad(lot, 2.0);
            writer.ground_quad(lawn, 3, 3, kPavementLift + 0.06, writer.materials.grass);
            for (int k = 0; k < 5; ++k)
                writer.prop(CityProp::Kind::park_tree,
                            point_in(lawn, 0.15 + 0.7 * hash_unit(lot_seed, 5, std::uint64_t(k)),
                                     0.15 + 0.7 * hash_unit(lot_seed, 6, std::uint64_t(k))),
                            {0, 1});
            continue;
        }
        add_standing_tower(writer, lot, height, lot_seed);
    }
}

void add_park(BlockWriter& writer, const Quad& inside) {
    const std::array<int, 2> pieces = pieces_of(inside);
    writer.ground_quad(inside, pieces[0], pieces[1], kPavementLift, writer.materials.grass);
    const std::uint64_t seed = writer.block.seed;
    // Two paths cross in a round place; everything keeps off them.
    const auto path = [&](double u0, double u1, double v0, double v1) {
        const Quad strip = part_of(inside, u0, u1, v0, v1);
        const std::array<int, 2> n = pieces_of(strip);
        writer.ground_quad(strip, n[0], n[1], kPavementLift + 0.03, writer.materials.gravel);
    };
    path(0.0, 1.0, 0.48, 0.52);
    path(0.48, 0.52, 0.0, 0.48);
    path(0.48, 0.52, 0.52, 1.0);
    const DVec2 middle = point_in(inside, 0.5, 0.5);
    const double y = writer.ground_at(middle) + kPavementLift;
    add_basin(writer, middle, 5.0, 0.5, y - 0.2, y + 0.5, y + 0.35, writer.materials.glass,
              pack_color({0.7f, 1.0f, 1.0f}));
    for (int i = 0; i < 60; ++i) {
        const double u = 0.03 + 0.94 * hash_unit(seed, 94, std::uint64_t(i), 1),
                     v = 0.03 + 0.94 * hash_unit(seed, 94, std::uint64_t(i), 2);
        if (std::abs(u - 0.5) < 0.05 || std::abs(v - 0.5) < 0.05) continue;
        const DVec2 p = point_in(inside, u, v);
        if (glm::length(p - middle) < 9.0) continue;
        writer.prop(i % 4 == 0 ? CityProp::Kind::bush : CityProp::Kind::park_tree, p,
                    {hash_unit(seed, 95, std::uint64_t(i)) - 0.5, 0.3});
    }
    for (int i = 0; i < 4; ++i) {
        const double angle = 0.25 * M_PI + 0.5 * M_PI * i;
        const DVec2 away{std::cos(angle), std::sin(angle)};
        writer.prop(CityProp::Kind::bench, middle + away * 7.0, -away);
    }
}

void add_square(BlockWriter& writer, const Quad& inside) {
    const std::array<int, 2> pieces = pieces_of(inside);
    writer.ground_quad(inside, pieces[0], pieces[1], kPavementLift, writer.materials.pavement,
                       pack_color({0.95f, 0.88f, 0.78f}));
    const CityMaterials& m = writer.materials;
    const DVec2 middle = point_in(inside, 0.5, 0.5);
    const double y = writer.ground_at(middle) + kPavementLift;
    add_basin(writer, middle, 9.0, 0.6, y - 0.2, y + 0.7, y + 0.5, m.glass, pack_color({0.7f, 1.0f, 1.0f}));
    add_basin(writer, middle, 3.0, 0.3, y + 0.3, y + 2.0, y + 1.85, m.glass, pack_color({0.7f, 1.0f, 1.0f}));
    const DVec2 axis{1.0, 0.0};
    add_box(writer.mesh, middle, axis, DVec2(0.8), y + 1.5, y + 5.0, m.stone, pack_color(Vec3(0.7f)), kWallTile);
    add_box(writer.mesh, middle, axis, DVec2(0.5), y + 4.9, y + 12.0, m.stone, pack_color(Vec3(0.75f)), kWallTile);
    // Trees in raised beds around it.
    for (int side = 0; side < 4; ++side)
        for (int i = 0; i < 5; ++i) {
            const double t = 0.14 + 0.18 * i, d = 0.1;
            const DVec2 p = side == 0   ? point_in(inside, t, d)
                            : side == 1 ? point_in(inside, 1 - d, t)
                            : side == 2 ? point_in(inside, 1 - t, 1 - d)
                                        : point_in(inside, d, 1 - t);
            const double bed_y = writer.ground_at(p) + kPavementLift;
            add_basin(writer, p, 1.5, 0.2, bed_y - 0.2, bed_y + 0.5, bed_y + 0.4, m.grass, kWhite);
            writer.prop(CityProp::Kind::street_tree, p, middle - p, kPavementLift + 0.4);
            if (i < 4) writer.prop(CityProp::Kind::bench, p + (point_in(inside, 0.5, 0.5) - p) * 0.12, middle - p);
        }
}

}  // namespace ff::cook::city
