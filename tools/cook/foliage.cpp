#include "tools/cook/foliage.h"

namespace ff::cook {
namespace {

void mark_mesh(std::uint32_t mesh, WorldSource& world) {
    for (const std::uint16_t id : world.meshes[mesh].geometry.triangle_materials) {
        scene::Material& material = world.materials[id];
        if ((material.flags & scene::kMaterialAlphaMask) != 0) material.flags |= scene::kMaterialSways;
    }
}

}  // namespace

void mark_foliage(const Model& model, WorldSource& world) {
    for (const ModelPart& part : model.parts) mark_mesh(part.mesh, world);
    if (!model.animated) return;
    const scene::AnimatedModel& animated = world.animation.models[*model.animated];
    for (const scene::RigidPart& part : animated.parts) mark_mesh(part.mesh, world);
    for (const scene::Skin& skin : animated.skins) mark_mesh(skin.mesh, world);
}

}  // namespace ff::cook
