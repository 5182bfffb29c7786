// Which instances are drawn, in which order, and their matrices; the drawing itself is in opacity_raster.cpp.
#include "engine/farfield/opacity_buffer.h"

#include <algorithm>
#include <cmath>
#include <glm/matrix.hpp>

#include "engine/core/check.h"
#include "engine/farfield/opacity_raster.h"

namespace ff::farfield {

OpacityCost OpacityRaster::draw(const scene::StaticScene& scene, std::span<const scene::Instance> dynamic,
                                std::span<const std::uint32_t> instance_ids, const PinholeView& view,
                                PixelMask& covered) {
    covered.reset(view.width, view.height);
    OpacityCost cost;
    if (covered.tiles.empty()) return cost;
    full_.assign(covered.tiles.size(), 0);
    OpacityTarget target{covered.tiles.data(), full_.data(), covered.tiles_x,          covered.tiles_y,
                         view.width,           view.height,  int(covered.tiles.size())};

    const auto instance_of = [&](std::uint32_t id) -> const scene::Instance& {
        return id < scene.instances.size() ? scene.instances[id] : dynamic[id - scene.instances.size()];
    };
    order_.clear();
    for (const std::uint32_t id : instance_ids) {
        FF_CHECK(id < scene.instances.size() + dynamic.size(), "instance {} of {} and {} dynamic ones", id,
                 scene.instances.size(), dynamic.size());
        order_.push_back({distance_to(instance_of(id).bounds, view.position), id});
    }
    std::sort(order_.begin(), order_.end(), [](const Entry& a, const Entry& b) {
        return a.distance != b.distance ? a.distance < b.distance : a.id < b.id;
    });

    const DMat3 camera_from_world = glm::transpose(DMat3(view.world_from_camera));
    for (const Entry& entry : order_) {
        const scene::Instance& instance = instance_of(entry.id);
        const scene::Mesh& mesh = scene.meshes[instance.mesh];
        if (mesh.node_count == 0 || target.open_tiles == 0) continue;
        ++cost.instances;
        const DMat3 linear = camera_from_world * DMat3(instance.world_from_mesh);
        const DVec3 offset = camera_from_world * (instance.position - view.position);
        const auto form = [&](int axis, double scale) {
            return OpacityMesh::Form{float(linear[0][axis] * scale), float(linear[1][axis] * scale),
                                     float(linear[2][axis] * scale), float(offset[axis] * scale)};
        };
        OpacityMesh drawing;
        drawing.pixel_x = form(0, 1.0 / double(view.u_step));
        drawing.pixel_y = form(1, 1.0 / double(view.v_step));
        drawing.depth = form(2, -1.0);
        drawing.center_x = -view.u_first / view.u_step;
        drawing.center_y = -view.v_first / view.v_step;
        drawing.near_plane_m = settings_.near_plane_m;
        drawing.inset_px = settings_.inset_px;
        drawing.pixels_per_unit =
            std::max(1.0f / std::abs(view.u_step), 1.0f / std::abs(view.v_step)) +
            float(std::max(view.width, view.height));  // depth rounds as well, and moves what is off centre
        // Positions round, here and in whoever rasterises, to a few units in the last place of the largest term.
        const Vec3 reach = glm::max(glm::abs(mesh.bounds.low), glm::abs(mesh.bounds.high));
        double size = 0.0;
        for (int axis = 0; axis < 3; ++axis)
            size = std::max(size, std::abs(linear[0][axis]) * double(reach.x) +
                                      std::abs(linear[1][axis]) * double(reach.y) +
                                      std::abs(linear[2][axis]) * double(reach.z) + std::abs(offset[axis]));
        drawing.inset_m = float(size * 6e-7);
        drawing.nodes = scene.mesh_nodes.data() + mesh.first_node;
        drawing.leaves = scene.mesh_leaves.data() + mesh.first_leaf;
        draw_opacity_mesh(drawing, target, cost);
    }
    return cost;
}

std::uint64_t list_uncovered(const PixelMask& covered, const PixelMask* sky, std::vector<TileRequest>& out) {
    FF_CHECK(sky == nullptr || (sky->width == covered.width && sky->height == covered.height),
             "sky mask of {} x {} for {} x {}", sky->width, sky->height, covered.width, covered.height);
    out.clear();
    std::uint64_t pixels = 0;
    for (int tile_y = 0; tile_y < covered.tiles_y; ++tile_y)
        for (int tile_x = 0; tile_x < covered.tiles_x; ++tile_x) {
            const std::size_t index = std::size_t(tile_y) * std::size_t(covered.tiles_x) + std::size_t(tile_x);
            TileRequest request;
            request.x = std::uint16_t(tile_x * kTileSize);
            request.y = std::uint16_t(tile_y * kTileSize);
            const int columns = std::min(kTileSize, covered.width - tile_x * kTileSize);
            const int rows = std::min(kTileSize, covered.height - tile_y * kTileSize);
            int count = 0;
            for (int j = 0; j < rows; ++j) {
                std::uint32_t known = covered.tiles[index].rows[j];
                if (sky) known |= sky->tiles[index].rows[j];
                request.rows[j] = std::uint16_t(~known & ((1u << columns) - 1u));
                count += std::popcount(request.rows[j]);
            }
            if (count == 0) continue;
            pixels += std::uint64_t(count);
            out.push_back(request);
        }
    return pixels;
}

}  // namespace ff::farfield
