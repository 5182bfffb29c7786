#include "tools/cook/assemble.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <glm/matrix.hpp>
#include <limits>

#include "engine/core/check.h"
#include "engine/core/jobs.h"
#include "engine/core/log.h"
#include "engine/core/stopwatch.h"
#include "engine/math/types.h"
#include "tools/cook/assemble_cells.h"
#include "tools/cook/assemble_materials.h"
#include "tools/cook/assemble_mesh.h"

namespace ff::cook {
namespace {

using scene::MeshSource;

constexpr std::size_t kTriangleGrain = 16384;

/// Placements by what becomes of them; each list in the source's order.
struct SortedPlacements {
    std::vector<std::uint32_t> merged, instanced, dynamic;
    std::vector<std::uint64_t> first_triangle;  // of each merged one in the numbering of all merged triangles; [n + 1]
};

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

Status check_placements(const WorldSource& source) {
    for (const Placement& placement : source.placements)
        if (triangle_count(source, placement) > 0) FF_TRY(check_placement(source, placement));
    return {};
}

/// Which placements keep a mesh of their own: dynamic ones, and instances unless merging is cheaper.
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

std::vector<bool> used_materials(const WorldSource& source) {
    std::vector<bool> mesh_used(source.meshes.size(), false), used(source.materials.size(), false);
    for (const Placement& placement : source.placements) mesh_used[placement.mesh] = true;
    for (std::size_t i = 0; i < source.meshes.size(); ++i)
        if (mesh_used[i])
            for (const std::uint16_t material : source.meshes[i].geometry.triangle_materials) used[material] = true;
    return used;
}

/// The geometry of one cell, or an empty mesh; sets `origin` to whole metres near its middle.
MeshSource gather_cell(const WorldSource& source, const SortedPlacements& sorted,
                       const std::vector<std::uint16_t>& material_ids, std::span<const CellEntry> entries,
                       const CellRange& cell, DVec3& origin, std::atomic<std::uint64_t>& dropped) {
    const auto slot_of = [&](std::uint64_t id) {
        const auto after = std::upper_bound(sorted.first_triangle.begin(), sorted.first_triangle.end(), id);
        return static_cast<std::size_t>(after - sorted.first_triangle.begin() - 1);
    };
    std::size_t slot = 0;
    bool first = true;
    origin = {std::round(cell.x), 0.0, std::round(cell.z)};
    MeshGatherer gatherer(origin);
    for (const CellEntry& entry : entries) {
        if (entry.id >= sorted.first_triangle.back()) continue;  // an instance
        if (first || entry.id < sorted.first_triangle[slot] || entry.id >= sorted.first_triangle[slot + 1]) {
            slot = slot_of(entry.id);
            const Placement& placement = source.placements[sorted.merged[slot]];
            if (first) {  // the height of its first triangle is near enough for single precision
                const MeshSource& mesh = source.meshes[placement.mesh].geometry;
                const std::size_t corner = 3 * (entry.id - sorted.first_triangle[slot]);
                const DVec3 p = DMat3(placement.world_from_mesh) * DVec3(mesh.positions[mesh.indices[corner]]);
                origin.y = std::round(p.y + placement.position.y);
                gatherer = MeshGatherer(origin);
                first = false;
            }
            gatherer.place(placement.position, placement.world_from_mesh);
        }
        const MeshSource& mesh = source.meshes[source.placements[sorted.merged[slot]].mesh].geometry;
        const auto triangle = static_cast<std::uint32_t>(entry.id - sorted.first_triangle[slot]);
        if (!gatherer.add(mesh, triangle, material_ids[mesh.triangle_materials[triangle]])) ++dropped;
    }
    return gatherer.take();
}

/// A mesh that keeps its own space: for instances and dynamic objects.
MeshSource gather_whole(const MeshSource& mesh, const std::vector<std::uint16_t>& material_ids,
                        std::atomic<std::uint64_t>& dropped) {
    MeshGatherer gatherer(DVec3(0.0));
    for (std::uint32_t t = 0; t < mesh.triangle_materials.size(); ++t)
        if (!gatherer.add(mesh, t, material_ids[mesh.triangle_materials[t]])) ++dropped;
    return gatherer.take();
}

/// Appends prepared meshes in order, giving each one's memory back as it goes.
void add_meshes(std::vector<scene::PreparedMesh> prepared, scene::SceneData& out) {
    std::size_t vertices = 0, triangles = 0, nodes = 0, leaves = 0;
    for (const scene::PreparedMesh& mesh : prepared) {
        vertices += mesh.geometry.positions.size();
        triangles += mesh.geometry.triangle_materials.size();
        nodes += mesh.nodes.size();
        leaves += mesh.leaves.size();
    }
    out.positions.reserve(vertices);
    out.attributes.reserve(vertices);
    out.indices.reserve(3 * triangles);
    out.triangle_materials.reserve(triangles);
    out.mesh_nodes.reserve(nodes);
    out.mesh_leaves.reserve(leaves);
    for (scene::PreparedMesh& mesh : prepared) out.add_mesh(std::exchange(mesh, {}));
}

scene::WorldInfo world_info(const WorldSource& source) {
    scene::WorldInfo info{.name = source.name,
                          .spawn_position = source.spawn_position,
                          .spawn_yaw = radians_of(source.spawn_yaw_deg),
                          .dynamic_instances = {},
                          .walks = {},
                          .source_bytes = source.bytes_in};
    for (const SourceWalk& walk : source.walks) {
        scene::Walk& out = info.walks.emplace_back();
        out.name = walk.name;
        out.fov_deg = walk.fov_deg;
        out.rate_hz = walk.rate_hz;
        for (const WalkFrame& frame : walk.frames)
            out.frames.push_back({frame.position, frame.yaw_deg, frame.pitch_deg, frame.roll_deg});
    }
    return info;
}

}  // namespace

Result<Assembly> assemble(WorldSource source, const AssembleSettings& settings, CookContext& context) {
    Assembly assembly;
    Stopwatch stage;
    const auto end_stage = [&](const char* name) {
        assembly.stages.push_back({name, stage.seconds()});
        stage.restart();
    };
    scene::SceneData& out = assembly.scene;
    assembly.info = world_info(source);
    out.environment = source.environment;
    out.environment.panorama = {};
    out.sky_panorama = std::move(source.sky_panorama);
    FF_TRY(check_placements(source));
    const std::uint64_t repeated = drop_repeated_placements(source);
    const std::vector<bool> whole = find_whole_placements(source, settings);
    assembly.coincident = resolve_coincident_surfaces(source, whole);
    assembly.coincident.dropped_placements = repeated;
    if (!assembly.coincident.complete)
        context.warn(fmt::format("{}: too many triangles in one plane; some were not told apart", source.name));
    end_stage("coincident");
    FF_ASSIGN(const SortedPlacements sorted, sort_placements(source, whole));
    const std::vector<std::uint16_t> material_ids = add_materials(source, used_materials(source), out);
    source.textures = {};
    end_stage("mip-map textures");

    const CellGrid grid(settings.largest_cell_m, settings.smallest_cell_m);
    FF_ASSIGN(std::vector<CellEntry> entries, make_entries(source, sorted, grid));
    const std::vector<CellRange> cells = grid.divide(entries, settings.cell_triangles);
    end_stage("divide into cells");

    // Cells' meshes first, then those of instances and dynamic objects: slots of one array, filled in any order.
    std::vector<std::uint32_t> whole_meshes;
    for (const auto* list : {&sorted.instanced, &sorted.dynamic})
        for (const std::uint32_t placement : *list) whole_meshes.push_back(source.placements[placement].mesh);
    std::sort(whole_meshes.begin(), whole_meshes.end());
    whole_meshes.erase(std::unique(whole_meshes.begin(), whole_meshes.end()), whole_meshes.end());
    std::vector<scene::PreparedMesh> prepared(cells.size() + whole_meshes.size());
    std::vector<DVec3> origins(cells.size());
    std::atomic<std::uint64_t> dropped = 0;
    {
        Progress progress("preparing meshes", prepared.size());
        parallel_for(prepared.size(), [&](std::size_t i) {
            MeshSource mesh =
                i < cells.size()
                    ? gather_cell(source, sorted, material_ids,
                                  std::span(entries).subspan(cells[i].begin, cells[i].end - cells[i].begin), cells[i],
                                  origins[i], dropped)
                    : gather_whole(source.meshes[whole_meshes[i - cells.size()]].geometry, material_ids, dropped);
            if (!mesh.triangle_materials.empty())
                prepared[i] = prepare_mesh_cached(std::move(mesh), out.materials, context.cache());
            progress.advance();
        });
    }
    source.meshes = {};
    assembly.dropped_triangles = dropped;
    end_stage("prepare meshes");

    // Slots that came out empty (all degenerate, or a cell of instances alone) get no mesh.
    constexpr std::uint32_t kNone = ~0u;
    std::vector<std::uint32_t> mesh_ids(prepared.size(), kNone);
    std::uint32_t mesh_count = 0;
    for (std::size_t i = 0; i < prepared.size(); ++i)
        if (!prepared[i].geometry.triangle_materials.empty()) mesh_ids[i] = mesh_count++;
    std::erase_if(prepared, [](const scene::PreparedMesh& mesh) { return mesh.geometry.triangle_materials.empty(); });
    add_meshes(std::move(prepared), out);
    const auto whole_mesh_id = [&](std::uint32_t mesh) {
        const auto at = std::lower_bound(whole_meshes.begin(), whole_meshes.end(), mesh) - whole_meshes.begin();
        return mesh_ids[cells.size() + static_cast<std::size_t>(at)];
    };

    for (std::size_t c = 0; c < cells.size(); ++c) {
        const auto cell = static_cast<std::uint32_t>(c);
        if (mesh_ids[c] != kNone) out.add_instance(mesh_ids[c], origins[c], Mat3(1.0f), cell);
        for (std::size_t e = cells[c].begin; e < cells[c].end; ++e) {
            if (entries[e].id < sorted.first_triangle.back()) continue;
            const std::size_t instance = entries[e].id - sorted.first_triangle.back();
            const Placement& placement = source.placements[sorted.instanced[instance]];
            const std::uint32_t mesh = whole_mesh_id(placement.mesh);
            if (mesh != kNone) out.add_instance(mesh, placement.position, placement.world_from_mesh, cell);
        }
    }
    for (const std::uint32_t index : sorted.dynamic) {
        const Placement& placement = source.placements[index];
        const std::uint32_t mesh = whole_mesh_id(placement.mesh);
        if (mesh != kNone)
            assembly.info.dynamic_instances.push_back({mesh, placement.position, placement.world_from_mesh});
    }
    entries = {};
    end_stage("join");
    out.finish(settings.height_grid_size);
    end_stage("finish scene");
    return assembly;
}

}  // namespace ff::cook
