#include "engine/farfield/layer_reference.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

namespace ff::farfield {
namespace {

using scene::StaticScene;
using DVec2 = glm::dvec2;

std::int64_t wrapped(std::int64_t i, std::int64_t size, scene::Wrap wrap) {
    if (wrap == scene::Wrap::clamp) return std::clamp<std::int64_t>(i, 0, size - 1);
    const std::int64_t period = wrap == scene::Wrap::mirror ? 2 * size : size;
    i = (i % period + period) % period;
    return i < size ? i : 2 * size - 1 - i;
}

double filtered_alpha(const StaticScene& scene, const scene::Texture& texture, const DVec2& uv, double lod) {
    const auto level = std::uint32_t(std::clamp(std::floor(lod + 0.5), 0.0, texture.level_count - 1.0));
    const std::int64_t width = std::max(1u, texture.width >> level), height = std::max(1u, texture.height >> level);
    const double x = uv.x * double(width) - 0.5, y = uv.y * double(height) - 0.5;
    const double x0 = std::floor(x), y0 = std::floor(y);
    double alpha = 0.0;
    for (int corner = 0; corner < 4; ++corner) {
        const int i = corner & 1, j = corner >> 1;
        const std::int64_t column = wrapped(std::int64_t(x0) + i, width, texture.wrap_u);
        const std::int64_t row = wrapped(std::int64_t(y0) + j, height, texture.wrap_v);
        const std::uint32_t texel =
            scene.texels[texture.first_texel + scene::level_offset(texture, level) + std::size_t(row * width + column)];
        alpha += (i ? x - x0 : x0 + 1.0 - x) * (j ? y - y0 : y0 + 1.0 - y) * double(texel >> 24) / 255.0;
    }
    return alpha;
}

/// What of one triangle lies before the pixel.
/// @param direction  the pixel's, |z_camera| = 1
/// @return whether it is met at all
bool meet(const StaticScene& scene, const scene::Instance& instance, std::uint32_t triangle, const PinholeView& view,
          const DVec3& direction, ReferenceLayer& out) {
    const scene::Mesh& mesh = scene.meshes[instance.mesh];
    const std::size_t t = std::size_t(mesh.first_triangle) + triangle;
    const scene::Material& material = scene.materials[scene.triangle_materials[t]];
    DVec3 p[3];
    const scene::VertexAttributes* corner[3];
    for (std::size_t k = 0; k < 3; ++k) {
        const std::size_t vertex = mesh.first_vertex + scene.indices[3 * t + k];
        p[k] = DMat3(instance.world_from_mesh) * DVec3(scene.positions[vertex]) + (instance.position - view.position);
        corner[k] = &scene.attributes[vertex];
    }
    const DVec3 e1 = p[1] - p[0], e2 = p[2] - p[0], normal = glm::cross(e1, e2);
    const double area = glm::length(normal), slope = glm::dot(normal, direction) / area;
    if (!(area > 0.0) || slope == 0.0) return false;
    const double plane = glm::dot(normal, p[0]) / area;
    out.depth = plane / slope;
    const DVec3 q = out.depth * direction - p[0];
    const double b1 = glm::dot(glm::cross(q, e2), normal) / (area * area);
    const double b2 = glm::dot(glm::cross(e1, q), normal) / (area * area);
    out.inside = std::min({b1, b2, 1.0 - b1 - b2});
    out.edge_m = std::max({glm::length(e1), glm::length(e2), glm::length(p[2] - p[1])});
    out.height_m = area / out.edge_m;

    const auto interpolated = [&](const auto& v0, const auto& v1, const auto& v2) {
        return v0 + b1 * (v1 - v0) + b2 * (v2 - v0);
    };
    const auto vertex_alpha = [&](int k) { return double(corner[k]->color >> 24) / 255.0; };
    out.alpha = double(material.base_color.a) * interpolated(vertex_alpha(0), vertex_alpha(1), vertex_alpha(2));
    if (material.base_color_texture == scene::kNoTexture) return true;
    const scene::Texture& texture = scene.textures[material.base_color_texture];
    const DVec2 uv[3] = {DVec2(corner[0]->uv), DVec2(corner[1]->uv), DVec2(corner[2]->uv)};
    const DVec2 a = uv[1] - uv[0], b = uv[2] - uv[0];
    const double density = std::abs(a.x * b.y - a.y * b.x) / area;
    const double length = glm::length(direction);
    const double width = out.depth * double(view.pixel_angle()) * length / std::abs(slope);
    const double footprint = width * width * density * std::sqrt(std::abs(slope));
    out.lod = 0.5 * std::log2(footprint * double(texture.width) * double(texture.height));
    out.alpha *= filtered_alpha(scene, texture, interpolated(uv[0], uv[1], uv[2]), out.lod);
    return true;
}

}  // namespace

std::vector<ReferenceLayer> reference_layers(const LayerScene& layers, const PinholeView& view, int x, int y,
                                             double visible_depth, double slack) {
    const DVec3 direction = DMat3(view.world_from_camera) *
                            DVec3((x + 0.5) * view.u_step + view.u_first, (y + 0.5) * view.v_step + view.v_first, -1.0);
    const double end = std::min(visible_depth, double(view.blend_within_m) / glm::length(direction));
    std::vector<ReferenceLayer> out;
    const auto search = [&](const StaticScene& scene, std::uint32_t first_id) {
        for (std::uint32_t i = 0; i < scene.instances.size(); ++i) {
            const scene::Mesh& mesh = scene.meshes[scene.instances[i].mesh];
            for (std::uint32_t t = 0; t < mesh.triangle_count; ++t) {
                const std::uint16_t material = scene.triangle_materials[mesh.first_triangle + t];
                if ((scene.materials[material].flags & scene::kMaterialBlend) == 0) continue;
                ReferenceLayer layer{.instance = first_id + i, .triangle = t};
                if (!meet(scene, scene.instances[i], t, view, direction, layer)) continue;
                if (layer.inside >= -slack && layer.depth > 0.0 && layer.depth < end) out.push_back(layer);
            }
        }
    };
    search(layers.scene, 0);
    if (layers.dynamic != nullptr) search(*layers.dynamic, std::uint32_t(layers.scene.instances.size()));
    return out;
}

}  // namespace ff::farfield
