#include "tools/cook/assemble_gather.h"

#include <algorithm>
#include <cmath>

#include "engine/core/hash.h"
#include "tools/cook/cook_bytes.h"

namespace ff::cook {

using scene::MeshSource;

Gatherer::Gatherer(WorldSource& source, const SortedPlacements& sorted, const CellDivision& division,
                   std::span<const std::uint16_t> material_ids, std::span<const std::uint32_t> instanced_meshes)
    : source_(source),
      sorted_(sorted),
      division_(division),
      material_ids_(material_ids),
      uses_left_(source.meshes.size()) {
    for (const std::uint32_t placement : sorted.merged) {
        const std::uint32_t mesh = source.placements[placement].mesh;
        uses_left_[mesh] += source.meshes[mesh].geometry.triangle_materials.size();
    }
    for (const std::uint32_t mesh : instanced_meshes) ++uses_left_[mesh];
    for (std::uint32_t mesh = 0; mesh < source.meshes.size(); ++mesh)
        if (uses_left_[mesh] == 0) free_mesh(mesh);
}

CellPlan Gatherer::plan(const CellRange& cell) const {
    CellPlan plan;
    plan.origin = {std::round(cell.x), 0.0, std::round(cell.z)};
    std::size_t slot = 0;
    for (std::size_t i = cell.begin; i < cell.end; ++i) {
        const std::uint32_t id = division_.ids[i];
        if (id >= sorted_.first_triangle.back()) continue;  // an instance
        if (!plan.runs.empty() && plan.runs.back().end == i && id >= sorted_.first_triangle[slot] &&
            id < sorted_.first_triangle[slot + 1]) {
            plan.runs.back().end = i + 1;
            continue;
        }
        const auto after = std::upper_bound(sorted_.first_triangle.begin(), sorted_.first_triangle.end(), id);
        slot = static_cast<std::size_t>(after - sorted_.first_triangle.begin() - 1);
        const auto first = static_cast<std::uint32_t>(sorted_.first_triangle[slot]);
        const Placement& placement = source_.placements[sorted_.merged[slot]];
        if (plan.runs.empty()) {  // the height of its first triangle is near enough for single precision
            const MeshSource& mesh = source_.meshes[placement.mesh].geometry;
            const Vec3& corner = mesh.positions[mesh.indices[3 * std::size_t{id - first}]];
            const DVec3 p = DMat3(placement.world_from_mesh) * DVec3(corner);
            plan.origin.y = std::round(p.y + placement.position.y);
        }
        plan.runs.push_back({sorted_.merged[slot], first, i, i + 1});
    }
    return plan;
}

std::string Gatherer::inputs(const CellPlan& cell) const {
    ByteWriter parts;
    std::vector<std::uint32_t> triangles;
    for (const CellPlan::Run& run : cell.runs) {
        const Placement& placement = source_.placements[run.placement];
        parts.text(source_.meshes[placement.mesh].content_hash);
        parts.value(placement.position - cell.origin);
        parts.value(placement.world_from_mesh);
        parts.value(std::uint64_t{run.end - run.begin});
        for (std::size_t i = run.begin; i < run.end; ++i) triangles.push_back(division_.ids[i] - run.first_triangle);
    }
    parts.array(triangles);
    return content_hash_hex(parts.bytes());
}

GatheredMesh Gatherer::gather(const CellPlan& cell) const {
    GatheredMesh gathered;
    MeshGatherer gatherer(cell.origin);
    for (const CellPlan::Run& run : cell.runs) {
        const Placement& placement = source_.placements[run.placement];
        const MeshSource& mesh = source_.meshes[placement.mesh].geometry;
        gatherer.place(placement.position, placement.world_from_mesh);
        for (std::size_t i = run.begin; i < run.end; ++i) {
            const std::uint32_t triangle = division_.ids[i] - run.first_triangle;
            if (!gatherer.add(mesh, triangle, material_ids_[mesh.triangle_materials[triangle]]))
                ++gathered.dropped_triangles;
        }
    }
    gathered.geometry = gatherer.take();
    return gathered;
}

GatheredMesh Gatherer::gather_whole(std::uint32_t id) const {
    const MeshSource& mesh = source_.meshes[id].geometry;
    GatheredMesh gathered;
    MeshGatherer gatherer(DVec3(0.0));
    for (std::uint32_t t = 0; t < mesh.triangle_materials.size(); ++t)
        if (!gatherer.add(mesh, t, material_ids_[mesh.triangle_materials[t]])) ++gathered.dropped_triangles;
    gathered.geometry = gatherer.take();
    return gathered;
}

void Gatherer::release(const CellPlan& cell) {
    for (const CellPlan::Run& run : cell.runs) use_up(source_.placements[run.placement].mesh, run.end - run.begin);
}

void Gatherer::use_up(std::uint32_t mesh, std::uint64_t uses) {
    if (uses_left_[mesh].fetch_sub(uses) == uses) free_mesh(mesh);
}

void Gatherer::free_mesh(std::uint32_t mesh) {
    MeshSource& geometry = source_.meshes[mesh].geometry;
    const std::uint64_t bytes = geometry.positions.size() * 28 + geometry.triangle_materials.size() * 14;
    geometry = {};
    freed_.add(bytes);
}

}  // namespace ff::cook
