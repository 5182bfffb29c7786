#pragma once
// Inner interface between HorizonMap and its SIMD kernel; not for users.

#include <cstdint>
#include <span>

namespace ff::farfield {

inline constexpr std::uint32_t kNoSquare = 0xFFFFFFFFu;
inline constexpr int kMaxHorizonColumns = 8192;

/// Bounds of |x| and |z| of the unit directions in each traced column, a little too wide; readable 16 elements beyond.
struct HorizonWedges {
    int columns = 0;
    const float *max_x, *max_z, *min_x, *min_z;
    float column_margin = 0;  ///< columns by which intervals are widened
    float near_distance = 0;  ///< nothing counts as nearer; in the unit of the walk
    float inverse_near = 0;   ///< its inverse, +inf for 0
};

/// All lengths in squares of level 0, all positions relative to the eye's grid corner (eye_x, eye_z) + (frac_x,
/// frac_z).
struct HorizonTraceInput {
    const float* level_heights[13];  ///< [level]: metres over the grid's base, row-major
    int size_log2 = 0;
    int finest_level = 0;  ///< squares of this level are not divided
    int eye_x = 0, eye_z = 0;
    float frac_x = 0, frac_z = 0;
    float eye_height_m = 0;  ///< over the grid's base, rounded down
    float squares_per_m = 1;
    float roam = 0;   ///< the eye may be anywhere within so many squares of its place, horizontally
    float climb = 0;  ///< and so many above or below it
    HorizonWedges wedges;
};

/// Raises `tangents` to the maximum over all squares. Columns that are +inf on entry cost and change nothing.
/// @param tangents  [columns + 16], the 16 beyond are +inf
/// @param winner    [columns + 16]; on entry a guess which square (z << size_log2 | x, of the finest level) makes each
///                  column, kNoSquare where none; on return the one that did (of a coarser square, its first). Only
///                  time depends on the guess.
/// @return squares whose bound was computed.
std::uint32_t trace_horizon(const HorizonTraceInput& input, float* tangents, std::uint32_t* winner);

}  // namespace ff::farfield
