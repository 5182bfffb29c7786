#pragma once
// Closed meshes whose vertices are multiples of 1/64 m, so that rays through their vertices and edges can be written
// down exactly in float32, and pictures of which pixel centres lie exactly on edges.

#include <cstdint>
#include <vector>

#include "engine/math/camera.h"
#include "engine/scene/scene_data.h"
#include "tests/support/worlds.h"

namespace ff::hardcases {

/// A bumpy ball around the origin, 8 to 40 m across, vertices shared; the origin lies within.
struct LatticeBall {
    scene::MeshSource mesh;    ///< faces turn outwards counter-clockwise
    float inner_radius_m = 0;  ///< everything nearer to the origin lies within
};
[[nodiscard]] LatticeBall make_lattice_ball(test::Random& random);

/// The edges, as pairs of vertices, all of whose neighbouring faces look away from a lattice point within: a ray from
/// the point through such an edge, or through its ends, certainly passes from inside to outside there. Exact.
[[nodiscard]] std::vector<std::uint32_t> edges_turned_away(const LatticeBall& ball, const DVec3& point);

/// One of the 24 turns by right angles, or its mirror image: exact in float32.
[[nodiscard]] Mat3 random_lattice_turn(test::Random& random, bool may_mirror);

/// A view whose pixel centres are exact in float32, and a closed mesh whose front has its vertices on pixel centres:
/// rows, columns and diagonals of it run exactly through others.
struct PixelLattice {
    PinholeView view;        ///< 64 x 64, 90 degrees
    scene::MeshSource mesh;  ///< relative to the eye
    int low = 0, high = 0;  ///< the outline's first and last pixel, both ways; beyond the image where the eye is inside
    bool eye_inside = false;  ///< the mesh is closed behind the eye; else behind the front
};
[[nodiscard]] PixelLattice make_pixel_lattice(test::Random& random);

}  // namespace ff::hardcases
