// A tile of 16 x 16 pixels in work: what each pixel has found so far, and tile space as linear functions of a mesh's
// own. Compiled once per SIMD target; include after <hwy/highway.h>.
#if defined(FF_BEAM_TILE_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef FF_BEAM_TILE_INL_H_
#undef FF_BEAM_TILE_INL_H_
#else
#define FF_BEAM_TILE_INL_H_
#endif

#include <hwy/highway.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>

#include "engine/farfield/beam_caster.h"

HWY_BEFORE_NAMESPACE();
namespace ff::farfield::beam {
namespace HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;
using scene::BvhLeaf;
using scene::BvhNode;
using scene::kBvhLeafBit;

using F = hn::CappedTag<float, 16>;
using I = hn::RebindToSigned<F>;
using U = hn::RebindToUnsigned<F>;
using VF = hn::Vec<F>;
using VI = hn::Vec<I>;
using MF = hn::Mask<F>;
constexpr F f;
constexpr I si;
constexpr U ui;
constexpr int kLanes = int(hn::MaxLanes(f));

constexpr float kInf = std::numeric_limits<float>::infinity();
constexpr float kHalf = 7.5f;           // the outermost pixel centres
constexpr float kPlaneMargin = 0.01f;   // pixels by which the beam is wider
constexpr float kBoundsMargin = 1e-3f;  // pixels by which a triangle's bounds are wider
constexpr float kMinW = 1e-4f;          // metres; nearer vertices count as crossing the eye plane
constexpr float kMaxProjected = 1024;   // pixels from the tile; vertices further out are not projected
constexpr float kEdgeError = 4e-7f;     // rounding of an edge function, relative to its largest terms
constexpr float kThin = 256.0f;         // of those errors: what is no wider counts as a line
constexpr float kBoxError = 5e-7f;      // rounding of a plane at a box corner, likewise
constexpr float kNearestInverse = 1e9f;
constexpr float kFarther = 1.000001f;  // depths count as farther than others from this ratio on

// W, X W or Y W of a point as a linear function.
struct Linear {
    float x, y, z, c;
};

struct Tile {
    alignas(64) float best[256];  // 1/depth; 0: sky; +inf where nobody asked
    alignas(64) std::uint32_t instance[256];
    alignas(64) std::uint32_t triangle[256];
    float quarter_best[4] = {};  // of the farthest pixel of each 8 x 8: top left, top right, bottom left, bottom right
    float far[16];               // depth of the farthest pixel in any set of quarters, rounded up
    float first_column = 0, last_column = 15, first_row = 0, last_row = 15;  // bounds of the pixels asked for
    bool changed = false;
};

HWY_INLINE std::uint32_t bits_of(MF mask) {
    std::uint8_t bytes[8] = {};
    hn::StoreMaskBits(f, mask, bytes);
    return kLanes > 8 ? std::uint32_t(bytes[0] | bytes[1] << 8) : std::uint32_t(bytes[0]);
}

HWY_INLINE Linear linear_of(const DMat3& tile_from_world, int row, const DMat3& world_from_mesh, const DVec3& offset) {
    const DVec3 r(tile_from_world[0][row], tile_from_world[1][row], tile_from_world[2][row]);
    return {float(glm::dot(r, world_from_mesh[0])), float(glm::dot(r, world_from_mesh[1])),
            float(glm::dot(r, world_from_mesh[2])), float(glm::dot(r, offset))};
}

HWY_INLINE void find_farthest(Tile& tile) {
    tile.far[0] = 0.0f;
    for (std::uint32_t quarter = 0; quarter < 4; ++quarter) {
        const float* first = tile.best + (quarter / 2) * 128 + (quarter % 2) * 8;
        const hn::CappedTag<float, 8> eight;
        auto least = hn::Load(eight, first);
        for (int row = 0; row < 8; ++row) {
            for (int x = 0; x < 8; x += int(hn::MaxLanes(eight)))
                least = hn::Min(least, hn::Load(eight, first + row * 16 + x));
        }
        tile.quarter_best[quarter] = hn::GetLane(hn::MinOfLanes(eight, least));
        const float far = kFarther / tile.quarter_best[quarter];
        for (std::uint32_t set = 0; set < (1u << quarter); ++set)
            tile.far[set | (1u << quarter)] = std::max(tile.far[set], far);
    }
    tile.changed = false;
}

// Pixels asked for, within the image; false when there are none.
HWY_INLINE bool begin_tile(const PinholeView& view, const TileRequest& request, std::uint16_t (&rows)[kTileSize],
                           Tile& tile) {
    const int columns = std::min(kTileSize, view.width - int(request.x));
    std::uint32_t any_column = 0, any_row = 0;
    for (int row = 0; row < kTileSize; ++row) {
        const bool in_image = columns > 0 && int(request.y) + row < view.height;
        rows[row] = in_image ? std::uint16_t(request.rows[row] & ((1u << columns) - 1u)) : std::uint16_t(0);
        any_column |= rows[row];
        if (rows[row] != 0) any_row |= 1u << row;
        for (int chunk = 0; chunk < kTileSize; chunk += kLanes) {
            const std::uint32_t bits = std::uint32_t(rows[row]) >> chunk;
            const std::uint8_t bytes[8] = {std::uint8_t(bits), std::uint8_t(bits >> 8)};
            const MF asked = hn::LoadMaskBits(f, bytes);
            const int at = row * 16 + chunk;
            hn::Store(hn::IfThenElse(asked, hn::Zero(f), hn::Set(f, kInf)), f, tile.best + at);
            hn::Store(hn::Set(ui, kSkyInstance), ui, tile.instance + at);
            hn::Store(hn::Zero(ui), ui, tile.triangle + at);
        }
    }
    if (any_column == 0) return false;
    tile.first_column = float(std::countr_zero(any_column));
    tile.last_column = float(31 - std::countl_zero(any_column));
    tile.first_row = float(std::countr_zero(any_row));
    tile.last_row = float(31 - std::countl_zero(any_row));
    find_farthest(tile);
    return true;
}

HWY_INLINE void write_tile(const Tile& tile, const TileRequest& request, const std::uint16_t (&rows)[kTileSize],
                           VisibilityBuffer& out) {
    for (int row = 0; row < kTileSize; ++row) {
        if (rows[row] == 0) continue;
        for (int chunk = 0; chunk < kTileSize; chunk += kLanes) {
            const std::uint32_t bits = std::uint32_t(rows[row]) >> chunk;
            const int at = row * 16 + chunk;
            const std::size_t to = out.index(request.x + chunk, request.y + row);
            const VF depth = hn::Div(hn::Set(f, 1.0f), hn::Load(f, tile.best + at));
            const auto instance = hn::Load(ui, tile.instance + at), triangle = hn::Load(ui, tile.triangle + at);
            constexpr std::uint32_t kAll = (1u << kLanes) - 1u;
            if ((bits & kAll) == kAll) {
                hn::StoreU(depth, f, out.depth.data() + to);
                hn::StoreU(instance, ui, out.instance.data() + to);
                hn::StoreU(triangle, ui, out.triangle.data() + to);
            } else {  // masked stores are slow on some machines, but leave what others may be writing
                const std::uint8_t bytes[8] = {std::uint8_t(bits), std::uint8_t(bits >> 8)};
                const MF asked = hn::LoadMaskBits(f, bytes);
                const auto asked_u = hn::RebindMask(ui, asked);
                hn::BlendedStore(depth, asked, f, out.depth.data() + to);
                hn::BlendedStore(instance, asked_u, ui, out.instance.data() + to);
                hn::BlendedStore(triangle, asked_u, ui, out.triangle.data() + to);
            }
        }
    }
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace ff::farfield::beam
HWY_AFTER_NAMESPACE();

#endif
