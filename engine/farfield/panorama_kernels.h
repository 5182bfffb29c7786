#pragma once
// The inner loops of the panorama, for one tile each.

#include <array>
#include <cstdint>
#include <span>

#include "engine/farfield/panorama_map.h"

namespace ff::farfield::panorama {

/// Why a pixel might be cast, worst highest. Between kClassFirstStale and kClassLastStale: bins of parallax or metres.
inline constexpr std::uint8_t kClassGood = 0;
inline constexpr std::uint8_t kClassEdge = 1;
inline constexpr std::uint8_t kClassNoise = 2;
inline constexpr std::uint8_t kClassFirstStale = 3;
inline constexpr std::uint8_t kClassLastStale = 254;
inline constexpr std::uint8_t kClassNever = 255;

/// Eight bins per power of two from 2^-12 on: the exponent and three bits of the mantissa.
inline constexpr std::int32_t kFirstBin = 8 * (127 - 12);
inline constexpr int kBinShift = 20;
[[nodiscard]] float bin_upper_end(std::uint8_t bin);
[[nodiscard]] std::uint8_t bin_of(float value);

/// The pixels asked for of one tile by what became of them: bit i of a row is its i-th pixel.
struct alignas(64) TileClasses {
    using Rows = std::array<std::uint16_t, kTileSize>;
    Rows edge;   ///< kClassEdge
    Rows noise;  ///< kClassNoise
    Rows worse;  ///< kClassFirstStale and above, class by class in `classes`
    /// The upper left of the four texels around each edge and noise pixel, row by row, as indices into the map.
    std::array<std::int32_t, kTileSize * kTileSize> quads;
    std::array<std::uint8_t, kTileSize * kTileSize> classes;   ///< row-major; valid at `worse` pixels
    std::array<std::uint8_t, kTileSize * kTileSize> parallax;  ///< bins; valid where parallax_differs
    bool any = false;                                          ///< some pixel is not good
    bool parallax_differs = false;                             ///< pixel by pixel; else all have the parallax below
    std::uint8_t tile_parallax = 0;

    [[nodiscard]] std::uint8_t class_at(int row, int column) const {
        const auto j = std::size_t(row);
        const std::uint32_t bit = 1u << column;
        if ((worse[j] & bit) != 0) return classes[j * kTileSize + std::size_t(column)];
        if ((noise[j] & bit) != 0) return kClassNoise;
        return (edge[j] & bit) != 0 ? kClassEdge : kClassGood;
    }
};

struct LookupJob {
    const PanoramaMap* map = nullptr;
    const PinholeView* view = nullptr;
    PanoramaTarget target;
    /// The viewer's move since each record, camera axes, metres; [kRecordCount].
    const float* moved_x = nullptr;
    const float* moved_y = nullptr;
    const float* moved_z = nullptr;
    float focal_px = 0;
    bool by_distance = false;
    float limit = 0;  ///< pixels or metres
};

/// Texels that a pixel tile looks at, where all of them lie on one face.
struct TileFootprint {
    int face = -1;                       ///< -1: more than one
    int x0 = 0, x1 = 0, y0 = 0, y1 = 0;  ///< inclusive; rows of the whole map
};
[[nodiscard]] TileFootprint footprint_of(const PanoramaMap& map, const PinholeView& view, const TileRequest& tile);

/// Upper bound of the parallax of any texel of a tile of texels, seen within `view`.
[[nodiscard]] float tile_parallax_bound(const LookupJob& job, const TexelTile& tile);
/// Whether all texels of a tile of texels may be used as they are.
[[nodiscard]] bool is_tile_good(const LookupJob& job, const TexelTile& tile);

/// Asks the memory for the colours that a lookup of this footprint will read.
void prefetch_colors(const PanoramaMap& map, const TileFootprint& footprint);

/// Writes what the map knows of the wanted pixels to the target, and sorts them into classes.
/// @param footprint  of the tile
void lookup_tile(const LookupJob& job, const TileRequest& tile, const TileFootprint& footprint, TileClasses& out);

/// Of 255, in any channel; see PanoramaSettings.
struct ContrastLimits {
    int edge = 0, strong = 0;
};

/// Texels of a tile, inclusive; nothing as it is made.
struct TexelBox {
    std::uint8_t x0 = kTileSize, x1 = 0, y0 = kTileSize, y1 = 0;
};
/// The quads of a tile to compute anew when the neighbour that lies (dx, dy) tiles away from the tile has changed.
[[nodiscard]] TexelBox quads_that_see(int dx, int dy);

/// Computes quad states (alpha bytes) of one tile of texels: at least those of `box`. Reads a texel to the left and
/// above, two to the right and below.
void update_quads(PanoramaMap& map, int tile_x, int tile_row, const TexelBox& box, const ContrastLimits& contrast);

}  // namespace ff::farfield::panorama
