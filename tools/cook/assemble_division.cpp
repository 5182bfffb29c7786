#include "tools/cook/assemble_division.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <glm/matrix.hpp>
#include <limits>

#include "engine/core/jobs.h"
#include "engine/core/log.h"
#include "tools/cook/cook_bytes.h"

namespace ff::cook {
namespace {

using scene::MeshSource;

constexpr std::size_t kTriangleGrain = 16384;

std::size_t triangle_count(const WorldSource& source, const Placement& placement) {
    return source.meshes[placement.mesh].geometry.triangle_materials.size();
}

Status check_placement(const WorldSource& source, const Placement& placement) {
    bool good = true;
    for (int i = 0; i < 3; ++i) {
        good = good && std::abs(placement.position[i]) <= scene::kMaxWorldCoordinate;
        for (int j = 0; j < 3; ++j) good = good && std::isfinite(placement.world_from_mesh[i][j]);
    }
    if (good && glm::determinant(DMat3(placement.world_from_mesh)) != 0.0) return {};
    return bad_input(fmt::format("{}: placed at ({}, {}, {}); expected within {} m of the origin, with a scale",
                                 source.meshes[placement.mesh].name, placement.position.x, placement.position.y,
                                 placement.position.z, scene::kMaxWorldCoordinate));
}

}  // namespace

Status check_placements(const WorldSource& source) {
    for (const Placement& placement : source.placements)
        if (triangle_count(source, placement) > 0) FF_TRY(check_placement(source, placement));
    return {};
}

std::vector<bool> find_whole_placements(const WorldSource& source, const AssembleSettings& settings) {
    std::vector<std::uint32_t> uses(source.meshes.size(), 0);
    for (const Placement& placement : source.placements)
        if (placement.kind != PlacementKind::merge) ++uses[placement.mesh];
    std::vector<bool> whole;
    for (const Placement& placement : source.placements) {
        const bool merge_anyway =
            uses[placement.mesh] == 1 || (triangle_count(source, placement) < settings.merge_instances_below &&
                                          uses[placement.mesh] <= settings.merge_uses_up_to);
        whole.push_back(placement.kind == PlacementKind::dynamic ||
                        (placement.kind == PlacementKind::instance && !merge_anyway));
    }
    return whole;
}

Result<SortedPlacements> sort_placements(const WorldSource& source, const std::vector<bool>& whole) {
    SortedPlacements sorted;
    std::uint64_t triangles = 0;
    for (std::size_t i = 0; i < source.placements.size(); ++i) {
        const Placement& placement = source.placements[i];
        const std::size_t count = triangle_count(source, placement);
        if (count == 0) continue;
        if (placement.kind == PlacementKind::dynamic) {
            sorted.dynamic.push_back(static_cast<std::uint32_t>(i));
        } else if (whole[i]) {
            sorted.instanced.push_back(static_cast<std::uint32_t>(i));
        } else {
            sorted.merged.push_back(static_cast<std::uint32_t>(i));
            sorted.first_triangle.push_back(triangles);
            triangles += count;
        }
    }
    sorted.first_triangle.push_back(triangles);
    // Entry ids and the scene's triangle ids are 32 bits.
    if (triangles + sorted.instanced.size() >= std::numeric_limits<std::uint32_t>::max() / 3)
        return bad_input(fmt::format("{}: {} triangles; expected fewer than 1.4 billion", source.name, triangles));
    return sorted;
}

namespace {

/// Entries for the quadtree: every merged triangle at its centroid, then every instance at its mesh's middle.
Result<std::vector<CellEntry>> make_entries(const WorldSource& source, const SortedPlacements& sorted,
                                            const CellGrid& grid) {
    const std::uint64_t triangles = sorted.first_triangle.back();
    std::vector<CellEntry> entries(triangles + sorted.instanced.size());
    std::atomic<std::uint64_t> first_outside = ~0ull;  // the least: the same message for any number of workers
    Progress progress("sorting triangles into cells", triangles);
    parallel_ranges(triangles, kTriangleGrain, [&](std::size_t begin, std::size_t end) {
        auto slot = static_cast<std::size_t>(
            std::upper_bound(sorted.first_triangle.begin(), sorted.first_triangle.end(), begin) -
            sorted.first_triangle.begin() - 1);
        for (std::size_t i = begin; i < end; ++i) {
            while (i >= sorted.first_triangle[slot + 1]) ++slot;
            const Placement& placement = source.placements[sorted.merged[slot]];
            const MeshSource& mesh = source.meshes[placement.mesh].geometry;
            const std::size_t corner = 3 * (i - sorted.first_triangle[slot]);
            const DVec3 sum = DVec3(mesh.positions[mesh.indices[corner]]) +
                              DVec3(mesh.positions[mesh.indices[corner + 1]]) +
                              DVec3(mesh.positions[mesh.indices[corner + 2]]);
            const DVec3 centroid = DMat3(placement.world_from_mesh) * (sum / 3.0) + placement.position;
            const bool inside = std::abs(centroid.x) <= scene::kMaxWorldCoordinate &&
                                std::abs(centroid.y) <= scene::kMaxWorldCoordinate &&
                                std::abs(centroid.z) <= scene::kMaxWorldCoordinate;
            if (!inside) {
                std::uint64_t least = first_outside;
                while (i < least && !first_outside.compare_exchange_weak(least, i)) {
                }
                continue;
            }
            entries[i] = {.square = grid.square_of(centroid.x, centroid.z), .id = static_cast<std::uint32_t>(i)};
        }
        progress.advance(end - begin);
    });
    if (const std::uint64_t i = first_outside; i != ~0ull) {
        const auto after = std::upper_bound(sorted.first_triangle.begin(), sorted.first_triangle.end(), i);
        const auto slot = static_cast<std::size_t>(after - sorted.first_triangle.begin() - 1);
        const Placement& placement = source.placements[sorted.merged[slot]];
        return bad_input(fmt::format("{}: triangle {}: too far away; expected within {} m of the origin",
                                     source.meshes[placement.mesh].name, i - sorted.first_triangle[slot],
                                     scene::kMaxWorldCoordinate));
    }
    std::vector<Vec3> middles(source.meshes.size(), Vec3(std::numeric_limits<float>::quiet_NaN()));
    for (std::size_t i = 0; i < sorted.instanced.size(); ++i) {
        const Placement& placement = source.placements[sorted.instanced[i]];
        Vec3& middle = middles[placement.mesh];
        if (std::isnan(middle.x)) {
            Box3 box;
            for (const Vec3& p : source.meshes[placement.mesh].geometry.positions) box.add(p);
            middle = box.center();
        }
        const DVec3 at = DMat3(placement.world_from_mesh) * DVec3(middle) + placement.position;
        if (!(std::abs(at.x) <= scene::kMaxWorldCoordinate && std::abs(at.z) <= scene::kMaxWorldCoordinate))
            return bad_input(fmt::format("{}: instance {}: too far away; expected within {} m of the origin",
                                         source.meshes[placement.mesh].name, i, scene::kMaxWorldCoordinate));
        entries[triangles + i] = {.square = grid.square_of(at.x, at.z),
                                  .id = static_cast<std::uint32_t>(triangles + i),
                                  .weight = static_cast<std::uint32_t>(triangle_count(source, placement))};
    }
    return entries;
}

// Bump when make_entries or CellGrid::divide give something else for the same input.
constexpr const char* kStep = "cells 1";

}  // namespace

Result<CellDivision> divide_into_cells(const WorldSource& source, const SortedPlacements& sorted,
                                       const AssembleSettings& settings, const std::string& geometry,
                                       CookCache& cache) {
    CellDivision division;
    const CacheKey key = CacheKey(kStep)
                             .add(geometry)
                             .add_value(settings.largest_cell_m)
                             .add_value(settings.smallest_cell_m)
                             .add_value(settings.cell_triangles)
                             .add_value(settings.merge_instances_below)
                             .add_value(settings.merge_uses_up_to);
    if (const auto found = cache.find(key)) {
        ByteReader in(*found);
        in.array(division.ids);
        in.array(division.cells);
        return division;
    }
    const CellGrid grid(settings.largest_cell_m, settings.smallest_cell_m);
    FF_ASSIGN(std::vector<CellEntry> entries, make_entries(source, sorted, grid));
    division.cells = grid.divide(entries, settings.cell_triangles);
    division.ids.resize(entries.size());
    std::transform(entries.begin(), entries.end(), division.ids.begin(), [](const CellEntry& e) { return e.id; });
    if (cache.enabled()) {
        ByteWriter out;
        out.array(division.ids);
        out.array(division.cells);
        cache.store(key, out.bytes());
    }
    return division;
}

}  // namespace ff::cook
