#include "tools/cook/assemble.h"

#include <algorithm>
#include <atomic>
#include <functional>
#include <utility>

#include "engine/core/jobs.h"
#include "engine/core/log.h"
#include "engine/math/types.h"
#include "tools/cook/assemble_animation.h"
#include "tools/cook/assemble_division.h"
#include "tools/cook/assemble_gather.h"
#include "tools/cook/assemble_heights.h"
#include "tools/cook/assemble_materials.h"
#include "tools/cook/assemble_mesh.h"
#include "tools/cook/free_memory.h"
#include "tools/cook/geometry_hash.h"

namespace ff::cook {
namespace {

std::vector<bool> used_materials(const WorldSource& source) {
    std::vector<bool> mesh_used(source.meshes.size(), false), used(source.materials.size(), false);
    for (const Placement& placement : source.placements) mesh_used[placement.mesh] = true;
    for (const scene::AnimatedModel& model : source.animation.models) {
        for (const scene::RigidPart& part : model.parts) mesh_used[part.mesh] = true;
        for (const scene::Skin& skin : model.skins) mesh_used[skin.mesh] = true;
    }
    for (std::size_t i = 0; i < source.meshes.size(); ++i)
        if (mesh_used[i])
            for (const std::uint16_t material : source.meshes[i].geometry.triangle_materials) used[material] = true;
    return used;
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
    FreedMemory freed;
    for (scene::PreparedMesh& mesh : prepared) {
        const std::uint64_t bytes = mesh.leaves.size() * sizeof(scene::BvhLeaf) + mesh.geometry.positions.size() * 28;
        out.add_mesh(std::exchange(mesh, {}));
        freed.add(bytes);
    }
}

scene::WorldInfo world_info(const WorldSource& source) {
    scene::WorldInfo info{.name = source.name,
                          .spawn_position = source.spawn_position,
                          .spawn_yaw = radians_of(source.spawn_yaw_deg),
                          .dynamic_instances = {},
                          .places = {},
                          .walks = {},
                          .source_bytes = source.bytes_in};
    info.sounds = source.sounds;
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

/// @param moving_placements  the placement of each dynamic instance, ascending
void add_places(const WorldSource& source, std::span<const std::size_t> moving_placements, scene::WorldInfo& info) {
    const auto instances_before = [&](std::size_t placement) {
        return std::uint32_t(std::lower_bound(moving_placements.begin(), moving_placements.end(), placement) -
                             moving_placements.begin());
    };
    for (const SourcePlace& place : source.places) {
        const std::uint32_t first = instances_before(place.first_placement);
        const std::uint32_t end = instances_before(place.first_placement + place.placement_count);
        const scene::MovingModel model{.position = place.position,
                                       .yaw = radians_of(place.yaw_deg),
                                       .first_instance = end > first ? first : 0,
                                       .instance_count = end - first,
                                       .first_animated = place.first_animated,
                                       .animated_count = place.animated_count};
        if (!place.name.empty()) info.places.push_back({model, place.name});
        if (place.flock > 0) info.flocks.push_back({model, place.flock, place.flock_radius_m});
        if (place.mass_kg > 0.0f) info.loose_bodies.push_back({model, place.mass_kg});
    }
}

}  // namespace

Result<Assembly> assemble(WorldSource source, const AssembleSettings& settings, CookContext& context) {
    Assembly assembly;
    scene::SceneData& out = assembly.scene;
    assembly.info = world_info(source);
    out.environment = source.environment;
    out.environment.panorama = {};
    out.sky_panorama = std::move(source.sky_panorama);
    out.lamps = source.lamps;
    FF_TRY(check_placements(source));
    const std::uint64_t repeated = drop_repeated_placements(source);
    const std::vector<bool> whole = find_whole_placements(source, settings);
    assembly.coincident = resolve_coincident_surfaces(source, whole);
    assembly.coincident.dropped_placements = repeated;
    if (!assembly.coincident.complete)
        context.warn(fmt::format("{}: too many triangles in one plane; some were not told apart", source.name));
    context.end_stage("coincident");
    FF_ASSIGN(const SortedPlacements sorted, sort_placements(source, whole));
    const std::vector<std::uint16_t> material_ids = add_materials(source, used_materials(source), out);
    source.textures = {};
    AnimationAssembly animation(source);
    context.end_stage("mip-map textures");

    const bool is_cached = context.cache().enabled();
    const std::string geometry = is_cached ? hash_geometry(source) : std::string();
    FF_ASSIGN(const CellDivision division, divide_into_cells(source, sorted, settings, geometry, context.cache()));
    const std::vector<CellRange>& cells = division.cells;
    context.end_stage("divide into cells");

    // Cells' meshes first, then those of instances and dynamic objects: slots of one array, filled in any order.
    std::vector<std::uint32_t> whole_meshes;
    for (const auto* list : {&sorted.instanced, &sorted.dynamic})
        for (const std::uint32_t placement : *list) whole_meshes.push_back(source.placements[placement].mesh);
    whole_meshes.insert(whole_meshes.end(), animation.meshes().begin(), animation.meshes().end());
    std::sort(whole_meshes.begin(), whole_meshes.end());
    whole_meshes.erase(std::unique(whole_meshes.begin(), whole_meshes.end()), whole_meshes.end());
    std::vector<scene::PreparedMesh> prepared(cells.size() + whole_meshes.size());
    std::vector<DVec3> origins(cells.size());
    std::vector<std::string> keys(prepared.size());
    std::atomic<std::uint64_t> dropped = 0;
    {
        Gatherer gatherer(source, sorted, division, material_ids, whole_meshes);
        const std::string materials = hash_materials(material_ids, out.materials);
        const auto prepare = [&](std::size_t i, const auto& inputs, const auto& gather) {
            const CacheKey key = prepared_mesh_key(materials, is_cached ? inputs() : std::string());
            CookedMesh cooked = prepare_mesh_cached(key, gather, out.materials, context.cache());
            dropped += cooked.dropped_triangles;
            prepared[i] = std::move(cooked.mesh);
            keys[i] = key.hex();
        };
        Progress progress("preparing meshes", prepared.size());
        parallel_for(prepared.size(), [&](std::size_t i) {
            if (i < cells.size()) {
                const CellPlan cell = gatherer.plan(cells[i]);
                origins[i] = cell.origin;
                if (cell.runs.empty()) return progress.advance();  // instances alone
                prepare(
                    i, [&] { return gatherer.inputs(cell); }, [&] { return gatherer.gather(cell); });
                gatherer.release(cell);
            } else {
                const std::uint32_t mesh = whole_meshes[i - cells.size()];
                prepare(
                    i, [&] { return source.meshes[mesh].content_hash; }, [&] { return gatherer.gather_whole(mesh); });
                gatherer.release_whole(mesh);
            }
            progress.advance();
        });
    }
    source.meshes = {};
    assembly.dropped_triangles = dropped;
    context.end_stage("prepare meshes");

    // Slots that came out empty (all degenerate, or a cell of instances alone) get no mesh.
    constexpr std::uint32_t kNone = AnimationAssembly::kNone;
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
            if (division.ids[e] < sorted.first_triangle.back()) continue;
            const std::size_t instance = division.ids[e] - sorted.first_triangle.back();
            const Placement& placement = source.placements[sorted.instanced[instance]];
            const std::uint32_t mesh = whole_mesh_id(placement.mesh);
            if (mesh != kNone) out.add_instance(mesh, placement.position, placement.world_from_mesh, cell);
        }
    }
    std::vector<std::size_t> moving_placements;  // of each dynamic instance, ascending
    for (const std::uint32_t index : sorted.dynamic) {
        const Placement& placement = source.placements[index];
        const std::uint32_t mesh = whole_mesh_id(placement.mesh);
        if (mesh == kNone) continue;
        assembly.info.dynamic_instances.push_back({mesh, placement.position, placement.world_from_mesh});
        moving_placements.push_back(index);
    }
    add_places(source, moving_placements, assembly.info);
    assembly.info.animation = animation.finish(whole_mesh_id, out);
    context.end_stage("join");
    out.finish(0);
    add_height_grid(settings.height_grid_size, geometry, keys, context.cache(), out);
    context.end_stage("finish scene");
    return assembly;
}

}  // namespace ff::cook
