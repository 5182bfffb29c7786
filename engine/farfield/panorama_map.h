#pragma once
// The panorama's data and the geometry of its cube; what panorama*.cpp share.

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "engine/farfield/panorama.h"

namespace ff::farfield {

inline constexpr int kRecordCount = 4096;         ///< ring of confidence records
inline constexpr int kRecordLifetime = 3072;      ///< records made until a texel of an old one is forgotten
inline constexpr int kSweepSteps = 512;           ///< records made while the whole map is searched for old ones once
inline constexpr std::uint16_t kNeverTraced = 0;  ///< P0's lowest-confidence record
inline constexpr std::uint16_t kMixedRecords = 0xFFFFu;

/// The alpha byte of a texel's colour: the state of the 2 x 2 texels right of and below it, and whether it is marked.
inline constexpr std::uint32_t kQuadHoles = 0;  ///< not all four were ever cast
inline constexpr std::uint32_t kQuadNoise =
    64;  ///< more than two things in different colours, or strong contrast nearby
inline constexpr std::uint32_t kQuadEdge = 128;  ///< two things in different colours
inline constexpr std::uint32_t kQuadSmooth = 192;
inline constexpr std::uint32_t kQuadStates = 192;
inline constexpr std::uint32_t kTexelMarked = 1;

/// P0 Figure 6.
struct ConfidenceRecord {
    WorldPos position{0.0};
    std::uint64_t frame = 0;
};

/// What is known of 16 x 16 texels at once.
struct TexelTile {
    std::uint16_t record = kNeverTraced;  ///< of all texels, or kMixedRecords
    bool complete = false;                ///< every texel was cast
    bool any_marked = false;              ///< of its texels
    float nearest_m = 0;                  ///< least depth of any texel along the face's axis
};

/// The map without its visibility: six faces below each other.
struct PanoramaMap {
    int size = 0;        ///< texels a side of a face
    int tiles_side = 0;  ///< texel tiles a side of a face
    float extent = 1;    ///< tangent of a face's half angle: a bit over 1, so that no lookup needs two faces at once
    // Only the pages of texels that were cast are ever touched: all zero is "never cast".
    VisibilityBuffer visibility;            // 75 MiB at 1024; the depth is along the face's axis
    ZeroPageVector<std::uint32_t> colors;   // 25 MiB at 1024; alpha: see above
    ZeroPageVector<std::uint16_t> records;  // 12 MiB at 1024
    ZeroPageVector<std::uint8_t> light;     // 6 MiB at 1024; empty until somebody asks for it
    std::vector<TexelTile> tiles;           ///< row-major, tiles_side a row, faces below each other

    [[nodiscard]] TexelTile& tile_at(int texel_x, int texel_row) {
        return tiles[std::size_t(texel_row / kTileSize) * std::size_t(tiles_side) + std::size_t(texel_x / kTileSize)];
    }
    [[nodiscard]] std::size_t index(int texel_x, int texel_row) const {
        return std::size_t(texel_row) * std::size_t(size) + std::size_t(texel_x);
    }
};

/// A direction on the cube: face, and the coordinates a / axis, b / axis on it (right and up, within [-1, 1]).
struct FacePoint {
    int face;
    float a, b;
    float axis;  ///< length of the direction along the face's axis, > 0
};

/// A direction on the plane of a given face; outside of [-1, 1] beside it, axis <= 0 behind it.
/// Faces and axes are those of make_cube_face_view.
inline FacePoint point_on_face(const Vec3& d, int face) {
    const float sign = face % 2 == 0 ? 1.0f : -1.0f;
    if (face < 2) return {face, sign * d.z / (sign * d.x), d.y / (sign * d.x), sign * d.x};
    if (face < 4) return {face, d.x / (sign * d.y), sign * d.z / (sign * d.y), sign * d.y};
    return {face, -sign * d.x / (sign * d.z), d.y / (sign * d.z), sign * d.z};
}

/// A direction on the face that it falls into.
inline FacePoint face_point(const Vec3& d) {
    const float x = std::fabs(d.x), y = std::fabs(d.y), z = std::fabs(d.z);
    if (x >= y && x >= z) return {d.x < 0 ? 1 : 0, (d.x < 0 ? -d.z : d.z) / x, d.y / x, x};
    if (y >= z) return {d.y < 0 ? 3 : 2, d.x / y, (d.y < 0 ? -d.z : d.z) / y, y};
    return {d.z < 0 ? 5 : 4, (d.z < 0 ? d.x : -d.x) / z, d.y / z, z};
}

/// Texel coordinates on a face; whole numbers are texel centres. x to the right, y down from the face's first row.
inline float texel_x(const PanoramaMap& map, float a) {
    return a * (0.5f * float(map.size) / map.extent) + (0.5f * float(map.size) - 0.5f);
}
inline float texel_y(const PanoramaMap& map, float b) {
    return b * (-0.5f * float(map.size) / map.extent) + (0.5f * float(map.size) - 0.5f);
}

}  // namespace ff::farfield
