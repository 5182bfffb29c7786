#pragma once
// What the shading of one 16 x 16 tile needs of each triangle that it sees, set up once per tile and triangle.
//
// Records are blocks of 16 triangles, structure of arrays: the set-up writes them with vectors, a row of pixels that
// sees one triangle broadcasts from them, and a row that sees many gathers from memory that is still in L1.

#include <cstdint>

#include "engine/farfield/visibility_buffer.h"

namespace ff::shading {

inline constexpr int kTilePixels = farfield::kTileSize * farfield::kTileSize;
inline constexpr int kBlock = 16;  ///< triangles a block

/// Rows of a block. "Affine" rows are three: factors of the ray's u and v, and a constant.
enum Row : int {
    kRowW1 = 0,            ///< affine: barycentric of corner 1, times S
    kRowW2 = 3,            ///< affine: of corner 2, times S
    kRowS = 6,             ///< affine: ray direction on the triangle's unit normal
    kRowU = 9,             ///< texture u at corner 0, and its change to corners 1 and 2
    kRowV = 12,            //
    kRowColor = 15,        ///< RGB factor: material, times vertex colour if constant, times light if constant
    kRowFootprint = 18,    ///< uv area a pixel covers = this * (1 + u^2 + v^2) / |S|^3.5
    kRowInfo = 19,         ///< int: texture_info of the base colour, and the lane bits below
    kRowTexture = 20,      ///< int: its first texel
    kRowEmissive = 21,     ///< RGB
    kRowNormal = 24,       ///< x, y, z each: at corner 0, changes to 1 and 2; world, any length
    kRowFacing = 33,       ///< likewise: the normal on the side that faces the viewer
    kRowVertexColor = 36,  ///< r, g, b each: at corner 0, changes to 1 and 2
    kRowMetallic = 45,
    kRowRoughness = 46,
    kRowEmissiveInfo = 47,      ///< int
    kRowEmissiveTexture = 48,   ///< int
    kRowRoughnessInfo = 49,     ///< int: of the metallic-roughness texture
    kRowRoughnessTexture = 50,  ///< int
    kRowPrelit = 51,            ///< RGB, lit
    kRowCount = 54
};
inline constexpr int kBlockFloats = kRowCount * kBlock;

// Lane bits of kRowInfo and the emissive and roughness infos, above texture_info's. The sign bit stays free.
inline constexpr std::int32_t kLaneTextured = 1 << 12;
inline constexpr std::int32_t kLaneUnlit = 1 << 13;
inline constexpr std::int32_t kLanePixelLit = 1 << 14;     ///< light depends on the pixel
inline constexpr std::int32_t kLaneVertexColor = 1 << 15;  ///< colour differs between corners
inline constexpr std::int32_t kLaneSpecular = 1 << 16;
inline constexpr std::int32_t kLaneEmissive = 1 << 17;

/// One triangle as named by the visibility buffer.
struct TriangleName {
    std::uint32_t instance, triangle;
};

/// Scratch of one worker, reused from tile to tile. 64 KiB.
struct TileScratch {
    alignas(64) float records[kTilePixels / kBlock * kBlockFloats];
    alignas(64) std::int32_t offset[kTilePixels];  ///< per pixel: float offset of its record; -1: sky
    TriangleName names[kTilePixels];               ///< unique triangles of the tile, in order of appearance
    std::uint16_t table[512];                      ///< open addressing: index of a name + 1
    int count = 0;                                 ///< of names
};

/// Float offset of a record's row 0.
[[nodiscard]] inline constexpr std::int32_t record_offset(int index) {
    return index / kBlock * kBlockFloats + index % kBlock;
}

}  // namespace ff::shading
