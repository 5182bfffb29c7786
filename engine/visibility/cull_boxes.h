#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "engine/visibility/frustum.h"

namespace ff::visibility {

enum class Overlap : std::uint32_t { outside, intersects, inside };

/// Boxes as centres and half extents, structure of arrays, float relative to an origin that the caller keeps; padded
/// so that whole vectors may be read past the end.
struct BoxArray {
    std::vector<float> center_x, center_y, center_z;
    std::vector<float> half_x, half_y, half_z;  ///< rounded outwards; negative for an empty box
    std::size_t count = 0;

    /// Appends a box given in the world. The float box contains the double one.
    void add(const DBox3& box, const WorldPos& origin);
    void finish();  ///< after the last add
};

/// Tests boxes [begin, begin + count) of the array.
/// @param origin  what the boxes are relative to
/// @param out     [count] and up to 15 more are written
/// Conservative: a box that the frustum touches in double is never `outside`, one that it does not wholly contain is
/// never `inside`.
void cull_boxes(const Frustum& frustum, const BoxArray& boxes, const WorldPos& origin, std::size_t begin,
                std::size_t count, std::span<Overlap> out);

inline constexpr std::size_t kCullPadding = 16;  ///< widest vector of floats

}  // namespace ff::visibility
