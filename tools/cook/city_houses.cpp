// Detached houses in gardens, in two rows back to back.

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "tools/cook/city_buildings.h"

namespace ff::cook::city {
namespace {

constexpr double kGrassLift = kPavementLift + 0.02, kPathLift = kGrassLift + 0.04;

/// A fence between two points: posts, and boards between them, or a hedge.
void add_fence(BlockWriter& writer, const DVec2& p, const DVec2& q, bool hedge, double height, std::uint64_t seed) {
    const double length = glm::length(q - p);
    if (length < 1.0) return;
    const CityMaterials& m = writer.materials;
    const DVec2 along = (q - p) / length;
    const double spacing = hedge ? 8.0 : 2.5;
    const int pieces = std::max(1, int(std::round(length / spacing)));
    const std::uint32_t wood = pack_color(Vec3(0.5f, 0.42f, 0.33f) * float(0.5 + hash_unit(seed, 120)));
    for (int i = 0; i < pieces; ++i) {
        const DVec2 a = glm::mix(p, q, double(i) / pieces), b = glm::mix(p, q, double(i + 1) / pieces);
        const double y = std::max(writer.ground_at(a), writer.ground_at(b)) + kGrassLift;
        const DVec2 middle = 0.5 * (a + b);
        const double half = 0.5 * length / pieces;
        if (hedge) {
            add_box(writer.mesh, middle, along, {half, 0.4}, y - 0.3, y + height, m.leaves,
                    pack_color(Vec3(float(0.7 + 0.3 * hash_unit(seed, 121, std::uint64_t(i))))), 2.0);
            continue;
        }
        add_box(writer.mesh, a + along * 0.05, along, DVec2(0.05), y - 0.4, y + height + 0.08, m.plain, wood);
        add_box(writer.mesh, middle, along, {half, 0.02}, y + 0.08, y + height, m.plain, wood);
    }
}

struct HouseLot {
    Quad corners{};  ///< side 0 along the street
    bool attached_drive = false;
};

void add_porch(BlockWriter& writer, const DVec2& door, const DVec2& axis, const DVec2& out, double floor_y,
               std::uint32_t color) {
    const CityMaterials& m = writer.materials;
    for (int step = 0; step < 2; ++step)
        add_box(writer.mesh, door + out * (0.75 - 0.2 * step), axis, {1.1 - 0.1 * step, 0.75 - 0.2 * step},
                floor_y - 0.8, floor_y - 0.18 + 0.15 * step, m.stone, pack_color(Vec3(0.6f)));
    add_box(writer.mesh, door + out * 0.8, axis, {1.3, 0.85}, floor_y + 2.55, floor_y + 2.7, m.plain, color);
    for (const double s : {-1.1, 1.1})
        add_box(writer.mesh, door + axis * s + out * 1.45, axis, DVec2(0.08), floor_y - 0.6, floor_y + 2.56, m.plain,
                color);
}

void add_garage(BlockWriter& writer, const Quad& corners, const FacadeStyle& style, const RoofLook& roof) {
    const auto [low, high] = ground_range(writer, corners);
    const double y = high + kGrassLift, top = y + 2.7;
    FacadeStyle walls = style;
    for (int i = 0; i < 4; ++i)
        add_blank_wall(writer.mesh, {corners[i], corners[(i + 1) % 4], low - 0.4, top, y}, walls);
    RoofLook flat = roof;
    flat.roof = writer.materials.roof_flat;
    add_parapet_roof(writer.mesh, corners, top, 0.25, flat);
    // The door stands proud of the wall, in four boards.
    const DVec2 axis = glm::normalize(corners[1] - corners[0]), out{axis.y, -axis.x};
    const DVec2 middle = 0.5 * (corners[0] + corners[1]);
    for (int board = 0; board < 4; ++board)
        add_box(writer.mesh, middle + out * 0.03, axis, {1.25, 0.05}, y + 0.02 + 0.54 * board, y + 0.52 + 0.54 * board,
                writer.materials.plain, style.door_color);
    writer.buildings.push_back(corners);
}

void add_house(BlockWriter& writer, const Quad& lot, std::uint64_t seed) {
    const CityMaterials& m = writer.materials;
    const double width = glm::length(lot[1] - lot[0]),
                 depth = 0.5 * (glm::length(lot[2] - lot[1]) + glm::length(lot[3] - lot[0]));
    const DVec2 axis = glm::normalize(lot[1] - lot[0]), in{-axis.y, axis.x}, out = -in;
    const double setback = 4.5 + 2.5 * hash_unit(seed, 130);
    const double house_wide = std::min(width - 6.5, 8.5 + 3.0 * hash_unit(seed, 131));
    const double house_deep = std::min(depth - setback - 6.0, 8.0 + 2.5 * hash_unit(seed, 132));
    if (house_wide < 6 || house_deep < 6) return;
    // The drive keeps to one side, the house to the other.
    const bool drive_left = hash_unit(seed, 133) < 0.5;
    const auto at = [&](double s, double d) { return lot[0] + axis * s + in * d; };
    const double s0 = drive_left ? width - 1.4 - house_wide : 1.4;
    const auto rectangle = [&](double a0, double a1, double d0, double d1) {
        return Quad{at(a0, d0), at(a1, d0), at(a1, d1), at(a0, d1)};
    };
    const Quad corners = rectangle(s0, s0 + house_wide, setback, setback + house_deep);
    const auto [low, high] = ground_range(writer, corners);

    const double dice = hash_unit(seed, 134);
    FacadeStyle style = city_facade(writer, dice < 0.55 ? WallKind::plaster : WallKind::brick, seed);
    style.bay_m = (3.4 + 0.6 * hash_unit(seed, 135)) / std::sqrt(writer.plan.settings().detail);
    style.storey_m = style.ground_storey_m = 2.8;
    style.ledges = false, style.cornice = false, style.recess_m = 0.12;
    style.trim_color = pack_color(Vec3(float(0.6 + 0.25 * hash_unit(seed, 136))));
    const int storeys = hash_unit(seed, 137) < 0.75 ? 2 : 1;
    Body body;
    body.corners = corners;
    body.foot_y = low - 0.5, body.floor_y = high + kGrassLift + 0.35;
    body.top_y = body.floor_y + storeys * style.storey_m + 0.25;
    body.sides[0] = {SideKind::front, 0, true};
    body.sides[1] = {SideKind::back};
    body.sides[2] = {SideKind::front, 0, true};
    body.sides[3] = {SideKind::back};
    add_body_walls(writer, body, style, seed);
    writer.buildings.push_back(corners);

    RoofLook roof = city_roof(writer, style, seed, true);
    roof.rise = 0.75 + 0.3 * hash_unit(seed, 138);
    roof.overhang_m = 0.45;
    const bool gabled = hash_unit(seed, 139) < 0.65;
    if (gabled)
        add_gabled_roof(writer.mesh, corners, body.top_y, roof);
    else
        add_hipped_roof(writer.mesh, corners, body.top_y, roof);
    const double ridge_y = body.top_y + ridge_rise(corners, roof);
    const Quad sorted = long_side_first(corners);
    const DVec2 ridge_axis = glm::normalize(sorted[1] - sorted[0]);
    add_chimney(writer, point_in(sorted, 0.38 + 0.24 * hash_unit(seed, 140), 0.5), ridge_axis, body.top_y + 0.4,
                ridge_y, pack_color({0.42f, 0.16f, 0.10f}));
    if (hash_unit(seed, 141) < 0.45)
        add_dormers(writer, corners, body.top_y + (gabled ? 0.18 : 0.0), roof, style, 3.0, 2.2);

    // The bay with the door is the middle one, the upper middle where they are even.
    const int bays = std::max(1, int(house_wide / style.bay_m));
    const double door_s = s0 + house_wide * (bays / 2 + 0.5) / bays;
    add_porch(writer, at(door_s, setback), axis, out, body.floor_y, style.trim_color);
    const auto paved = [&](const Quad& quad, std::uint32_t material, int rows) {
        writer.ground_quad(quad, 1, rows, kPathLift, material, pack_color(Vec3(0.9f)));
    };
    paved(rectangle(door_s - 0.7, door_s + 0.7, 0.0, setback - 1.55), m.pavement, 1);
    const double drive0 = drive_left ? 0.9 : width - 3.9, garage_front = setback + 3.0;
    paved(rectangle(drive0, drive0 + 3.0, 0.0, garage_front), m.gravel, 1);
    const bool garage = hash_unit(seed, 142) < 0.7;
    if (garage) add_garage(writer, rectangle(drive0, drive0 + 3.0, garage_front, garage_front + 5.8), style, roof);
    // A terrace behind, and in many gardens a shed.
    paved(rectangle(s0 + 1.0, s0 + house_wide - 1.0, setback + house_deep + 0.05, setback + house_deep + 3.0),
          m.pavement, 1);
    if (hash_unit(seed, 143) < 0.5) {
        const DVec2 p = at(drive_left ? 2.6 : width - 2.6, depth - 3.2);
        const double y = writer.ground_at(p) + kGrassLift;
        const Quad shed{p - axis * 1.4 - in * 1.1, p + axis * 1.4 - in * 1.1, p + axis * 1.4 + in * 1.1,
                        p - axis * 1.4 + in * 1.1};
        FacadeStyle boards = style;
        boards.wall = m.plain, boards.wall_color = pack_color({0.30f, 0.20f, 0.12f});
        for (int i = 0; i < 4; ++i)
            add_blank_wall(writer.mesh, {shed[i], shed[(i + 1) % 4], y - 0.3, y + 2.0, y}, boards);
        RoofLook cover = roof;
        cover.wall = m.plain, cover.wall_color = boards.wall_color, cover.overhang_m = 0.15, cover.rise = 0.5;
        add_gabled_roof(writer.mesh, shed, y + 2.0, cover);
    }
    // Fences: the left one and the back one belong to this lot; the front leaves gates for path and drive.
    const bool hedge = hash_unit(seed, 144) < 0.5;
    add_fence(writer, at(0.25, 1.0), at(0.25, depth - 0.7), hash_unit(seed, 145) < 0.4, 1.5, hash_mix(seed, 1));
    std::array<std::array<double, 2>, 2> gates{{{door_s - 0.8, door_s + 0.8}, {drive0 - 0.1, drive0 + 3.1}}};
    if (gates[0][0] > gates[1][0]) std::swap(gates[0], gates[1]);
    double from = 0.7;
    for (const auto& [gate0, gate1] : gates) {
        add_fence(writer, at(from, 0.5), at(gate0, 0.5), hedge, hedge ? 1.1 : 0.9, hash_mix(seed, 2));
        from = gate1;
    }
    add_fence(writer, at(from, 0.5), at(width - 0.2, 0.5), hedge, hedge ? 1.1 : 0.9, hash_mix(seed, 2));

    for (int i = 0; i < 4; ++i) {
        const double s = 1.5 + (width - 3.0) * hash_unit(seed, 146, std::uint64_t(i));
        const double d = setback + house_deep + 5.0 +
                         std::max(0.0, depth - setback - house_deep - 7.0) * hash_unit(seed, 147, std::uint64_t(i));
        if (d > depth - 1.0) continue;
        writer.prop(i % 2 == 0 ? CityProp::Kind::garden_tree : CityProp::Kind::bush, at(s, d), in, kGrassLift);
    }
}

}  // namespace

void add_houses(BlockWriter& writer, const Quad& inside) {
    const std::array<int, 2> pieces = pieces_of(inside);
    writer.ground_quad(inside, pieces[0], pieces[1], kGrassLift, writer.materials.grass);
    // The lawn lies a little higher than the pavement: a stone edge closes the step.
    for (int i = 0; i < 4; ++i) {
        const DVec2 p = inside[i], q = inside[(i + 1) % 4];
        const int n = pieces[i % 2];
        for (int k = 0; k < n; ++k) {
            const DVec2 a = glm::mix(p, q, double(k) / n), b = glm::mix(p, q, double(k + 1) / n);
            writer.mesh.flat_quad({writer.on_ground(a, 0.1), writer.on_ground(b, 0.1), writer.on_ground(b, kGrassLift),
                                   writer.on_ground(a, kGrassLift)},
                                  {}, writer.materials.stone, pack_color(Vec3(0.5f)));
        }
    }
    // Rows along the longer sides.
    Quad plot = inside;
    const double first = glm::length(plot[1] - plot[0]) + glm::length(plot[2] - plot[3]);
    const double second = glm::length(plot[2] - plot[1]) + glm::length(plot[3] - plot[0]);
    if (second > first) plot = {inside[1], inside[2], inside[3], inside[0]};
    const Quad rows[2] = {part_of(plot, 0, 1, 0, 0.5), part_of({plot[2], plot[3], plot[0], plot[1]}, 0, 1, 0, 0.5)};
    for (int row = 0; row < 2; ++row) {
        const Quad& r = rows[row];
        const int count = std::max(2, int(glm::length(r[1] - r[0]) / 17.0));
        for (int i = 0; i < count; ++i)
            add_house(writer, part_of(r, double(i) / count, double(i + 1) / count, 0, 1),
                      hash_mix(writer.block.seed, 150, std::uint64_t(row), std::uint64_t(i)));
        if (row == 0) add_fence(writer, r[3], r[2], true, 1.7, writer.block.seed);
    }
    for (int side = 0; side < 2; ++side) {
        const Quad& r = rows[side];
        add_fence(writer, r[1] + 0.012 * (r[0] - r[1]) + 0.03 * (r[2] - r[1]),
                  r[2] + 0.012 * (r[3] - r[2]) + 0.03 * (r[1] - r[2]), false, 1.5, hash_mix(writer.block.seed, 151));
    }
}

}  // namespace ff::cook::city
