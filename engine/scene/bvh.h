#pragma once
// The 16-wide bounding volume hierarchies that the pack carries: one per mesh, and one over all instances. Built by
// engine/farfield/bvh_builder.h when cooking; read in place.

#include <cstdint>

namespace ff::scene {

inline constexpr int kBvhWidth = 16;
inline constexpr std::uint32_t kBvhEmpty = 0xFFFFFFFFu;    ///< no child in this lane
inline constexpr std::uint32_t kBvhLeafBit = 0x80000000u;  ///< the lane holds a leaf, id in the other bits

/// Boxes of up to 16 children, structure of arrays, a cache line a row. Empty lanes have low = +inf, high = -inf.
struct alignas(64) BvhNode {
    float low_x[16], low_y[16], low_z[16];
    float high_x[16], high_y[16], high_z[16];
    std::uint32_t child[16];  ///< node id, or kBvhLeafBit | leaf id, relative to the mesh's first; or kBvhEmpty
};
static_assert(sizeof(BvhNode) == 448);

/// Up to 16 triangles of a mesh, consecutive in its order, as vertices and 8-bit corners: a mesh's triangles share
/// vertices, so a leaf is half the bytes of three corners each, and every vertex is transformed once. A leaf of at most
/// kMaxDirect triangles shares nothing: corner c of triangle i is vertex c * kMaxDirect + i (triangles beyond the last
/// repeat it), so that registers of 8 are filled without look-ups.
struct alignas(64) BvhLeaf {
    static constexpr int kMaxTriangles = 16;
    static constexpr int kMaxVertices = 32;
    static constexpr int kMaxDirect = 8;
    float x[32], y[32], z[32];      ///< mesh space; unused lanes repeat the last vertex
    std::uint8_t corner[3][16];     ///< vertex of each triangle's corner; unused triangles are all 0
    std::uint32_t first_triangle;   ///< within the mesh
    std::uint16_t triangle_count;   ///< 1..16
    std::uint16_t vertex_count;     ///< 3..32; 24 in a leaf of at most kMaxDirect triangles
    std::uint16_t alpha_triangles;  ///< bit per triangle whose material is masked or blended
    std::uint16_t reserved[3];
};
static_assert(sizeof(BvhLeaf) == 448);

}  // namespace ff::scene
