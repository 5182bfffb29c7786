#include "engine/nearfield/draw_list.h"

#include <algorithm>
#include <cmath>
#include <ranges>

#include "engine/core/check.h"

namespace ff::nearfield {
namespace {

const scene::Instance& instance_of(const scene::StaticScene& scene, const DrawSet& set, std::uint32_t id) {
    if (id < scene.instances.size()) return scene.instances[id];
    FF_CHECK(id - scene.instances.size() < set.dynamic.size(), "instance {} of {} static and {} dynamic", id,
             scene.instances.size(), set.dynamic.size());
    return set.dynamic[id - scene.instances.size()];
}

InstanceRecord make_record(const scene::Instance& instance, std::uint32_t id, const WorldPos& camera) {
    InstanceRecord record;
    const Vec3 translation = Vec3(instance.position - camera);  // subtracted in double, then rounded once
    for (int r = 0; r < 3; ++r) {
        for (int c = 0; c < 3; ++c) record.relative_from_mesh[r][c] = instance.world_from_mesh[c][r];
        record.relative_from_mesh[r][3] = translation[r];
    }
    record.instance = id;
    return record;
}

/// Records of the set, those of one mesh together; meshes in the order in which the set first names them.
void group_by_mesh(const scene::StaticScene& scene, const DrawSet& set, const WorldPos& camera, DrawList& out) {
    out.batches.clear();
    out.commands.clear();
    out.blended.clear();
    out.mesh_order.clear();
    out.triangle_count = 0;
    out.mesh_count.assign(scene.meshes.size(), 0);
    out.mesh_first_record.resize(scene.meshes.size());
    for (std::uint32_t id : set.instances) {
        const std::uint32_t mesh = instance_of(scene, set, id).mesh;
        if (out.mesh_count[mesh]++ == 0) out.mesh_order.push_back(mesh);
    }
    std::uint32_t next = 0;
    for (std::uint32_t mesh : out.mesh_order) {
        out.mesh_first_record[mesh] = next;
        next += out.mesh_count[mesh];
    }
    out.records.resize(set.instances.size());
    for (std::uint32_t id : set.instances) {
        const scene::Instance& instance = instance_of(scene, set, id);
        out.records[out.mesh_first_record[instance.mesh]++] = make_record(instance, id, camera);
    }
    for (std::uint32_t mesh : out.mesh_order) out.mesh_first_record[mesh] -= out.mesh_count[mesh];
}

DrawCommand make_command(const scene::Mesh& mesh, std::uint32_t first_triangle, std::uint32_t triangle_count,
                         std::uint32_t first_record, std::uint32_t record_count) {
    return {.index_count = 3 * triangle_count,
            .instance_count = record_count,
            .first_index = 3 * (mesh.first_triangle + first_triangle),
            .base_vertex = std::int32_t(mesh.first_vertex),
            .base_instance = first_record};
}

/// A batch for each material that has commands (out.material_commands), and room for them behind those already there.
void make_batches(std::ranges::input_range auto&& materials, DrawList& out) {
    out.material_next.assign(out.material_commands.size(), 0);
    auto next = std::uint32_t(out.commands.size());
    for (const std::uint32_t material : materials) {
        const std::uint32_t count = out.material_commands[material];
        if (count == 0) continue;
        out.material_next[material] = next;
        out.batches.push_back({.material = material, .first_command = next, .command_count = count});
        next += count;
    }
    out.commands.resize(next);
}

float distance_of(const InstanceRecord& record, const scene::Mesh& mesh) {
    const Vec3 c = mesh.bounds.center();
    Vec3 p;
    for (int r = 0; r < 3; ++r) {
        const float* row = record.relative_from_mesh[r];
        p[r] = row[0] * c.x + row[1] * c.y + row[2] * c.z + row[3];
    }
    return std::sqrt(p.x * p.x + p.y * p.y + p.z * p.z);
}

}  // namespace

void make_shaded_draw_list(const scene::StaticScene& scene, const SceneLayout& layout, const DrawSet& set,
                           const WorldPos& camera, std::span<const std::uint32_t> draw_order, DrawList& out) {
    group_by_mesh(scene, set, camera, out);

    // Counting sort of the commands by material.
    out.material_commands.assign(scene.materials.size(), 0);
    const auto groups_of = [&](std::uint32_t mesh) {
        return std::span(layout.groups).subspan(layout.meshes[mesh].first_group, layout.meshes[mesh].group_count);
    };
    for (std::uint32_t mesh : out.mesh_order) {
        for (const MaterialGroup& group : groups_of(mesh)) {
            out.triangle_count += std::uint64_t(group.triangle_count) * out.mesh_count[mesh];
            if (layer_of(scene.materials[group.material]) != MaterialLayer::blended)
                ++out.material_commands[group.material];
        }
    }
    make_batches(draw_order, out);
    for (std::uint32_t mesh : out.mesh_order) {
        const MeshLayout& mesh_layout = layout.meshes[mesh];
        const std::uint32_t first_record = out.mesh_first_record[mesh], record_count = out.mesh_count[mesh];
        for (std::uint32_t g = 0; g < mesh_layout.group_count; ++g) {
            const MaterialGroup& group = layout.groups[mesh_layout.first_group + g];
            if (layer_of(scene.materials[group.material]) == MaterialLayer::blended) {
                for (std::uint32_t r = first_record; r < first_record + record_count; ++r)
                    out.blended.push_back({.record = r,
                                           .group = mesh_layout.first_group + g,
                                           .mesh = mesh,
                                           .distance_m = distance_of(out.records[r], scene.meshes[mesh])});
            } else {
                out.commands[out.material_next[group.material]++] = make_command(
                    scene.meshes[mesh], group.first_triangle, group.triangle_count, first_record, record_count);
            }
        }
    }
    // Record and group break ties, so that the picture is the same every time.
    std::sort(out.blended.begin(), out.blended.end(), [](const BlendedDraw& a, const BlendedDraw& b) {
        if (a.distance_m != b.distance_m) return a.distance_m > b.distance_m;
        return a.record != b.record ? a.record < b.record : a.group < b.group;
    });
}

void make_id_draw_list(const scene::StaticScene& scene, const SceneLayout& layout, const DrawSet& set,
                       const WorldPos& camera, DrawList& out) {
    group_by_mesh(scene, set, camera, out);

    for (std::uint32_t mesh : out.mesh_order) {
        const std::uint32_t opaque = layout.meshes[mesh].opaque_triangle_count;
        if (opaque == 0) continue;
        out.commands.push_back(
            make_command(scene.meshes[mesh], 0, opaque, out.mesh_first_record[mesh], out.mesh_count[mesh]));
        out.triangle_count += std::uint64_t(opaque) * out.mesh_count[mesh];
    }
    if (!out.commands.empty()) out.batches.push_back({.command_count = std::uint32_t(out.commands.size())});

    // Ranges that start within a mesh need records of their own: the shader counts triangles from the range's start.
    out.material_commands.assign(scene.materials.size(), 0);
    for (std::uint32_t mesh : out.mesh_order) {
        const MeshLayout& mesh_layout = layout.meshes[mesh];
        for (std::uint32_t g = mesh_layout.opaque_group_count; g < mesh_layout.group_count; ++g)
            ++out.material_commands[layout.groups[mesh_layout.first_group + g].material];
    }
    make_batches(std::views::iota(0u, std::uint32_t(scene.materials.size())), out);
    for (std::uint32_t mesh : out.mesh_order) {
        const MeshLayout& mesh_layout = layout.meshes[mesh];
        const std::uint32_t count = out.mesh_count[mesh];
        for (std::uint32_t r = 0; r < count; ++r)
            out.records[out.mesh_first_record[mesh] + r].first_name = mesh_layout.first_reordered;
        for (std::uint32_t g = mesh_layout.opaque_group_count; g < mesh_layout.group_count; ++g) {
            const MaterialGroup& group = layout.groups[mesh_layout.first_group + g];
            auto first_record = out.mesh_first_record[mesh];
            if (group.first_triangle != 0) {
                first_record = std::uint32_t(out.records.size());
                for (std::uint32_t r = 0; r < count; ++r) {
                    InstanceRecord record = out.records[out.mesh_first_record[mesh] + r];
                    record.first_triangle = group.first_triangle;
                    out.records.push_back(record);
                }
            }
            out.commands[out.material_next[group.material]++] =
                make_command(scene.meshes[mesh], group.first_triangle, group.triangle_count, first_record, count);
            out.triangle_count += std::uint64_t(group.triangle_count) * count;
        }
    }
}

}  // namespace ff::nearfield
