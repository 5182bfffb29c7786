#include "tools/cook/city_buildings.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

namespace ff::cook::city {
namespace {

using Rgb = std::array<float, 3>;

template <std::size_t N>
std::uint32_t choose_color(const std::array<Rgb, N>& palette, std::uint64_t seed) {
    const Rgb& c = palette[hash_mix(seed, 41) % N];
    const float shade = float(0.88 + 0.2 * hash_unit(seed, 42));
    return pack_color(Vec3(c[0], c[1], c[2]) * shade);
}

// Linear colours; the textures that they multiply are light grey.
constexpr std::array<Rgb, 6> kBricks{{{0.42f, 0.15f, 0.09f},
                                      {0.50f, 0.22f, 0.13f},
                                      {0.33f, 0.13f, 0.10f},
                                      {0.58f, 0.36f, 0.22f},
                                      {0.48f, 0.40f, 0.30f},
                                      {0.27f, 0.20f, 0.17f}}};
constexpr std::array<Rgb, 8> kPlasters{{{0.80f, 0.72f, 0.55f},
                                        {0.78f, 0.60f, 0.38f},
                                        {0.72f, 0.46f, 0.33f},
                                        {0.85f, 0.83f, 0.78f},
                                        {0.60f, 0.66f, 0.55f},
                                        {0.55f, 0.62f, 0.70f},
                                        {0.82f, 0.77f, 0.66f},
                                        {0.70f, 0.58f, 0.52f}}};
constexpr std::array<Rgb, 4> kStones{
    {{0.72f, 0.66f, 0.55f}, {0.62f, 0.58f, 0.52f}, {0.74f, 0.70f, 0.64f}, {0.55f, 0.49f, 0.42f}}};
constexpr std::array<Rgb, 5> kConcretes{{{0.62f, 0.61f, 0.58f},
                                         {0.75f, 0.74f, 0.70f},
                                         {0.48f, 0.47f, 0.46f},
                                         {0.66f, 0.58f, 0.48f},
                                         {0.34f, 0.30f, 0.28f}}};
constexpr std::array<Rgb, 5> kSpandrels{{{0.16f, 0.20f, 0.24f},
                                         {0.30f, 0.34f, 0.37f},
                                         {0.10f, 0.11f, 0.12f},
                                         {0.55f, 0.57f, 0.58f},
                                         {0.20f, 0.26f, 0.24f}}};
constexpr std::array<Rgb, 5> kDoors{{{0.18f, 0.06f, 0.03f},
                                     {0.04f, 0.10f, 0.06f},
                                     {0.03f, 0.06f, 0.14f},
                                     {0.22f, 0.14f, 0.08f},
                                     {0.30f, 0.03f, 0.03f}}};

DVec2 unit(const DVec2& v) {
    return v / std::max(glm::length(v), 1e-9);
}

}  // namespace

FacadeStyle city_facade(const BlockWriter& writer, WallKind kind, std::uint64_t seed) {
    const CityMaterials& m = writer.materials;
    const double detail = writer.plan.settings().detail;
    const auto chance = [&](std::uint64_t what, double probability) {
        return hash_unit(seed, what) < probability * std::min(detail, 1.6);
    };
    FacadeStyle s;
    s.glass = m.glass, s.trim = s.door = m.plain;
    s.wall_tile_m = DVec2(kWallTile);
    s.glass_color = kWhite;
    s.door_color = choose_color(kDoors, seed);
    s.trim_color = pack_color(Vec3(float(0.55 + 0.3 * hash_unit(seed, 1))));
    s.storey_m = 3.0 + 0.3 * hash_unit(seed, 2);
    s.ground_storey_m = 4.0;
    double bay = 3.5 + 1.2 * hash_unit(seed, 3);
    switch (kind) {
        case WallKind::brick:
            s.wall = m.brick, s.wall_color = choose_color(kBricks, seed);
            s.mullions = chance(4, 0.5), s.ledges = chance(5, 0.3), s.frames = chance(6, 0.3);
            s.window_width = 0.42, s.window_height = 0.55;
            break;
        case WallKind::plaster:
            s.wall = m.plaster, s.wall_color = choose_color(kPlasters, seed);
            s.mullions = chance(4, 0.5), s.ledges = chance(5, 0.5), s.frames = chance(6, 0.35);
            s.window_width = 0.40, s.window_height = 0.56;
            break;
        case WallKind::stone:
            s.wall = m.stone, s.wall_color = choose_color(kStones, seed);
            s.mullions = chance(4, 0.3), s.ledges = chance(5, 0.4), s.pilasters = chance(6, 0.5);
            s.trim_color = choose_color(kStones, seed + 1);
            s.window_width = 0.45, s.window_height = 0.6, s.recess_m = 0.28;
            break;
        case WallKind::concrete:
            s.wall = m.concrete, s.wall_color = choose_color(kConcretes, seed);
            s.trim_color = s.wall_color;
            s.mullions = false, s.sills = chance(4, 0.3), s.ledges = chance(5, 0.4);
            s.window_width = 0.66 + 0.15 * hash_unit(seed, 7), s.window_height = 0.5, s.recess_m = 0.35;
            bay += 1.0;
            break;
        case WallKind::curtain:
            s.wall = m.concrete, s.wall_color = choose_color(kSpandrels, seed);
            s.glass = m.curtain_glass;
            s.trim = m.metal, s.trim_color = pack_color(Vec3(float(0.35 + 0.5 * hash_unit(seed, 8))));
            s.mullions = false, s.sills = false, s.pilasters = chance(6, 0.4);
            s.window_width = 0.9, s.window_height = 0.74, s.sill = 0.2, s.recess_m = 0.12;
            s.storey_m = 3.7;
            bay += 0.6;
            break;
    }
    s.bay_m = bay / std::sqrt(detail);
    return s;
}

FacadeStyle plainer(const FacadeStyle& style) {
    FacadeStyle s = style;
    s.mullions = s.frames = s.ledges = s.shops = s.sills = false;
    s.pilasters = false;
    s.bay_m *= 1.25;
    return s;
}

RoofLook city_roof(const BlockWriter& writer, const FacadeStyle& style, std::uint64_t seed, bool sloped) {
    const CityMaterials& m = writer.materials;
    RoofLook look;
    const bool red = hash_unit(seed, 50) < 0.6;
    look.roof = !sloped ? m.roof_flat : red ? m.roof_red : m.roof_dark;
    const double shade = 0.75 + 0.25 * hash_unit(seed, 51);
    look.roof_color =
        pack_color(sloped ? Vec3(float(shade), float(shade * (0.9 + 0.1 * hash_unit(seed, 52))), float(shade))
                          : Vec3(float(0.55 + 0.35 * hash_unit(seed, 53))));
    look.wall = style.wall, look.wall_color = style.wall_color;
    look.trim = m.plain, look.trim_color = pack_color(Vec3(float(0.45 + 0.3 * hash_unit(seed, 54))));
    look.tile_m = sloped ? kRoofTile : kGroundTile;
    return look;
}

void add_body_walls(BlockWriter& writer, const Body& body, const FacadeStyle& style, std::uint64_t seed,
                    double plain_from_y) {
    const FacadeStyle less = plainer(style);
    for (int i = 0; i < 4; ++i) {
        const BodySide& side = body.sides[i];
        WallSpan span{body.corners[i], body.corners[(i + 1) % 4], body.foot_y, body.top_y, body.floor_y};
        if (side.kind == SideKind::party) {
            if (body.top_y > side.from_y + 0.01) {
                span.y0 = span.ground_y = std::max(side.from_y, body.foot_y);
                add_blank_wall(writer.mesh, span, style);
            }
            continue;
        }
        const bool front = side.kind == SideKind::front;
        const FacadeStyle& look = front ? style : less;
        const std::uint64_t place = hash_mix(seed, 60, std::uint64_t(i));
        // The split lies between two storeys.
        const double storeys = std::floor((plain_from_y - body.floor_y - look.ground_storey_m) / look.storey_m);
        const double split = body.floor_y + look.ground_storey_m + storeys * look.storey_m;
        if (storeys < 1 || split > body.top_y - look.storey_m) {
            add_facade(writer.mesh, span, look, place, side.door);
            continue;
        }
        FacadeStyle lower = look, upper = plainer(look);
        lower.cornice = false, lower.pilasters = false;
        upper.pilasters = false, upper.bay_m = look.bay_m;
        upper.ground_storey_m = upper.storey_m;
        span.y1 = split;
        add_facade(writer.mesh, span, lower, place, side.door);
        span.y0 = span.ground_y = split, span.y1 = body.top_y;
        add_facade(writer.mesh, span, upper, hash_mix(place, 1), false);
    }
}

void add_roof_plant(BlockWriter& writer, const Quad& roof, double y, std::uint64_t seed, bool mast) {
    const DVec2 axis = unit(roof[1] - roof[0]);
    const double size = std::min(glm::length(roof[1] - roof[0]), glm::length(roof[2] - roof[1]));
    if (size < 6) return;
    const CityMaterials& m = writer.materials;
    // The lift's house, then machines in places of their own: a 3 x 3 pattern that nothing overlaps.
    add_box(writer.mesh, point_in(roof, 0.5, 0.5), axis, DVec2(size * 0.11, size * 0.09), y - 0.1, y + 3.2, m.concrete,
            pack_color(Vec3(0.5f)));
    for (int place = 0; place < 9; ++place) {
        if (place == 4) continue;
        const std::uint64_t item = hash_mix(seed, 70, std::uint64_t(place));
        const double kind = hash_unit(item, 1);
        if (kind > 0.6) continue;
        const DVec2 p = point_in(roof, 0.23 + 0.27 * (place % 3), 0.23 + 0.27 * (place / 3));
        const double half = std::min(1.6, size * 0.06) * (0.7 + 0.6 * hash_unit(item, 2));
        if (kind < 0.35) {  // a cooler on feet, with two fans' rims
            add_box(writer.mesh, p, axis, DVec2(half * 1.5, half), y - 0.05, y + 1.5, m.metal,
                    pack_color(Vec3(float(0.5 + 0.4 * hash_unit(item, 3)))));
            for (const double s : {-0.75, 0.75})
                add_box(writer.mesh, p + axis * (s * half), axis, DVec2(half * 0.5), y + 1.45, y + 1.75, m.metal,
                        pack_color(Vec3(0.25f)));
        } else if (kind < 0.5) {  // a duct
            add_box(writer.mesh, p, axis, DVec2(half * 2.2, 0.4), y - 0.05, y + 0.7, m.metal, pack_color(Vec3(0.7f)));
        } else {  // a skylight
            add_box(writer.mesh, p, axis, DVec2(half), y - 0.05, y + 0.35, m.plain, pack_color(Vec3(0.5f)));
            add_box(writer.mesh, p, axis, DVec2(half * 0.85), y + 0.3, y + 0.5, m.glass, kWhite);
        }
    }
    if (!mast) return;
    const DVec2 p = point_in(roof, 0.5, 0.5);
    add_box(writer.mesh, p, axis, DVec2(0.35), y + 3.1, y + 9.0, m.metal, pack_color(Vec3(0.6f)));
    add_box(writer.mesh, p, axis, DVec2(0.14), y + 8.9, y + 17.0, m.metal, pack_color({0.7f, 0.1f, 0.08f}));
}

void add_chimney(BlockWriter& writer, const DVec2& p, const DVec2& axis, double from_y, double ridge_y,
                 std::uint32_t color) {
    const CityMaterials& m = writer.materials;
    const double top = ridge_y + 0.9;
    add_box(writer.mesh, p, axis, {0.45, 0.32}, from_y, top, m.brick, color, kWallTile);
    add_box(writer.mesh, p, axis, {0.54, 0.41}, top - 0.03, top + 0.12, m.plain, pack_color(Vec3(0.4f)));
    for (const double s : {-0.2, 0.2})
        add_box(writer.mesh, p + axis * s, axis, {0.12, 0.12}, top + 0.1, top + 0.45, m.plain,
                pack_color({0.35f, 0.14f, 0.09f}));
}

void add_dormers(BlockWriter& writer, const Quad& corners, double eaves_y, const RoofLook& roof,
                 const FacadeStyle& style, double spacing_m, double margin_m) {
    const Quad c = long_side_first(corners);
    const double rise = ridge_rise(c, roof);
    MeshBuilder& mesh = writer.mesh;
    for (const int side : {0, 2}) {
        const DVec2 p = c[side], q = c[side + 1];
        const double length = glm::length(q - p);
        const DVec2 along = (q - p) / length, in{-along.y, along.x};
        // Depth of the slope below this side, at its middle.
        const DVec2 ridge =
            0.5 * (side == 0 ? 0.5 * (c[0] + c[3]) + 0.5 * (c[1] + c[2]) : 0.5 * (c[0] + c[3]) + 0.5 * (c[1] + c[2]));
        const double half = glm::dot(ridge - p, in);
        if (half < 2.5) continue;
        const double slope = rise / half;
        const double d0 = 0.22 * half, front_y = eaves_y + slope * d0 - 0.1;
        const double tall = std::min(1.5, 0.55 * rise), wide = 0.75;
        const double top_y = front_y + 0.1 + tall;
        const int count = int((length - 2 * margin_m) / spacing_m);
        for (int i = 0; i < count; ++i) {
            const DVec2 middle = p + along * (0.5 * length + (i - 0.5 * (count - 1)) * spacing_m);
            const auto at = [&](double s, double y, double d) {
                return world_from_plan(middle + along * s + in * d, y);
            };
            const double back = d0 + (tall + 0.35) / slope;  // where its roof has gone into the big one
            const double ridge_y = top_y + 0.45, ridge_back = std::min(d0 + (tall + 0.8) / slope, half - 0.1);
            mesh.flat_quad({at(-wide, front_y, d0), at(wide, front_y, d0), at(wide, top_y, d0), at(-wide, top_y, d0)},
                           {}, style.trim, style.trim_color);
            mesh.flat_triangle({at(-wide, top_y, d0), at(wide, top_y, d0), at(0, ridge_y, d0)}, {}, style.trim,
                               style.trim_color);
            mesh.flat_quad({at(-0.5, front_y + 0.3, d0 - 0.03), at(0.5, front_y + 0.3, d0 - 0.03),
                            at(0.5, top_y - 0.1, d0 - 0.03), at(-0.5, top_y - 0.1, d0 - 0.03)},
                           {}, style.glass, style.glass_color);
            mesh.flat_triangle({at(-wide, front_y, d0), at(-wide, top_y, d0), at(-wide, top_y, back)}, {}, style.wall,
                               style.wall_color);
            mesh.flat_triangle({at(wide, front_y, d0), at(wide, top_y, back), at(wide, top_y, d0)}, {}, style.wall,
                               style.wall_color);
            const double eave = wide + 0.15, low = top_y - 0.09, out = d0 - 0.2;
            mesh.flat_quad({at(-eave, low, back), at(-eave, low, out), at(0, ridge_y + 0.06, out),
                            at(0, ridge_y + 0.06, ridge_back)},
                           {Vec2(1, 0), Vec2(0, 0), Vec2(0, -0.3f), Vec2(1, -0.3f)}, roof.roof, roof.roof_color);
            mesh.flat_quad({at(eave, low, out), at(eave, low, back), at(0, ridge_y + 0.06, ridge_back),
                            at(0, ridge_y + 0.06, out)},
                           {Vec2(0, 0), Vec2(1, 0), Vec2(1, -0.3f), Vec2(0, -0.3f)}, roof.roof, roof.roof_color);
        }
    }
}

std::array<double, 2> ground_range(const BlockWriter& writer, const Quad& quad) {
    double low = writer.ground_at(quad[0]), high = low;
    for (int i = 1; i < 4; ++i) {
        const double y = writer.ground_at(quad[i]);
        low = std::min(low, y), high = std::max(high, y);
    }
    return {low, high};
}

}  // namespace ff::cook::city
