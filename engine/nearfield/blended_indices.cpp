#include "engine/nearfield/blended_indices.h"

#include <algorithm>

namespace ff::nearfield {

void BlendedIndices::sort(const scene::StaticScene& scene, const SceneLayout& layout, const DrawList& list) {
    indices.clear();
    first_index.clear();
    for (const BlendedDraw& draw : list.blended) {
        const scene::Mesh& mesh = scene.meshes[draw.mesh];
        const MaterialGroup& group = layout.groups[draw.group];
        const InstanceRecord& record = list.records[draw.record];
        const std::uint32_t* corners = scene.indices.data() + 3 * std::size_t(mesh.first_triangle);
        const Vec3* positions = scene.positions.data() + mesh.first_vertex;
        keys_.clear();
        for (std::uint32_t t = 0; t < group.triangle_count; ++t) {
            const std::uint32_t triangle = layout.triangle_of(draw.mesh, group.first_triangle + t);
            const std::uint32_t* corner = corners + 3 * std::size_t(triangle);
            const Vec3 middle = (positions[corner[0]] + positions[corner[1]] + positions[corner[2]]) * (1.0f / 3.0f);
            float distance2 = 0.0f;
            for (const auto& row : record.relative_from_mesh) {
                const float p = row[0] * middle.x + row[1] * middle.y + row[2] * middle.z + row[3];
                distance2 += p * p;
            }
            keys_.push_back({distance2, triangle});
        }
        std::sort(keys_.begin(), keys_.end(), [](const Key& a, const Key& b) {
            return a.distance2 != b.distance2 ? a.distance2 > b.distance2 : a.triangle < b.triangle;
        });
        first_index.push_back(std::uint32_t(indices.size()));
        for (const Key& key : keys_) {
            const std::uint32_t* corner = corners + 3 * std::size_t(key.triangle);
            indices.insert(indices.end(), corner, corner + 3);
        }
    }
}

}  // namespace ff::nearfield
