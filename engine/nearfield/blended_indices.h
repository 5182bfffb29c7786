#pragma once

#include <cstdint>
#include <vector>

#include "engine/nearfield/draw_list.h"

namespace ff::nearfield {

/// Triangles of a list's blended draws, each draw's own from far to near by the distance of their middles. Between
/// draws the list's order holds (far instances first), so interleaved instances may still blend out of order.
struct BlendedIndices {
    std::vector<std::uint32_t> indices;      ///< of all draws, in the list's order
    std::vector<std::uint32_t> first_index;  ///< [list.blended.size()]

    void sort(const scene::StaticScene& scene, const SceneLayout& layout, const DrawList& list);

  private:
    struct Key {
        float distance2 = 0.0f;
        std::uint32_t triangle = 0;  ///< scene's order, within the mesh
    };
    std::vector<Key> keys_;
};

}  // namespace ff::nearfield
