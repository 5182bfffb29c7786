#pragma once
// What the shading of one 16 x 16 tile needs of each triangle that it sees, set up once per tile and triangle.
//
// Records are arrays of structures, in quads of four rows: a vector of pixels that see one triangle broadcasts from its
// record, one that sees several loads the quad of each and transposes, which is faster than to gather the rows.

#include <algorithm>
#include <cstdint>
#include <iterator>

#include "engine/farfield/visibility_buffer.h"

namespace ff::shading {

inline constexpr int kTilePixels = farfield::kTileSize * farfield::kTileSize;
inline constexpr int kBlock = 16;  ///< triangles that are read and set up together

/// First rows of the quads of a record, and single rows that fill a quad's last place. "Affine" rows are three: factors
/// of the ray's u and v, and a constant. "Corners" are three: the value at corner 0, its changes to corners 1 and 2.
enum Row : int {
    kQuadS = 0,             ///< affine: ray direction on the triangle's unit normal
    kRowFootprint = 3,      ///< uv area a pixel covers = this * (1 + u^2 + v^2) / |S|^3.5
    kQuadW1 = 4,            ///< affine: barycentric of corner 1, times S
    kRowInfo = 7,           ///< int: texture_info of the base colour, and the lane bits below
    kQuadW2 = 8,            ///< affine: of corner 2, times S
    kRowTexture = 11,       ///< int: base colour's first texel
    kQuadU = 12,            ///< corners: texture u
    kRowSway = 15,          ///< texture widths a metre; 0 where no wind moves the picture
    kQuadV = 16,            ///< corners: texture v
    kQuadColor = 20,        ///< RGB factor: material, times vertex colour if constant, times light if constant
    kRowEmissiveInfo = 23,  ///< int
    kQuadNormalX = 24,      ///< corners: normal in the world, any length; the last places are the corners of the
    kQuadNormalY = 28,      ///< normal on the side that faces the viewer
    kQuadNormalZ = 32,      //
    kQuadVertexRed = 36,    ///< corners
    kQuadVertexGreen = 40,  //
    kQuadVertexBlue = 44,   //
    kQuadEmissive = 48,     ///< RGB, and int: its texture's first texel
    kQuadSpecular = 52,     ///< metallic (of water: strength of waves), roughness, int: info and texel of their texture
    kQuadPrelit = 56,       ///< RGB, lit
    kQuadShade = 60,        ///< kQuadColor's RGB where the sun is hidden; written with ShadeSettings::sun_seen only
    kQuadPrelitShade = 64,  ///< kQuadPrelit's, likewise
    kRecordFloats = 68
};

// Lane bits of the infos, above texture_info's. The sign bit stays free.
inline constexpr std::int32_t kLaneTextured = 1 << 12;
inline constexpr std::int32_t kLaneUnlit = 1 << 13;
inline constexpr std::int32_t kLanePixelLit = 1 << 14;     ///< light depends on the pixel
inline constexpr std::int32_t kLaneVertexColor = 1 << 15;  ///< colour differs between corners
inline constexpr std::int32_t kLaneSpecular = 1 << 16;
inline constexpr std::int32_t kLaneEmissive = 1 << 17;
inline constexpr std::int32_t kLaneWraps = 1 << 18;   ///< some texture of it clamps or mirrors
inline constexpr std::int32_t kLaneWater = 1 << 19;   ///< with waves
inline constexpr std::int32_t kLaneMirror = 1 << 20;  ///< shows the world
inline constexpr std::int32_t kLaneFades = 1 << 21;   ///< but only from nearby
inline constexpr std::int32_t kLaneSways = 1 << 22;   ///< wind moves its picture

/// One triangle as named by the visibility buffer.
struct TriangleName {
    std::uint32_t instance, triangle;
};

/// Float offset of a record. The last one is of the sky: all zero.
[[nodiscard]] inline constexpr std::int32_t record_offset(int index) {
    return index * kRecordFloats;
}
inline constexpr std::int32_t kSkyOffset = record_offset(kTilePixels);

/// Scratch of one worker, reused from tile to tile. 75 KiB.
struct TileScratch {
    alignas(64) float records[kSkyOffset + kRecordFloats];
    alignas(64) std::int32_t offset[kTilePixels + farfield::kTileSize];  ///< per pixel, of its record; a row to spare
    TriangleName names[kTilePixels];   ///< unique triangles of the tile, in order of appearance
    std::uint16_t slots[kTilePixels];  ///< of the names in the table
    std::uint16_t table[512];          ///< open addressing: index of a name + 1; 0 between tiles
    int count = 0;                     ///< of names

    TileScratch() {
        std::fill(std::begin(records) + kSkyOffset, std::end(records), 0.0f);
        std::fill(std::begin(table), std::end(table), std::uint16_t(0));
    }
};

}  // namespace ff::shading
