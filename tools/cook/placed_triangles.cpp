#include "tools/cook/placed_triangles.h"

#include <glm/matrix.hpp>
#include <utility>

namespace ff::cook {

PlacedTriangles::PlacedTriangles(const WorldSource& world, std::vector<PlacementSlot> slots)
    : world_(world), slots_(std::move(slots)) {
    for (const PlacementSlot& slot : slots_) {
        const Placement& placement = world.placements[slot.placement];
        signs_.push_back(glm::determinant(DMat3(placement.world_from_mesh)) < 0.0 ? -1.0 : 1.0);
        first_.push_back(static_cast<std::uint32_t>(slot_of_.size()));
        slot_of_.insert(slot_of_.end(), world.meshes[placement.mesh].geometry.triangle_materials.size(),
                        static_cast<std::uint32_t>(first_.size() - 1));
    }
    first_.push_back(static_cast<std::uint32_t>(slot_of_.size()));
}

const Placement& PlacedTriangles::placement(std::uint32_t id) const {
    return world_.placements[slots_[slot_of_[id]].placement];
}

const scene::MeshSource& PlacedTriangles::mesh(std::uint32_t id) const {
    return world_.meshes[placement(id).mesh].geometry;
}

std::uint16_t PlacedTriangles::material(std::uint32_t id) const {
    return mesh(id).triangle_materials[triangle(id)];
}

std::array<DVec3, 3> PlacedTriangles::corners(std::uint32_t id) const {
    const Placement& at = placement(id);
    const scene::MeshSource& geometry = mesh(id);
    const std::size_t corner = 3 * std::size_t{triangle(id)};
    const DMat3 linear(at.world_from_mesh);
    std::array<DVec3, 3> corners;
    for (std::size_t c = 0; c < 3; ++c)
        corners[c] = linear * DVec3(geometry.positions[geometry.indices[corner + c]]) + at.position;
    return corners;
}

}  // namespace ff::cook
