#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "engine/scene/static_scene.h"

namespace ff::scene {

/// Elements [begin, end) of one mesh, counted within it.
struct MeshSlice {
    std::uint32_t mesh = 0;
    std::uint32_t begin = 0, end = 0;
};

/// Cuts the meshes' elements into slices of at most `grain`: even work, whether meshes are many or huge.
/// @param count  a field of Mesh, such as &Mesh::triangle_count
[[nodiscard]] inline std::vector<MeshSlice> slice_meshes(std::span<const Mesh> meshes, std::uint32_t Mesh::*count,
                                                         std::uint32_t grain) {
    std::vector<MeshSlice> slices;
    for (std::uint32_t mesh = 0; mesh < meshes.size(); ++mesh) {
        const std::uint32_t all = meshes[mesh].*count;
        for (std::uint32_t begin = 0; begin < all;) {
            const std::uint32_t end = begin + std::min(grain, all - begin);
            slices.push_back({mesh, begin, end});
            begin = end;
        }
    }
    return slices;
}

}  // namespace ff::scene
