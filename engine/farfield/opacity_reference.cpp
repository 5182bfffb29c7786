// The opacity buffer the plain way: each triangle in double, each pixel centre against its edges.
#include <algorithm>
#include <array>
#include <cmath>
#include <glm/matrix.hpp>

#include "engine/farfield/opacity_buffer.h"

namespace ff::farfield {
namespace {

/// Draws the convex polygon of camera-space points (x, y, depth), all with depth > 0.
void draw_polygon(const std::array<DVec3, 4>& polygon, int count, const PinholeView& view, PixelMask& covered) {
    std::array<double, 4> x{}, y{};
    double low_x = 1e30, high_x = -1e30, low_y = 1e30, high_y = -1e30, area = 0.0;
    for (int i = 0; i < count; ++i) {
        const DVec3& p = polygon[std::size_t(i)];
        x[std::size_t(i)] = (p.x / p.z - double(view.u_first)) / double(view.u_step);
        y[std::size_t(i)] = (p.y / p.z - double(view.v_first)) / double(view.v_step);
        low_x = std::min(low_x, x[std::size_t(i)]);
        high_x = std::max(high_x, x[std::size_t(i)]);
        low_y = std::min(low_y, y[std::size_t(i)]);
        high_y = std::max(high_y, y[std::size_t(i)]);
    }
    for (std::size_t i = 0; i < std::size_t(count); ++i) {
        const std::size_t next = (i + 1) % std::size_t(count);
        area += x[i] * y[next] - x[next] * y[i];
    }
    if (area == 0.0) return;
    const double sign = area > 0.0 ? 1.0 : -1.0;
    const int first_x = int(std::clamp(std::floor(low_x), 0.0, double(view.width)));
    const int last_x = int(std::clamp(std::ceil(high_x), 0.0, double(view.width)));
    const int first_y = int(std::clamp(std::floor(low_y), 0.0, double(view.height)));
    const int last_y = int(std::clamp(std::ceil(high_y), 0.0, double(view.height)));
    for (int py = first_y; py < last_y; ++py)
        for (int px = first_x; px < last_x; ++px) {
            const double cx = px + 0.5, cy = py + 0.5;
            bool inside = true;
            for (std::size_t i = 0; i < std::size_t(count) && inside; ++i) {
                const std::size_t next = (i + 1) % std::size_t(count);
                inside = sign * ((x[next] - x[i]) * (cy - y[i]) - (y[next] - y[i]) * (cx - x[i])) >= 0.0;
            }
            if (inside) covered.set(px, py);
        }
}

}  // namespace

void draw_opacity_reference(const scene::StaticScene& scene, std::span<const scene::Instance> dynamic,
                            std::span<const std::uint32_t> instance_ids, const PinholeView& view, double near_plane_m,
                            PixelMask& covered) {
    covered.reset(view.width, view.height);
    const DMat3 camera_from_world = glm::transpose(DMat3(view.world_from_camera));
    for (const std::uint32_t id : instance_ids) {
        const scene::Instance& instance =
            id < scene.instances.size() ? scene.instances[id] : dynamic[id - scene.instances.size()];
        const scene::Mesh& mesh = scene.meshes[instance.mesh];
        for (std::uint32_t t = mesh.first_triangle; t < mesh.first_triangle + mesh.triangle_count; ++t) {
            const scene::Material& material = scene.materials[scene.triangle_materials[t]];
            if (material.flags & (scene::kMaterialAlphaMask | scene::kMaterialBlend)) continue;
            std::array<DVec3, 3> corner;
            for (std::size_t i = 0; i < 3; ++i) {
                const Vec3& p = scene.positions[mesh.first_vertex + scene.indices[std::size_t(t) * 3 + i]];
                const DVec3 camera = camera_from_world *
                                     (DMat3(instance.world_from_mesh) * DVec3(p) + (instance.position - view.position));
                corner[i] = {camera.x, camera.y, -camera.z};
            }
            std::array<DVec3, 4> polygon;
            int count = 0;
            for (std::size_t i = 0; i < 3; ++i) {
                const DVec3 &a = corner[i], &b = corner[(i + 1) % 3];
                if (a.z >= near_plane_m) polygon[std::size_t(count++)] = a;
                if ((a.z >= near_plane_m) != (b.z >= near_plane_m)) {
                    const double s = (near_plane_m - a.z) / (b.z - a.z);
                    polygon[std::size_t(count++)] = {a.x + s * (b.x - a.x), a.y + s * (b.y - a.y), near_plane_m};
                }
            }
            if (count >= 3) draw_polygon(polygon, count, view, covered);
        }
    }
}

}  // namespace ff::farfield
