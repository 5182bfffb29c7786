#include "tools/cook/gltf_import.h"

#include <fmt/format.h>

#include <algorithm>
#include <glm/geometric.hpp>
#include <optional>

#include "engine/core/jobs.h"
#include "engine/core/log.h"
#include "tools/cook/gltf_animated.h"
#include "tools/cook/gltf_append.h"
#include "tools/cook/gltf_material.h"
#include "tools/cook/gltf_mesh.h"
#include "tools/cook/gltf_nodes.h"
#include "tools/cook/gltf_validate.h"

namespace ff::cook {
namespace {

DBox3 bounds_of(const scene::MeshSource& mesh, const ModelPart& part) {
    DBox3 box;
    for (const Vec3& p : mesh.positions) box.add(part.model_from_mesh * DVec3(p) + part.position);
    return box;
}

// A mesh squeezed into a plane by its node: baked, as no instance may be singular.
scene::MeshSource flattened(const scene::MeshSource& mesh, const DMat3& m) {
    scene::MeshSource flat = mesh;
    // Normals go by the cofactor matrix, which is there for singular matrices too.
    const DMat3 cofactors(glm::cross(m[1], m[2]), glm::cross(m[2], m[0]), glm::cross(m[0], m[1]));
    for (std::size_t i = 0; i < flat.positions.size(); ++i) {
        flat.positions[i] = Vec3(m * DVec3(mesh.positions[i]));
        DVec3 normal = cofactors * DVec3(scene::decode_normal(mesh.attributes[i].normal_oct));
        if (!(glm::length(normal) > 0.0)) normal = cofactors[0] + cofactors[1] + cofactors[2];
        if (glm::length(normal) > 0.0)
            scene::encode_normal(Vec3(glm::normalize(normal)), flat.attributes[i].normal_oct);
    }
    return flat;
}

// Everything has been read; from here on nothing fails except for room.
Result<Model> append(const GltfFile& file, ImportedMaterials imported, std::vector<scene::MeshSource> meshes,
                     std::vector<std::size_t> gltf_meshes, const std::vector<NodeInstance>& nodes, WorldSource& into) {
    FF_ASSIGN(const std::vector<std::uint16_t> material_ids, append_materials(file, std::move(imported), meshes, into));
    Model model;
    model.name = std::filesystem::path(file.name).stem().string();
    const auto first_mesh = static_cast<std::uint32_t>(into.meshes.size());
    const auto distinct_count = static_cast<std::ptrdiff_t>(gltf_meshes.size());  // flattened ones follow
    for (const NodeInstance& node : nodes) {
        const auto found = std::lower_bound(gltf_meshes.begin(), gltf_meshes.begin() + distinct_count, node.mesh);
        auto slot = static_cast<std::size_t>(found - gltf_meshes.begin());
        if (meshes[slot].triangle_materials.empty()) continue;
        ModelPart part{.position = node.position, .model_from_mesh = node.model_from_mesh};
        if (node.is_flat) {
            meshes.push_back(flattened(meshes[slot], node.model_from_mesh));
            gltf_meshes.push_back(node.mesh);
            slot = meshes.size() - 1;
            part.model_from_mesh = DMat3(1.0);
        }
        part.mesh = first_mesh + static_cast<std::uint32_t>(slot);
        model.bounds.add(bounds_of(meshes[slot], part));
        model.triangle_count += meshes[slot].triangle_materials.size();
        model.parts.push_back(part);
    }
    std::vector<std::uint32_t> uses(meshes.size(), 0);
    for (const ModelPart& part : model.parts) ++uses[part.mesh - first_mesh];
    for (ModelPart& part : model.parts) part.use_count = uses[part.mesh - first_mesh];

    for (std::size_t i = 0; i < meshes.size(); ++i)
        append_mesh(fmt::format("{}: meshes[{}]", file.name, gltf_meshes[i]), std::move(meshes[i]), material_ids, into);
    into.bytes_in += file.bytes_read;
    return model;
}

Result<Model> import_checked(const std::filesystem::path& path, WorldSource& into, CookContext& context,
                             ModelKind kind) {
    FF_ASSIGN(GltfFile file, open_gltf(path, context));
    FF_TRY(validate_gltf(file, context));
    FF_TRY(load_buffers(file));
    FF_ASSIGN(const tinygltf::Model typed, parse_gltf(file));
    FF_ASSIGN(const GltfData data, open_views(file, typed));
    const auto has = [&](const char* key) { return file.json.contains(key) && !file.json.at(key).empty(); };
    if (kind == ModelKind::animated && (has("skins") || has("animations"))) {
        FF_ASSIGN(Model model, import_animated(file, data, into, context));
        return model;
    }
    if (has("skins"))
        context.warn(fmt::format("{}: has skins, and is not dynamic; meshes are drawn in their bind pose", file.name));
    if (has("animations"))
        context.warn(fmt::format("{}: has animations, and is not dynamic; it is drawn at rest", file.name));

    FF_ASSIGN(const std::vector<NodeInstance> nodes, flatten_nodes(data));
    std::vector<std::size_t> gltf_meshes;  // those that the scene shows, ascending
    for (const NodeInstance& node : nodes) gltf_meshes.push_back(node.mesh);
    std::sort(gltf_meshes.begin(), gltf_meshes.end());
    gltf_meshes.erase(std::unique(gltf_meshes.begin(), gltf_meshes.end()), gltf_meshes.end());

    FF_ASSIGN(ImportedMaterials materials, read_materials(file, data, context));
    std::vector<std::optional<Result<scene::MeshSource>>> read(gltf_meshes.size());
    Progress progress("reading meshes", gltf_meshes.size());
    parallel_for(gltf_meshes.size(), [&](std::size_t i) {
        read[i].emplace(read_mesh(data, gltf_meshes[i], materials, context));
        progress.advance();
    });
    std::vector<scene::MeshSource> meshes;
    for (auto& mesh : read) {
        if (!*mesh) return mesh->error();
        meshes.push_back(std::move(**mesh));
    }
    return append(file, std::move(materials), std::move(meshes), gltf_meshes, nodes, into);
}

}  // namespace

Result<Model> import_gltf(const std::filesystem::path& path, WorldSource& into, CookContext& context, ModelKind kind) {
    try {  // libraries that throw where memory or a value fails end here
        return import_checked(path, into, context, kind);
    } catch (const std::exception& e) {
        return bad_input(fmt::format("{}: document: {}; expected glTF 2.0", path.string(), e.what()));
    }
}

void place_model(const Model& model, const DVec3& position, const DMat3& world_from_model, PlacementKind kind,
                 WorldSource& into, bool stands_clear) {
    for (const ModelPart& part : model.parts)
        into.placements.push_back({.mesh = part.mesh,
                                   .position = position + world_from_model * part.position,
                                   .world_from_mesh = Mat3(world_from_model * part.model_from_mesh),
                                   .kind = kind,
                                   .stands_clear = stands_clear});
}

}  // namespace ff::cook
