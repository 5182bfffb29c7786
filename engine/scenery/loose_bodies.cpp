#include "engine/scenery/loose_bodies.h"

namespace ff::scenery {

LooseBodyStart start_of(const scene::World& world, const scene::LooseBody& body) {
    const scene::WorldInfo& info = world.info();
    const auto size_of = [&](const scene::DynamicInstance& part) {
        const Box3& box = world.scene().meshes[part.mesh].bounds;
        if (box.is_empty()) return 0.0f;
        const Mat3& m = part.world_from_mesh;
        const Vec3 half = (box.high - box.low) * 0.5f;
        const Vec3 reach = glm::abs(m[0]) * half.x + glm::abs(m[1]) * half.y + glm::abs(m[2]) * half.z;
        return glm::dot(reach, reach);
    };
    std::uint32_t largest = body.model.first_instance;
    for (std::uint32_t i = 1; i < body.model.instance_count; ++i)
        if (size_of(info.dynamic_instances[body.model.first_instance + i]) > size_of(info.dynamic_instances[largest]))
            largest = body.model.first_instance + i;
    const scene::DynamicInstance& part = info.dynamic_instances[largest];

    LooseBodyStart start;
    start.model = model_of(body.model);
    start.model.placed_at = part.position;
    const Mat3 body_from_world = glm::mat3_cast(glm::inverse(start.model.placed_turn));
    start.desc.shape = physics::hull_shape(part.mesh, body_from_world * part.world_from_mesh);
    start.desc.pose = {part.position, start.model.placed_turn};
    start.desc.mass_kg = body.mass_kg;
    return start;
}

}  // namespace ff::scenery
