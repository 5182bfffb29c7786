#pragma once
// What the set-up of 16 triangles reads, gathered from the scene into arrays that vectors can load.

#include <cstdint>

#include "engine/shading/shade_frame.h"
#include "engine/shading/tile_records.h"

namespace ff::shading {

struct alignas(64) RawBlock {
    float position[9][kBlock];         ///< corner 0 x, y, z; corner 1; corner 2; mesh space
    float world_from_mesh[9][kBlock];  ///< by columns
    float offset[3][kBlock];           ///< mesh origin relative to the viewer, world axes
    float uv[6][kBlock];
    std::int32_t normal[3][kBlock];         ///< octahedral, as VertexAttributes::normal_oct
    std::uint32_t vertex_color[3][kBlock];  ///< RGBA8 linear
    float color[3][kBlock];                 ///< material's base colour
    std::int32_t info[kBlock];              ///< kRowInfo
    std::int32_t texture[kBlock];           ///< kRowTexture
    std::int32_t emissive_info[kBlock];     ///< kRowEmissiveInfo
    std::uint32_t prelit[kBlock];           ///< mean base colour, RGBA8 linear
    float prelit_emissive[3][kBlock];
    std::int32_t any_bits;  ///< union of info's lane bits
};

/// What a whole tile needs, known before its triangles are read.
struct TileNeeds {
    bool full = false;            ///< some pixel shades with textures
    bool light_by_pixel = false;  ///< lamps, wetness or snow: no triangle is lit as a whole
    bool prelit = false;          ///< some pixel is beyond ShadeSettings::prelit_beyond_m
};

/// Loads names [first, first + count), count <= 16, and writes the quads of their records that need no arithmetic.
void load_raw_block(const ShadeFrame& frame, const TriangleName* names, int count, TileNeeds needs, RawBlock& raw,
                    float* record);

/// Asks for the vertices of the named triangles, whose indices are already under way.
void prefetch_vertices(const ShadeFrame& frame, const TriangleName* names, int count);

}  // namespace ff::shading
