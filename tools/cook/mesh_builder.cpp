#include "tools/cook/mesh_builder.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <utility>

namespace ff::cook {

std::uint32_t pack_color(const Vec3& linear) {
    const auto channel = [](float v) { return std::uint32_t(std::clamp(v, 0.0f, 1.0f) * 255.0f + 0.5f); };
    return channel(linear.r) | channel(linear.g) << 8 | channel(linear.b) << 16 | 0xFF000000u;
}

MeshBuilder::MeshBuilder(std::string name, const WorldPos& origin) : name_(std::move(name)), origin_(origin) {}

std::uint32_t MeshBuilder::vertex(const DVec3& world, const Vec3& unit_normal, const Vec2& uv, std::uint32_t color) {
    geometry_.positions.push_back(Vec3(world - origin_));
    scene::VertexAttributes attributes;
    scene::encode_normal(unit_normal, attributes.normal_oct);
    attributes.uv = uv;
    attributes.color = color;
    geometry_.attributes.push_back(attributes);
    return std::uint32_t(geometry_.positions.size() - 1);
}

void MeshBuilder::triangle(std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t material) {
    geometry_.indices.insert(geometry_.indices.end(), {a, b, c});
    geometry_.triangle_materials.push_back(std::uint16_t(material));
}

void MeshBuilder::flat_triangle(const std::array<DVec3, 3>& straight, const std::array<Vec2, 3>& uvs,
                                std::uint32_t material, std::uint32_t color) {
    std::array<DVec3, 3> corners = straight;
    if (warp_)
        for (DVec3& corner : corners) corner = warp_(corner);
    const DVec3 normal = glm::cross(corners[1] - corners[0], corners[2] - corners[0]);
    const double length = glm::length(normal);
    if (!(length > 1e-9)) return;
    const Vec3 unit(normal / length);
    std::uint32_t ids[3];
    for (int i = 0; i < 3; ++i) ids[i] = vertex(corners[i], unit, uvs[i], color);
    triangle(ids[0], ids[1], ids[2], material);
}

void MeshBuilder::flat_quad(const std::array<DVec3, 4>& straight, const std::array<Vec2, 4>& uvs,
                            std::uint32_t material, std::uint32_t color) {
    std::array<DVec3, 4> corners = straight;
    if (warp_)
        for (DVec3& corner : corners) corner = warp_(corner);
    const DVec3 normal = glm::cross(corners[2] - corners[0], corners[3] - corners[1]);
    const double length = glm::length(normal);
    if (!(length > 1e-9)) return;
    const Vec3 unit(normal / length);
    std::uint32_t ids[4];
    for (int i = 0; i < 4; ++i) ids[i] = vertex(corners[i], unit, uvs[i], color);
    triangle(ids[0], ids[1], ids[2], material);
    triangle(ids[0], ids[2], ids[3], material);
}

SourceMesh MeshBuilder::take() {
    return {std::move(name_), std::move(geometry_)};
}

void add_static_mesh(WorldSource& world, MeshBuilder&& builder) {
    if (builder.triangle_count() == 0) return;
    Placement placement;
    placement.mesh = std::uint32_t(world.meshes.size());
    placement.position = builder.origin();
    world.meshes.push_back(builder.take());
    world.placements.push_back(placement);
}

}  // namespace ff::cook
