#include "tools/cook/assemble_animation.h"

#include <algorithm>
#include <bit>

#include "engine/core/check.h"

namespace ff::cook {
namespace {

struct PositionHash {
    std::size_t operator()(const Vec3& p) const {
        const auto bits = [](float f) { return std::bit_cast<std::uint32_t>(f); };
        return (bits(p.x) * 0x9E3779B1u) ^ (bits(p.y) * 0x85EBCA77u) ^ (bits(p.z) * 0xC2B2AE3Du);
    }
};

}  // namespace

AnimationAssembly::AnimationAssembly(WorldSource& source) : set_(std::move(source.animation)) {
    for (const scene::AnimatedModel& model : set_.models) {
        for (const scene::RigidPart& part : model.parts) meshes_.push_back(part.mesh);
        for (const scene::Skin& skin : model.skins) {
            meshes_.push_back(skin.mesh);
            positions_.push_back(source.meshes[skin.mesh].geometry.positions);
        }
    }
    std::sort(meshes_.begin(), meshes_.end());
    meshes_.erase(std::unique(meshes_.begin(), meshes_.end()), meshes_.end());
}

scene::AnimationSet AnimationAssembly::finish(const std::function<std::uint32_t(std::uint32_t)>& mesh_id,
                                              const scene::SceneData& scene) {
    std::size_t next = 0;
    for (scene::AnimatedModel& model : set_.models) {
        for (scene::RigidPart& part : model.parts) part.mesh = mesh_id(part.mesh);
        std::erase_if(model.parts, [](const scene::RigidPart& part) { return part.mesh == kNone; });
        for (scene::Skin& skin : model.skins) {
            const std::vector<Vec3>& positions = positions_[next++];
            skin.mesh = mesh_id(skin.mesh);
            if (skin.mesh == kNone) continue;
            std::unordered_map<Vec3, std::size_t, PositionHash> vertex_at;
            for (std::size_t v = 0; v < positions.size(); ++v) vertex_at.try_emplace(positions[v], v);
            const scene::Mesh& mesh = scene.meshes[skin.mesh];
            std::vector<std::uint16_t> joints;
            std::vector<float> weights;
            for (std::size_t v = 0; v < mesh.vertex_count; ++v) {
                const auto found = vertex_at.find(scene.positions[mesh.first_vertex + v]);
                FF_CHECK(found != vertex_at.end(), "vertex {} of a skinned mesh has moved", v);
                for (std::size_t i = 0; i < skin.influences; ++i) {
                    joints.push_back(skin.vertex_joints[found->second * skin.influences + i]);
                    weights.push_back(skin.vertex_weights[found->second * skin.influences + i]);
                }
            }
            skin.vertex_joints = std::move(joints);
            skin.vertex_weights = std::move(weights);
        }
        std::erase_if(model.skins, [](const scene::Skin& skin) { return skin.mesh == kNone; });
    }
    return std::move(set_);
}

}  // namespace ff::cook
