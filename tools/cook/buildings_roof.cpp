#include "tools/cook/buildings_roof.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <vector>

namespace ff::cook {
namespace {

Vec2 plan_uv(const DVec2& p, double tile) {
    return Vec2(p.x / tile, -p.y / tile);
}

/// A sloping face: textured along its lower edge and up its slope.
void add_slope(MeshBuilder& mesh, const DVec3& a, const DVec3& b, const DVec3& c, const DVec3& d,
               const RoofLook& look) {
    const double wide = glm::length(b - a);
    const DVec3 along = (b - a) / std::max(wide, 1e-6);
    const auto uv = [&](const DVec3& p) {
        const double s = glm::dot(p - a, along);
        return Vec2(s / look.tile_m, -glm::length(p - a - along * s) / look.tile_m);
    };
    if (glm::length(d - c) < 1e-3)
        mesh.flat_triangle({a, b, c}, {uv(a), uv(b), uv(c)}, look.roof, look.roof_color);
    else
        mesh.flat_quad({a, b, c, d}, {uv(a), uv(b), uv(c), uv(d)}, look.roof, look.roof_color);
}

}  // namespace

std::array<DVec2, 4> long_side_first(const std::array<DVec2, 4>& c) {
    const double first = glm::length(c[1] - c[0]) + glm::length(c[3] - c[2]);
    const double second = glm::length(c[2] - c[1]) + glm::length(c[0] - c[3]);
    if (first >= second) return c;
    return {c[1], c[2], c[3], c[0]};
}

std::array<DVec2, 4> offset_corners(const std::array<DVec2, 4>& c, double distance) {
    std::array<DVec2, 4> out;
    for (int i = 0; i < 4; ++i) {
        const DVec2 before = glm::normalize(c[i] - c[(i + 3) % 4]), after = glm::normalize(c[(i + 1) % 4] - c[i]);
        const DVec2 n0{before.y, -before.x}, n1{after.y, -after.x};
        const double scale = 1.0 / std::max(0.25, 1.0 + glm::dot(n0, n1));
        out[i] = c[i] + (n0 + n1) * (distance * scale);
    }
    return out;
}

bool is_convex_quad(const Footprint& footprint) {
    if (footprint.outer.size() != 4 || !footprint.holes.empty()) return false;
    for (int i = 0; i < 4; ++i) {
        const DVec2 a = footprint.outer[(i + 1) % 4] - footprint.outer[i];
        const DVec2 b = footprint.outer[(i + 2) % 4] - footprint.outer[(i + 1) % 4];
        if (a.x * b.y - a.y * b.x <= 0.2 * glm::length(a) * glm::length(b)) return false;
    }
    return true;
}

double ridge_rise(const std::array<DVec2, 4>& corners, const RoofLook& look) {
    const std::array<DVec2, 4> c = long_side_first(corners);
    return look.rise * 0.25 * (glm::length(c[2] - c[1]) + glm::length(c[0] - c[3]));
}

void add_flat_roof(MeshBuilder& mesh, const Footprint& footprint, double y, const RoofLook& look) {
    std::vector<DVec2> points = footprint.outer;
    for (const Ring& hole : footprint.holes) points.insert(points.end(), hole.begin(), hole.end());
    const std::vector<std::uint32_t> triangles = triangulate(footprint.outer, footprint.holes);
    std::vector<std::uint32_t> ids;
    for (const DVec2& p : points)
        ids.push_back(mesh.vertex(world_from_plan(p, y), Vec3(0, 1, 0), plan_uv(p, look.tile_m), look.roof_color));
    for (std::size_t i = 0; i + 2 < triangles.size(); i += 3)
        mesh.triangle(ids[triangles[i]], ids[triangles[i + 1]], ids[triangles[i + 2]], look.roof);
}

void add_gabled_roof(MeshBuilder& mesh, const std::array<DVec2, 4>& corners, double y, const RoofLook& look) {
    const std::array<DVec2, 4> c = long_side_first(corners);
    const double rise = ridge_rise(corners, look);
    // The gables close the walls up to the ridge.
    const DVec2 ridge0 = 0.5 * (c[0] + c[3]), ridge1 = 0.5 * (c[1] + c[2]);
    const auto gable = [&](const DVec2& p, const DVec2& q, const DVec2& top) {
        const float wide = float(glm::length(q - p) / 4.0);
        mesh.flat_triangle({world_from_plan(p, y), world_from_plan(q, y), world_from_plan(top, y + rise)},
                           {Vec2(0, 0), Vec2(wide, 0), Vec2(0.5f * wide, -float(rise / 4.0))}, look.wall,
                           look.wall_color);
    };
    gable(c[1], c[2], ridge1);
    gable(c[3], c[0], ridge0);
    // The slopes go on beyond the walls, downwards at the eaves and outwards at the gables.
    const double half = 0.25 * (glm::length(c[2] - c[1]) + glm::length(c[0] - c[3]));
    const double drop = look.overhang_m * rise / std::max(half, 0.1);
    const std::array<DVec2, 4> e = look.overhang_m > 0 ? offset_corners(c, look.overhang_m) : c;
    const DVec2 r0 = 0.5 * (e[0] + e[3]), r1 = 0.5 * (e[1] + e[2]);
    const double thick = look.overhang_m > 0 ? 0.18 : 0.0;
    const auto p = [&](const DVec2& plan, double height) { return world_from_plan(plan, height); };
    const double low = y - drop + thick, high = y + rise + thick;
    add_slope(mesh, p(e[0], low), p(e[1], low), p(r1, high), p(r0, high), look);
    add_slope(mesh, p(e[2], low), p(e[3], low), p(r0, high), p(r1, high), look);
    if (thick <= 0) return;
    // Undersides and edges, so that the overhang has a body.
    RoofLook under = look;
    under.roof = look.trim, under.roof_color = look.trim_color;
    add_slope(mesh, p(e[1], low - thick), p(e[0], low - thick), p(r0, high - thick), p(r1, high - thick), under);
    add_slope(mesh, p(e[3], low - thick), p(e[2], low - thick), p(r1, high - thick), p(r0, high - thick), under);
    const auto edge = [&](const DVec2& a, double ya, const DVec2& b, double yb) {
        add_slope(mesh, p(a, ya - thick), p(b, yb - thick), p(b, yb), p(a, ya), under);
    };
    edge(e[0], low, e[1], low);
    edge(e[2], low, e[3], low);
    edge(e[1], low, r1, high);
    edge(r1, high, e[2], low);
    edge(e[3], low, r0, high);
    edge(r0, high, e[0], low);
}

void add_hipped_roof(MeshBuilder& mesh, const std::array<DVec2, 4>& corners, double y, const RoofLook& look) {
    const std::array<DVec2, 4> c = long_side_first(corners);
    const double rise = ridge_rise(corners, look);
    const double half = 0.25 * (glm::length(c[2] - c[1]) + glm::length(c[0] - c[3]));
    const std::array<DVec2, 4> e = look.overhang_m > 0 ? offset_corners(c, look.overhang_m) : c;
    const double drop = look.overhang_m * rise / std::max(half, 0.1);
    DVec2 r0 = 0.5 * (c[0] + c[3]), r1 = 0.5 * (c[1] + c[2]);
    const double length = glm::length(r1 - r0), inset = std::min(half, 0.499 * length);
    const DVec2 along = (r1 - r0) / std::max(length, 1e-6);
    r0 += along * inset, r1 -= along * inset;
    const auto p = [&](const DVec2& plan, double height) { return world_from_plan(plan, height); };
    const double low = y - drop, high = y + rise;
    add_slope(mesh, p(e[0], low), p(e[1], low), p(r1, high), p(r0, high), look);
    add_slope(mesh, p(e[1], low), p(e[2], low), p(r1, high), p(r1, high), look);
    add_slope(mesh, p(e[2], low), p(e[3], low), p(r0, high), p(r1, high), look);
    add_slope(mesh, p(e[3], low), p(e[0], low), p(r0, high), p(r0, high), look);
    if (look.overhang_m <= 0) return;
    for (int i = 0; i < 4; ++i) {  // the soffit between wall and eaves
        const int j = (i + 1) % 4;
        RoofLook under = look;
        under.roof = look.trim, under.roof_color = look.trim_color;
        add_slope(mesh, p(e[j], low - 0.02), p(e[i], low - 0.02), p(c[i], y - 0.02), p(c[j], y - 0.02), under);
    }
}

void add_parapet_roof(MeshBuilder& mesh, const std::array<DVec2, 4>& c, double y, double parapet,
                      const RoofLook& look) {
    const std::array<DVec2, 4> inner = offset_corners(c, -0.3);
    const double floor_y = y - parapet;
    const auto p = [&](const DVec2& plan, double height) { return world_from_plan(plan, height); };
    for (int i = 0; i < 4; ++i) {
        const int j = (i + 1) % 4;
        const float wide = float(glm::length(c[j] - c[i]) / look.tile_m);
        mesh.flat_quad({p(c[i], y), p(c[j], y), p(inner[j], y), p(inner[i], y)},
                       {Vec2(0, 0), Vec2(wide, 0), Vec2(wide, -0.1f), Vec2(0, -0.1f)}, look.trim, look.trim_color);
        mesh.flat_quad({p(inner[j], floor_y), p(inner[i], floor_y), p(inner[i], y), p(inner[j], y)},
                       {Vec2(0, 0), Vec2(wide, 0), Vec2(wide, -0.3f), Vec2(0, -0.3f)}, look.wall, look.wall_color);
    }
    mesh.flat_quad({p(inner[0], floor_y), p(inner[1], floor_y), p(inner[2], floor_y), p(inner[3], floor_y)},
                   {plan_uv(inner[0], look.tile_m), plan_uv(inner[1], look.tile_m), plan_uv(inner[2], look.tile_m),
                    plan_uv(inner[3], look.tile_m)},
                   look.roof, look.roof_color);
}

}  // namespace ff::cook
