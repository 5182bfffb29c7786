#include "tools/cook/buildings.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <map>

#include "engine/core/jobs.h"
#include "tools/cook/buildings_facade.h"
#include "tools/cook/buildings_roof.h"
#include "tools/cook/mesh_builder.h"

namespace ff::cook {
namespace {

constexpr double kCellSize = 256.0;
constexpr double kFoundation = 0.4;  // how far walls reach below the lowest ground, m

void add_building(const Footprint& footprint, const BuildingLook& look,
                  const std::function<double(double, double)>& ground, MeshBuilder& mesh) {
    double lowest = std::numeric_limits<double>::infinity(), highest = -lowest;
    for (const DVec2& p : footprint.outer) {
        const double y = ground(p.x, -p.y);
        lowest = std::min(lowest, y);
        highest = std::max(highest, y);
    }
    const std::uint64_t seed = hash_mix(std::uint64_t(std::llround(footprint.outer[0].x * 100)),
                                        std::uint64_t(std::llround(footprint.outer[0].y * 100)));
    FacadeStyle style;
    style.wall = look.wall_material, style.glass = look.glass_material;
    style.trim = look.trim_material, style.door = look.door_material;
    style.wall_tile_m = look.facade_size_m;
    style.storey_m = style.ground_storey_m = look.level_height_m;
    style.bay_m = 2.6 + 1.4 * hash_unit(seed, 1);
    style.ledges = hash_unit(seed, 2) < 0.35;
    style.frames = hash_unit(seed, 3) < 0.3;
    style.shops = footprint.height_m > 12 && hash_unit(seed, 4) < 0.5;
    style.balcony_share = footprint.height_m > 9 && hash_unit(seed, 5) < 0.3 ? 0.3 : 0.0;
    style.glass_color = pack_color({0.75f, 0.85f, 0.95f});
    if (look.tint) {
        const Vec3 tint(float(0.72 + 0.28 * hash_unit(seed, 6)), float(0.68 + 0.26 * hash_unit(seed, 7)),
                        float(0.62 + 0.26 * hash_unit(seed, 8)));
        style.wall_color = pack_color(tint);
        style.trim_color = pack_color(Vec3(float(0.7 + 0.3 * hash_unit(seed, 9))));
    }
    RoofLook roof{look.roof_material, look.wall_material, look.trim_material};
    roof.wall_color = style.wall_color, roof.trim_color = style.trim_color;

    const bool stands = footprint.base_m <= 0;
    const double top = lowest + footprint.height_m;
    const double foot = stands ? lowest - kFoundation : lowest + footprint.base_m;
    bool sloped = look.roof != RoofShape::flat && is_convex_quad(footprint);
    std::array<DVec2, 4> corners{};
    double eaves = top;
    if (sloped) {
        std::copy_n(footprint.outer.begin(), 4, corners.begin());
        // The height given is the ridge's, as surveys mean it; low houses keep 2.2 m of wall.
        const double rise = ridge_rise(corners, roof);
        eaves = top - rise;
        if (eaves < highest + 2.2 || eaves <= foot) sloped = false, eaves = top;
    }

    std::size_t longest = 0;
    for (std::size_t i = 1; i < footprint.outer.size(); ++i) {
        const auto side = [&](std::size_t k) {
            return glm::length(footprint.outer[(k + 1) % footprint.outer.size()] - footprint.outer[k]);
        };
        if (side(i) > side(longest)) longest = i;
    }
    const auto add_ring = [&](const Ring& ring, bool is_outer) {
        for (std::size_t i = 0; i < ring.size(); ++i) {
            const WallSpan span{ring[i], ring[(i + 1) % ring.size()], foot, eaves,
                                stands ? std::min(std::max(highest, foot), eaves) : foot};
            if (look.detail)
                add_facade(mesh, span, style, hash_mix(seed, i), stands && is_outer && i == longest);
            else
                add_blank_wall(mesh, span, style);
        }
    };
    add_ring(footprint.outer, true);
    for (const Ring& hole : footprint.holes) add_ring(hole, false);

    if (sloped) {
        roof.overhang_m = look.detail ? 0.4 : 0.0;
        if (look.roof == RoofShape::gabled)
            add_gabled_roof(mesh, corners, eaves, roof);
        else
            add_hipped_roof(mesh, corners, eaves, roof);
    } else {
        roof.roof = look.flat_roof_material;
        add_flat_roof(mesh, footprint, top, roof);
    }
    if (!stands) {  // an underside for what hangs over
        const std::vector<std::uint32_t> triangles = triangulate(footprint.outer, footprint.holes);
        std::vector<DVec2> points = footprint.outer;
        for (const Ring& hole : footprint.holes) points.insert(points.end(), hole.begin(), hole.end());
        for (std::size_t i = 0; i + 2 < triangles.size(); i += 3)
            mesh.flat_triangle(
                {world_from_plan(points[triangles[i]], foot), world_from_plan(points[triangles[i + 2]], foot),
                 world_from_plan(points[triangles[i + 1]], foot)},
                {Vec2(0), Vec2(0), Vec2(0)}, look.trim_material, style.trim_color);
    }
}

}  // namespace

void add_buildings(const std::vector<Footprint>& footprints, const BuildingLook& look,
                   const std::function<double(double, double)>& ground, WorldSource& world) {
    std::map<std::pair<long, long>, std::vector<const Footprint*>> cells;
    for (const Footprint& footprint : footprints) {
        if (footprint.outer.size() < 3) continue;
        const DVec2& p = footprint.outer[0];
        cells[{std::lround(std::floor(p.x / kCellSize)), std::lround(std::floor(-p.y / kCellSize))}].push_back(
            &footprint);
    }
    const std::vector<std::pair<std::pair<long, long>, std::vector<const Footprint*>>> ordered(cells.begin(),
                                                                                               cells.end());
    std::vector<MeshBuilder> builders;
    for (const auto& [cell, members] : ordered) {
        const DVec2& p = members[0]->outer[0];
        builders.emplace_back(fmt::format("buildings {} {}", cell.first, cell.second),
                              DVec3((double(cell.first) + 0.5) * kCellSize, std::floor(ground(p.x, -p.y)),
                                    (double(cell.second) + 0.5) * kCellSize));
    }
    parallel_for(ordered.size(), [&](std::size_t i) {
        for (const Footprint* footprint : ordered[i].second) add_building(*footprint, look, ground, builders[i]);
    });
    for (MeshBuilder& builder : builders) add_static_mesh(world, std::move(builder));
}

}  // namespace ff::cook
