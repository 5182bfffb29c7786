#include <glm/geometric.hpp>

#include "engine/animation/skin_vertices.h"
#include "engine/scene/scene_data.h"

namespace ff::animation {

void skin_vertices_reference(const SkinTables& skin, std::span<const JointColumns> matrices, Vec3* positions,
                             scene::VertexAttributes* attributes) {
    for (std::size_t v = 0; v < skin.vertex_count; ++v) {
        DVec3 column[4] = {};
        for (std::size_t i = v * skin.influences; i < (v + 1) * skin.influences; ++i)
            for (int c = 0; c < 4; ++c) {
                const float* m = matrices[skin.joints[i]].column[c];
                column[c] += double(skin.weights[i]) * DVec3(m[0], m[1], m[2]);
            }
        positions[v] = Vec3(column[0] * double(skin.x[v]) + column[1] * double(skin.y[v]) +
                            column[2] * double(skin.z[v]) + column[3]);
        const DVec3 normal = glm::cross(column[1], column[2]) * double(skin.normal_x[v]) +
                             glm::cross(column[2], column[0]) * double(skin.normal_y[v]) +
                             glm::cross(column[0], column[1]) * double(skin.normal_z[v]);
        const double length = glm::length(normal);
        scene::encode_normal(length > 0.0 ? Vec3(normal / length) : Vec3(0.0f), attributes[v].normal_oct);
    }
}

}  // namespace ff::animation
