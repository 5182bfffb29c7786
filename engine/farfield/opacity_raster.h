#pragma once
// Inner interface between OpacityRaster and its SIMD kernel; not for users.

#include <cstdint>

#include "engine/farfield/opacity_buffer.h"

namespace ff::farfield {

/// What the kernel draws into.
struct OpacityTarget {
    TileMask* tiles;
    std::uint8_t* full;  ///< per tile
    int tiles_x, tiles_y;
    int width, height;
    int open_tiles;  ///< not yet full
};

/// A mesh as seen from the camera. Forms are linear in mesh coordinates: f(p) = x * p.x + y * p.y + z * p.z + w.
struct OpacityMesh {
    struct Form {
        float x, y, z, w;
    };
    Form pixel_x, pixel_y;  ///< pixel coordinate = form / depth + center
    Form depth;             ///< along the view axis, metres
    float center_x, center_y;
    float near_plane_m;
    float inset_px;
    float inset_m;  ///< rounding of positions, metres: adds inset_m * pixels_per_m / depth pixels
    float pixels_per_unit;
    const scene::BvhNode* nodes;
    const scene::BvhLeaf* leaves;
};

void draw_opacity_mesh(const OpacityMesh& mesh, OpacityTarget& target, OpacityCost& cost);

}  // namespace ff::farfield
