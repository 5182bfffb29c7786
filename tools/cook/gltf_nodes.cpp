#include "tools/cook/gltf_nodes.h"

#include <fmt/format.h>

#include <cmath>
#include <glm/gtc/quaternion.hpp>

#include "engine/scene/check_animation.h"

namespace ff::cook {
namespace {

using nlohmann::json;

/// x -> linear * x + translation, in double: deep hierarchies far from the origin keep their millimetres.
struct Affine {
    DMat3 linear{1.0};
    DVec3 translation{0.0};
};

Affine operator*(const Affine& outer, const Affine& inner) {
    return {outer.linear * inner.linear, outer.linear * inner.translation + outer.translation};
}

DMat3 rotation_scale(const glm::dquat& rotation, const DVec3& scale) {
    const double length = glm::length(rotation);
    DMat3 m = length > 0.0 ? glm::mat3_cast(rotation / length) : DMat3(1.0);
    for (int i = 0; i < 3; ++i) m[i] *= scale[i];
    return m;
}

Affine local_transform(const tinygltf::Node& node) {
    Affine local;
    if (node.matrix.size() == 16) {
        for (int c = 0; c < 3; ++c)
            for (int r = 0; r < 3; ++r) local.linear[c][r] = node.matrix[static_cast<std::size_t>(4 * c + r)];
        local.translation = {node.matrix[12], node.matrix[13], node.matrix[14]};
        return local;
    }
    glm::dquat rotation(1.0, 0.0, 0.0, 0.0);
    DVec3 scale(1.0);
    if (const auto& q = node.rotation; q.size() == 4) rotation = glm::dquat(q[3], q[0], q[1], q[2]);
    if (const auto& s = node.scale; s.size() == 3) scale = {s[0], s[1], s[2]};
    if (const auto& t = node.translation; t.size() == 3) local.translation = {t[0], t[1], t[2]};
    local.linear = rotation_scale(rotation, scale);
    return local;
}

/// Dimensions that are left of space after a transform, as far as it matters: 3, 2 (flat), or 0 for less.
int rank_of(const Affine& transform) {
    const DMat3& m = transform.linear;
    const double determinant = glm::determinant(m);
    for (int i = 0; i < 3; ++i)
        if (!std::isfinite(transform.translation[i]) || !std::isfinite(glm::length(m[i]))) return 0;
    // Against the size of its columns: a model in micrometres is not singular.
    const double size = glm::length(m[0]) * glm::length(m[1]) * glm::length(m[2]);
    if (size > 1e-30 && std::abs(determinant) > 1e-9 * size) return 3;
    for (int i = 0; i < 3; ++i) {
        const DVec3 &a = m[i], &b = m[(i + 1) % 3];
        const double area = glm::length(a) * glm::length(b);
        if (area > 1e-20 && glm::length(glm::cross(a, b)) > 1e-9 * area) return 2;
    }
    return 0;
}

// The transforms of EXT_mesh_gpu_instancing; one identity where a node has none.
Result<std::vector<Affine>> instances_of(const GltfData& data, std::size_t node) {
    const json::json_pointer at("/extensions/EXT_mesh_gpu_instancing/attributes");
    const json& source = data.file.json.at("nodes")[node];
    if (!source.contains(at)) return std::vector<Affine>(1);
    std::vector<float> translation, rotation, scale;
    std::size_t count = 0;
    bool first = true;
    for (const auto& [name, accessor] : source.at(at).items()) {
        std::vector<float>* into = name == "TRANSLATION" ? &translation
                                   : name == "ROTATION"  ? &rotation
                                   : name == "SCALE"     ? &scale
                                                         : nullptr;
        if (into == nullptr) continue;
        const std::string place = fmt::format("nodes[{}].extensions.EXT_mesh_gpu_instancing.attributes.{}", node, name);
        const std::size_t components = into == &rotation ? 4 : 3;
        FF_ASSIGN(*into, read_floats(data, accessor.get<int>(), components, place));
        const std::size_t elements = into->size() / components;
        if (!first && elements != count)
            return data.file.error(place, fmt::format("{} elements; expected {} as in the others", elements, count));
        count = elements;
        first = false;
    }
    std::vector<Affine> instances(count);
    for (std::size_t i = 0; i < count; ++i) {
        glm::dquat q(1.0, 0.0, 0.0, 0.0);
        DVec3 s(1.0);
        if (!rotation.empty())
            q = glm::dquat(rotation[4 * i + 3], rotation[4 * i], rotation[4 * i + 1], rotation[4 * i + 2]);
        if (!scale.empty()) s = {scale[3 * i], scale[3 * i + 1], scale[3 * i + 2]};
        instances[i].linear = rotation_scale(q, s);
        if (!translation.empty())
            instances[i].translation = {translation[3 * i], translation[3 * i + 1], translation[3 * i + 2]};
    }
    return instances;
}

std::vector<int> root_nodes(const tinygltf::Model& model) {
    if (!model.scenes.empty()) {
        const int scene = model.defaultScene >= 0 ? model.defaultScene : 0;
        return model.scenes[static_cast<std::size_t>(scene)].nodes;
    }
    std::vector<bool> is_child(model.nodes.size(), false);
    for (const tinygltf::Node& node : model.nodes)
        for (const int child : node.children) is_child[static_cast<std::size_t>(child)] = true;
    std::vector<int> roots;
    for (std::size_t i = 0; i < model.nodes.size(); ++i)
        if (!is_child[i]) roots.push_back(static_cast<int>(i));
    return roots;
}

}  // namespace

Result<std::vector<NodeInstance>> flatten_nodes(const GltfData& data) {
    struct Pending {
        int node;
        Affine parent;
    };
    std::vector<NodeInstance> flat;
    std::vector<Pending> stack;  // not recursion: a chain of nodes may be as long as the file
    const std::vector<int> roots = root_nodes(data.model);
    for (auto root = roots.rbegin(); root != roots.rend(); ++root) stack.push_back({*root, {}});
    while (!stack.empty()) {
        const Pending pending = stack.back();
        stack.pop_back();
        const auto index = static_cast<std::size_t>(pending.node);
        const tinygltf::Node& node = data.model.nodes[index];
        const Affine transform = pending.parent * local_transform(node);
        if (node.mesh >= 0) {
            FF_ASSIGN(const std::vector<Affine> instances, instances_of(data, index));
            for (const Affine& instance : instances) {
                const Affine placed = transform * instance;
                const int rank = rank_of(placed);
                if (rank > 0)
                    flat.push_back({static_cast<std::size_t>(node.mesh), placed.translation, placed.linear, rank == 2});
            }
        }
        for (auto child = node.children.rbegin(); child != node.children.rend(); ++child)
            stack.push_back({*child, transform});
    }
    return flat;
}

namespace {

scene::Mat4x3 single(const Affine& a) {
    return {Vec3(a.linear[0]), Vec3(a.linear[1]), Vec3(a.linear[2]), Vec3(a.translation)};
}

/// A node's transform as a joint has it: scale, rotation, translation.
/// @return whether that is all of it
bool append_joint(const tinygltf::Node& node, std::uint32_t parent, scene::Skeleton& skeleton) {
    const Affine local = local_transform(node);
    DMat3 axes = local.linear;
    DVec3 scale(glm::length(axes[0]), glm::length(axes[1]), glm::length(axes[2]));
    if (node.matrix.size() != 16 && node.scale.size() == 3)
        scale = {node.scale[0], node.scale[1], node.scale[2]};
    else if (glm::determinant(axes) < 0.0)
        scale.x = -scale.x;
    glm::dquat rotation(1.0, 0.0, 0.0, 0.0);
    if (node.matrix.size() != 16) {
        if (const auto& q = node.rotation; q.size() == 4) rotation = glm::dquat(q[3], q[0], q[1], q[2]);
    } else if (scale.x != 0.0 && scale.y != 0.0 && scale.z != 0.0) {
        rotation = glm::quat_cast(DMat3(axes[0] / scale.x, axes[1] / scale.y, axes[2] / scale.z));
    }
    const double length = glm::length(rotation);
    rotation = length > 0.0 ? rotation / length : glm::dquat(1.0, 0.0, 0.0, 0.0);
    skeleton.names.push_back(node.name.substr(0, 1024));
    skeleton.parents.push_back(parent);
    skeleton.translations.emplace_back(local.translation);
    skeleton.rotations.emplace_back(static_cast<float>(rotation.w), static_cast<float>(rotation.x),
                                    static_cast<float>(rotation.y), static_cast<float>(rotation.z));
    skeleton.scales.emplace_back(scale);
    const DMat3 kept = rotation_scale(rotation, scale);
    double error = 0.0, size = 0.0;
    for (int c = 0; c < 3; ++c) {
        error = std::max(error, glm::length(kept[c] - local.linear[c]));
        size = std::max(size, glm::length(local.linear[c]));
    }
    return error <= 1e-3 * size;
}

}  // namespace

Result<NodeSkeleton> read_skeleton(const GltfData& data, CookContext& context) {
    struct Pending {
        int node;
        std::uint32_t parent;
    };
    NodeSkeleton out;
    out.joint_of_node.assign(data.model.nodes.size(), scene::kNoJoint);
    std::vector<Pending> stack;
    const std::vector<int> roots = root_nodes(data.model);
    for (auto root = roots.rbegin(); root != roots.rend(); ++root) stack.push_back({*root, scene::kNoJoint});
    while (!stack.empty()) {
        const Pending pending = stack.back();
        stack.pop_back();
        const auto index = static_cast<std::size_t>(pending.node);
        const tinygltf::Node& node = data.model.nodes[index];
        const std::uint32_t joint = out.skeleton.size();
        if (joint >= scene::kMostJoints)
            return data.file.error(
                "nodes", fmt::format("more than {}; expected fewer of a model that is animated", scene::kMostJoints));
        out.joint_of_node[index] = joint;
        if (!append_joint(node, pending.parent, out.skeleton))
            context.warn(
                fmt::format("{}: a node's matrix shears; the animated model is drawn without that", data.file.name));
        if (node.mesh >= 0) {
            const json& source = data.file.json.at("nodes")[index];
            NodeMesh mesh{.mesh = static_cast<std::size_t>(node.mesh), .joint = joint};
            if (source.contains("skin")) {
                mesh.skin = source.at("skin").get<std::size_t>();
                out.meshes.push_back(mesh);
            } else {
                FF_ASSIGN(const std::vector<Affine> instances, instances_of(data, index));
                for (const Affine& instance : instances) {
                    mesh.joint_from_mesh = single(instance);
                    out.meshes.push_back(mesh);
                }
            }
        }
        for (auto child = node.children.rbegin(); child != node.children.rend(); ++child)
            stack.push_back({*child, joint});
    }
    return out;
}

}  // namespace ff::cook
