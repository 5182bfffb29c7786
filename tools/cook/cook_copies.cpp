#include "tools/cook/cook_copies.h"

#include <algorithm>
#include <cmath>
#include <tuple>
#include <utility>
#include <vector>

namespace ff::cook {
namespace {

// The `count` squares of a grid that are nearest to (0, 0), which comes first.
std::vector<std::pair<int, int>> nearest_squares(int count) {
    std::vector<std::pair<int, int>> squares;
    const int reach = static_cast<int>(std::ceil(std::sqrt(static_cast<double>(count)))) + 1;
    for (int z = -reach; z <= reach; ++z)
        for (int x = -reach; x <= reach; ++x) squares.emplace_back(x, z);
    std::sort(squares.begin(), squares.end(), [](const auto& a, const auto& b) {
        const auto distance = [](const auto& s) { return s.first * s.first + s.second * s.second; };
        return std::tuple(distance(a), a.second, a.first) < std::tuple(distance(b), b.second, b.first);
    });
    squares.resize(static_cast<std::size_t>(count));
    return squares;
}

}  // namespace

void copy_static_content(WorldSource& world, const DBox3& bounds, int count) {
    if (count <= 1 || bounds.is_empty()) return;
    const std::size_t originals = world.placements.size(), lamps = world.lamps.size();
    const DVec3 extent = bounds.extent();
    const double step_x = std::ceil(std::max(extent.x, 1.0) * 1.05), step_z = std::ceil(std::max(extent.z, 1.0) * 1.05);
    const auto squares = nearest_squares(count);
    const std::size_t meshes = world.meshes.size();
    for (std::size_t copy = 1; copy < squares.size(); ++copy) {
        const DVec3 offset(squares[copy].first * step_x, 0.0, squares[copy].second * step_z);
        std::vector<std::uint32_t> cloned(meshes, ~0u);
        for (std::size_t i = 0; i < originals; ++i) {
            Placement placement = world.placements[i];
            if (placement.kind == PlacementKind::dynamic) continue;
            placement.position += offset;
            if (placement.kind == PlacementKind::instance) {
                std::uint32_t& clone = cloned[placement.mesh];
                if (clone == ~0u) {
                    clone = static_cast<std::uint32_t>(world.meshes.size());
                    SourceMesh mesh = world.meshes[placement.mesh];  // by value: push_back may move its source
                    world.meshes.push_back(std::move(mesh));
                }
                placement.mesh = clone;
            }
            world.placements.push_back(placement);
        }
        for (std::size_t i = 0; i < lamps; ++i) {
            scene::Lamp lamp = world.lamps[i];
            lamp.position += offset;
            world.lamps.push_back(lamp);
        }
    }
}

}  // namespace ff::cook
