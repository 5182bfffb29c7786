#include "tools/cook/gltf_animated.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <map>
#include <optional>
#include <unordered_map>

#include "engine/animation/pose.h"
#include "engine/core/jobs.h"
#include "tools/cook/gltf_animation.h"
#include "tools/cook/gltf_append.h"
#include "tools/cook/gltf_mesh.h"
#include "tools/cook/gltf_nodes.h"

namespace ff::cook {
namespace {

using nlohmann::json;
using scene::Mat4x3;

/// A glTF mesh as one skin, or none, makes it: read once.
struct MeshUse {
    std::size_t mesh = 0, skin = NodeMesh::kNoSkin;
    friend auto operator<=>(const MeshUse&, const MeshUse&) = default;
};
struct ReadMesh {
    scene::MeshSource geometry;
    SkinStreams influences;
};

/// Tells vertices apart that lie in one place but follow other joints, by the last bit of a coordinate: whatever takes
/// vertices of one position for one (leaves of hierarchies, for one) would tie together what moves apart.
void tell_apart(ReadMesh& mesh) {
    struct Key {
        std::uint32_t x, y, z;
        bool operator==(const Key&) const = default;
    };
    struct Hash {
        std::size_t operator()(const Key& k) const {
            return (k.x * 0x9E3779B1u) ^ (k.y * 0x85EBCA77u) ^ (k.z * 0xC2B2AE3Du);
        }
    };
    constexpr std::size_t kEach = scene::kMostInfluences;
    std::unordered_map<Key, std::size_t, Hash> first_at;
    const auto follow_the_same = [&](std::size_t a, std::size_t b) {
        return std::equal(&mesh.influences.joints[a * kEach], &mesh.influences.joints[a * kEach] + kEach,
                          &mesh.influences.joints[b * kEach]) &&
               std::equal(&mesh.influences.weights[a * kEach], &mesh.influences.weights[a * kEach] + kEach,
                          &mesh.influences.weights[b * kEach]);
    };
    for (std::size_t v = 0; v < mesh.geometry.positions.size(); ++v) {
        Vec3& p = mesh.geometry.positions[v];
        p += 0.0f;  // -0 and +0 are one place
        for (;;) {
            const Key key{std::bit_cast<std::uint32_t>(p.x), std::bit_cast<std::uint32_t>(p.y),
                          std::bit_cast<std::uint32_t>(p.z)};
            const auto [at, is_new] = first_at.try_emplace(key, v);
            if (is_new || follow_the_same(at->second, v)) break;
            p.x = std::nextafter(p.x, std::numeric_limits<float>::infinity()) + 0.0f;
        }
    }
}

Result<std::vector<Mat4x3>> read_inverse_binds(const GltfData& data, const json& skin, const std::string& place) {
    const std::size_t joints = skin.at("joints").size();
    if (!skin.contains("inverseBindMatrices")) return std::vector<Mat4x3>(joints, Mat4x3(1.0f));
    const std::string at = place + ".inverseBindMatrices";
    FF_ASSIGN(const std::vector<float> values, read_floats(data, skin.at("inverseBindMatrices").get<int>(), 16, at));
    if (values.size() < 16 * joints)
        return data.file.error(
            at, fmt::format("{} matrices; expected one for each of the {} joints", values.size() / 16, joints));
    std::vector<Mat4x3> out(joints);
    for (std::size_t j = 0; j < joints; ++j)
        for (int c = 0; c < 4; ++c)
            for (int r = 0; r < 3; ++r) {
                out[j][c][r] = values[16 * j + std::size_t(4 * c + r)];
                if (!(std::fabs(out[j][c][r]) <= 1e8f))
                    return data.file.error(fmt::format("{}: element {}", at, j), "a number beyond 1e8; expected less");
            }
    return out;
}

/// Everything of a skin but its mesh's id.
Result<scene::Skin> read_skin(const GltfData& data, std::size_t index, const NodeSkeleton& nodes,
                              const SkinStreams& influences) {
    const json& source = data.file.json.at("skins")[index];
    const std::string place = fmt::format("skins[{}]", index);
    scene::Skin skin;
    for (std::size_t j = 0; j < source.at("joints").size(); ++j) {
        const auto node = source.at("joints")[j].get<std::size_t>();
        if (nodes.joint_of_node[node] == scene::kNoJoint)
            return data.file.error(fmt::format("{}.joints[{}]", place, j),
                                   fmt::format("node {} is not in the scene; expected one that is", node));
        skin.joints.push_back(nodes.joint_of_node[node]);
    }
    FF_ASSIGN(skin.joint_from_mesh, read_inverse_binds(data, source, place));
    constexpr std::size_t kEach = scene::kMostInfluences;
    const std::size_t vertices = influences.weights.size() / kEach;
    for (std::size_t v = 0; v < vertices; ++v)
        for (std::uint32_t i = 0; i < kEach; ++i)
            if (influences.weights[v * kEach + i] > 0.0f) skin.influences = std::max(skin.influences, i + 1);
    for (std::size_t v = 0; v < vertices; ++v)
        for (std::size_t i = 0; i < skin.influences; ++i) {
            skin.vertex_joints.push_back(influences.joints[v * kEach + i]);
            skin.vertex_weights.push_back(influences.weights[v * kEach + i]);
        }
    return skin;
}

/// Around the model at rest.
DBox3 rest_bounds(const scene::AnimatedModel& model, const std::vector<SourceMesh>& meshes) {
    animation::Pose pose;
    pose.set_rest(model.skeleton);
    std::vector<Mat4x3> joints(model.skeleton.size());
    animation::find_joint_matrices(model.skeleton, pose, joints);
    const auto moved = [](const Mat4x3& m, const Vec3& p) { return m[0] * p.x + m[1] * p.y + m[2] * p.z + m[3]; };
    DBox3 box;
    for (const scene::RigidPart& part : model.parts) {
        const Mat4x3 m = animation::product(joints[part.joint], part.joint_from_mesh);
        for (const Vec3& p : meshes[part.mesh].geometry.positions) box.add(DVec3(moved(m, p)));
    }
    for (const scene::Skin& skin : model.skins) {
        const std::vector<Vec3>& positions = meshes[skin.mesh].geometry.positions;
        for (std::size_t v = 0; v < positions.size(); ++v) {
            Vec3 sum(0.0f);
            for (std::size_t i = v * skin.influences; i < (v + 1) * skin.influences; ++i) {
                const std::size_t j = skin.vertex_joints[i];
                sum += skin.vertex_weights[i] *
                       moved(animation::product(joints[skin.joints[j]], skin.joint_from_mesh[j]), positions[v]);
            }
            box.add(DVec3(sum));
        }
    }
    return box;
}

std::size_t joint_count_of(const GltfData& data, std::size_t skin) {
    return data.file.json.at("skins")[skin].at("joints").size();
}

Result<std::vector<ReadMesh>> read_meshes(const GltfData& data, const std::vector<MeshUse>& uses,
                                          const ImportedMaterials& materials, CookContext& context) {
    std::vector<std::optional<Status>> problems(uses.size());
    std::vector<ReadMesh> read(uses.size());
    parallel_for(uses.size(), [&](std::size_t i) {
        const bool is_skinned = uses[i].skin != NodeMesh::kNoSkin;
        if (is_skinned) read[i].influences.joint_count = joint_count_of(data, uses[i].skin);
        auto mesh = read_mesh(data, uses[i].mesh, materials, context, is_skinned ? &read[i].influences : nullptr);
        if (!mesh) {
            problems[i].emplace(mesh.error());
            return;
        }
        read[i].geometry = std::move(*mesh);
        if (is_skinned) tell_apart(read[i]);
    });
    for (const auto& problem : problems)
        if (problem) return problem->error();
    return read;
}

}  // namespace

Result<Model> import_animated(GltfFile& file, const GltfData& data, WorldSource& into, CookContext& context) {
    FF_ASSIGN(const NodeSkeleton nodes, read_skeleton(data, context));
    if (nodes.skeleton.size() == 0) return file.error("nodes", "none in the scene; expected some to animate");
    std::map<MeshUse, std::size_t> slots;
    for (const NodeMesh& mesh : nodes.meshes) slots.try_emplace({mesh.mesh, mesh.skin}, 0);
    std::vector<MeshUse> uses;
    for (auto& [use, slot] : slots) {
        slot = uses.size();
        uses.push_back(use);
    }
    FF_ASSIGN(ImportedMaterials materials, read_materials(file, data, context));
    FF_ASSIGN(std::vector<ReadMesh> read, read_meshes(data, uses, materials, context));
    std::vector<std::optional<scene::Skin>> skins(uses.size());
    for (std::size_t i = 0; i < uses.size(); ++i)
        if (uses[i].skin != NodeMesh::kNoSkin && !read[i].geometry.triangle_materials.empty()) {
            FF_ASSIGN(skins[i], read_skin(data, uses[i].skin, nodes, read[i].influences));
        }
    scene::AnimatedModel animated{.name = std::filesystem::path(file.name).stem().string().substr(0, 1000),
                                  .skeleton = nodes.skeleton};
    Box3 box;  // of all meshes as they are stored: what size means for tolerances
    for (const ReadMesh& mesh : read)
        for (const Vec3& p : mesh.geometry.positions) box.add(p);
    const float size_m = box.is_empty() ? 1.0f : std::max(glm::length(box.extent()), 1e-3f);
    FF_ASSIGN(animated.clips, read_clips(data, nodes.joint_of_node, size_m, context));

    std::vector<scene::MeshSource> geometry;
    for (ReadMesh& mesh : read) geometry.push_back(std::move(mesh.geometry));
    FF_ASSIGN(const std::vector<std::uint16_t> material_ids,
              append_materials(file, std::move(materials), geometry, into));
    Model model{.name = animated.name};
    std::vector<std::uint32_t> ids(uses.size(), 0);
    std::vector<std::uint64_t> triangles(uses.size(), 0);
    for (std::size_t i = 0; i < uses.size(); ++i) {
        triangles[i] = geometry[i].triangle_materials.size();
        ids[i] = append_mesh(fmt::format("{}: meshes[{}]", file.name, uses[i].mesh), std::move(geometry[i]),
                             material_ids, into);
    }
    for (const NodeMesh& mesh : nodes.meshes) {
        const std::size_t slot = slots.at({mesh.mesh, mesh.skin});
        if (triangles[slot] == 0) continue;
        if (mesh.skin == NodeMesh::kNoSkin) {
            animated.parts.push_back({ids[slot], mesh.joint, mesh.joint_from_mesh});
        } else if (skins[slot]) {  // shown by two nodes it would lie in one place twice
            skins[slot]->mesh = ids[slot];
            animated.skins.push_back(std::move(*skins[slot]));
            skins[slot].reset();
        } else {
            continue;
        }
        model.triangle_count += triangles[slot];
    }
    model.bounds = rest_bounds(animated, into.meshes);
    model.animated = static_cast<std::uint32_t>(into.animation.models.size());
    into.animation.models.push_back(std::move(animated));
    into.bytes_in += file.bytes_read;
    return model;
}

}  // namespace ff::cook
