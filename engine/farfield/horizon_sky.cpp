// Which pixels of a view lie above the skyline, for any pitch and roll.
//
// A tile's rays form a cone over a rectangle of the image plane. Its azimuths lie between those of its corners (unless
// it holds the zenith or nadir), and its elevations are bounded by the corners' heights and the nearest and farthest
// horizontal length; most tiles are wholly above or wholly below the skyline of those columns. The others are decided
// pixel by pixel.
#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>

#include "engine/core/jobs.h"
#include "engine/farfield/horizon.h"
#include "engine/farfield/horizon_azimuth.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "engine/farfield/horizon_sky.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace ff::farfield {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

constexpr hn::CappedTag<float, 16> d;
using DI = hn::RebindToSigned<decltype(d)>;
using V = hn::VFromD<decltype(d)>;
constexpr DI di;

HWY_INLINE float length_of(float a, float b) {
    return std::sqrt(a * a + b * b);
}

/// Decides each pixel of the tile at (x, y).
void decide_pixels(const PinholeView& view, const float* tangents, int columns, int x, int y, TileMask& mask) {
    const Mat3& m = view.world_from_camera;
    const V zero = hn::Zero(d), half_turn = hn::Set(d, 0.5f), one = hn::Set(d, 1.0f);
    const int rows = std::min(kTileSize, view.height - y);
    for (int j = 0; j < rows; ++j) {
        const float v = (float(y + j) + 0.5f) * view.v_step + view.v_first;
        const V base_x = hn::Set(d, m[1].x * v - m[2].x), base_y = hn::Set(d, m[1].y * v - m[2].y),
                base_z = hn::Set(d, m[1].z * v - m[2].z);
        std::uint32_t bits = 0;
        for (std::size_t i = 0; i < kTileSize; i += hn::Lanes(d)) {
            const V px = hn::Add(hn::Iota(d, float(std::size_t(x) + i)), half_turn);
            const V u = hn::Add(hn::Mul(px, hn::Set(d, view.u_step)), hn::Set(d, view.u_first));
            const V dx = hn::Add(base_x, hn::Mul(u, hn::Set(d, m[0].x)));
            const V dy = hn::Add(base_y, hn::Mul(u, hn::Set(d, m[0].y)));
            const V dz = hn::Add(base_z, hn::Mul(u, hn::Set(d, m[0].z)));
            // azimuth_turn
            const V ax = hn::Abs(dx), az = hn::Abs(dz);
            const V t = hn::Div(hn::Min(ax, az), hn::Max(hn::Max(ax, az), hn::Set(d, 1e-37f)));
            V turn = hn::Mul(t, hn::Add(hn::Set(d, 0.125f), hn::Mul(hn::Set(d, kQuasiAngleBend), hn::Sub(one, t))));
            turn = hn::IfThenElse(hn::Gt(ax, az), hn::Sub(hn::Set(d, 0.25f), turn), turn);
            turn = hn::IfThenElse(hn::Gt(dz, zero), hn::Sub(half_turn, turn), turn);
            turn = hn::IfThenElse(hn::Lt(dx, zero), hn::Sub(one, turn), turn);
            const auto column =
                hn::Min(hn::ConvertTo(di, hn::Mul(turn, hn::Set(d, float(columns)))), hn::Set(di, columns - 1));
            const V tangent = hn::GatherIndex(d, tangents, column);
            const V horizontal = hn::Sqrt(hn::Add(hn::Mul(dx, dx), hn::Mul(dz, dz)));
            const auto sky = hn::Gt(dy, hn::Mul(tangent, horizontal));
            std::uint8_t lanes[8] = {};
            hn::StoreMaskBits(d, sky, lanes);
            bits |= (std::uint32_t(lanes[0]) | std::uint32_t(lanes[1]) << 8) << i;
        }
        mask.rows[j] = std::uint16_t(bits);
    }
}

void range_of(const float* tangents, int first, int last, float& low, float& high) {
    V lowest = hn::Set(d, low), highest = hn::Set(d, high);
    for (int c = first; c < last; c += int(hn::Lanes(d))) {
        const auto inside = hn::FirstN(d, std::size_t(last - c));
        const V tangent = hn::LoadU(d, tangents + c);
        lowest = hn::IfThenElse(inside, hn::Min(lowest, tangent), lowest);
        highest = hn::IfThenElse(inside, hn::Max(highest, tangent), highest);
    }
    low = hn::GetLane(hn::MinOfLanes(d, lowest));
    high = hn::GetLane(hn::MaxOfLanes(d, highest));
}

/// In rows of tiles from first_row to before end_row.
std::uint64_t find_sky(const PinholeView& view, const float* tangents, int columns, int first_row, int end_row,
                       PixelMask& sky) {
    constexpr float kInfinity = std::numeric_limits<float>::infinity();
    constexpr float kSlack = 1e-5f;  // rounding of directions, as tangent and as turns
    const Mat3& m = view.world_from_camera;
    std::uint64_t found = 0;
    for (int tile_y = first_row; tile_y < end_row; ++tile_y)
        for (int tile_x = 0; tile_x < sky.tiles_x; ++tile_x) {
            TileMask& mask = sky.tiles[std::size_t(tile_y) * std::size_t(sky.tiles_x) + std::size_t(tile_x)];
            const int x = tile_x * kTileSize, y = tile_y * kTileSize;
            const float u0 = float(x) * view.u_step + view.u_first, u1 = u0 + float(kTileSize) * view.u_step;
            const float v0 = float(y) * view.v_step + view.v_first, v1 = v0 + float(kTileSize) * view.v_step;

            const Vec3 corner[4] = {m * Vec3(u0, v0, -1.0f), m * Vec3(u1, v0, -1.0f), m * Vec3(u1, v1, -1.0f),
                                    m * Vec3(u0, v1, -1.0f)};
            const Vec3 center = m * Vec3(0.5f * (u0 + u1), 0.5f * (v0 + v1), -1.0f);
            const float radius = 0.5f * length_of(u1 - u0, v1 - v0);
            const float shortest = length_of(center.x, center.z) - radius;  // of horizontal lengths in the tile
            bool decided = false;
            if (shortest > kSlack) {
                float longest = 0.0f, lowest_y = kInfinity, highest_y = -kInfinity;
                float low_turn = 0.0f, high_turn = 0.0f;
                const float middle = azimuth_turn(center.x, center.z);
                for (const Vec3& c : corner) {
                    longest = std::max(longest, length_of(c.x, c.z));
                    lowest_y = std::min(lowest_y, c.y);
                    highest_y = std::max(highest_y, c.y);
                    float offset = azimuth_turn(c.x, c.z) - middle;
                    offset -= std::floor(offset + 0.5f);
                    low_turn = std::min(low_turn, offset);
                    high_turn = std::max(high_turn, offset);
                }
                const int first = int(std::floor((middle + low_turn - kSlack) * float(columns)));
                const int last = int(std::floor((middle + high_turn + kSlack) * float(columns))) + 1;
                float low = kInfinity, high = -kInfinity;
                if (last - first >= columns) {
                    range_of(tangents, 0, columns, low, high);
                } else {
                    const int begin = (first % columns + columns) % columns, end = begin + last - first;
                    range_of(tangents, begin, std::min(end, columns), low, high);
                    if (end > columns) range_of(tangents, 0, end - columns, low, high);
                }
                const float lowest = lowest_y > 0.0f ? lowest_y / longest : lowest_y / shortest;
                const float highest = highest_y > 0.0f ? highest_y / shortest : highest_y / longest;
                if (lowest - kSlack * (1.0f + std::abs(lowest)) > high) {
                    const int columns_in = std::min(kTileSize, view.width - x),
                              rows = std::min(kTileSize, view.height - y);
                    for (int j = 0; j < rows; ++j) mask.rows[j] = std::uint16_t((1u << columns_in) - 1u);
                    found += std::uint64_t(columns_in * rows);
                    decided = true;
                } else if (highest + kSlack * (1.0f + std::abs(highest)) < low) {
                    decided = true;
                }
            }
            if (decided) continue;
            decide_pixels(view, tangents, columns, x, y, mask);
            if (view.width - x < kTileSize)
                for (std::uint16_t& row : mask.rows) row = std::uint16_t(row & ((1u << (view.width - x)) - 1u));
            found += std::uint64_t(mask.count());
        }
    return found;
}

}  // namespace HWY_NAMESPACE
}  // namespace ff::farfield
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace ff::farfield {
HWY_EXPORT(find_sky);
std::uint64_t find_sky_pixels(const PinholeView& view, const HorizonMap& map, PixelMask& sky) {
    constexpr std::size_t kRowsPerTask = 4;
    sky.reset(view.width, view.height);
    std::atomic<std::uint64_t> found{0};
    parallel_ranges(std::size_t(sky.tiles_y), kRowsPerTask, [&](std::size_t begin, std::size_t end) {
        found += HWY_DYNAMIC_DISPATCH(find_sky)(view, map.tangents().data(), map.settings().columns, int(begin),
                                                int(end), sky);
    });
    return found;
}
}  // namespace ff::farfield
#endif
