// A tile of 32 x 32 pixels in work: what each pixel has found so far, and tile space as linear functions of a mesh's
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
constexpr float kHalf = 15.5f;          // the outermost pixel centres
constexpr float kPlaneMargin = 0.01f;   // pixels by which the beam is wider
constexpr float kBoundsMargin = 1e-3f;  // pixels by which a triangle's bounds are wider
constexpr float kMinW = 1e-4f;          // metres; nearer vertices count as crossing the eye plane
constexpr float kMaxProjected = 1024;   // pixels from the tile; vertices further out are not projected
constexpr float kEdgeError = 4e-7f;     // rounding of an edge function, relative to its largest terms
constexpr float kThin = 64.0f;          // of those errors: what is no wider counts as a line
constexpr float kBoxError = 5e-7f;      // rounding of a plane at a box corner, likewise
constexpr float kNearestInverse = 1e9f;
constexpr float kFarther = 1.000001f;  // depths count as farther than others from this ratio on

// Whole numbers of less than 2^22 as integers; of others, anything. Conversions look after numbers that are too large,
// which takes twice as long: here the number is pushed to where its last bit is worth 1.
HWY_INLINE VI integer_of(VF number) {
    constexpr float kPush = 12582912.0f;  // 1.5 * 2^23
    const VI pushed = hn::BitCast(si, hn::Add(number, hn::Set(f, kPush)));
    return hn::Sub(pushed, hn::BitCast(si, hn::Set(f, kPush)));
}

// W, X W or Y W of a point as a linear function.
struct Linear {
    float x, y, z, c;
};

// The tile's pixels, rows with room for a register that begins at the last. Behind their depths those of the farthest
// pixel in any rectangle of cells of 8 x 8, by range_of_cells: columns, rows << 4.
constexpr int kRowStride = kBeamSize + std::max(kLanes, 8);
constexpr int kCells = kBeamSize / 8;
constexpr int kLeast = kBeamSize * kRowStride;
static_assert(kCells == 4);

struct Tile {
    alignas(64) float best[kLeast + 256];  // 1/depth; 0: sky; +inf where nobody asked
    alignas(64) std::uint32_t instance[kBeamSize * kRowStride];
    alignas(64) std::uint32_t triangle[kBeamSize * kRowStride];
    alignas(64) float cell_best[kCells][kCells];                           // of the farthest pixel, row by row
    float begin = 0;                                                       // depth; nearer boxes are passed over
    float behind_x = 0, behind_y = 0, behind_c = 0;                        // 1/depth that is too near; in tile space
    int first_changed = kBeamSize, last_changed = -1;                      // pixel rows, by layers
    std::uint32_t changed_cells = 0;                                       // bits row by row, by hits
    float first_column = 0, last_column = 0, first_row = 0, last_row = 0;  // bounds of the pixels asked for

    [[nodiscard]] HWY_INLINE float least(std::uint32_t cells) const { return best[std::uint32_t(kLeast) + cells]; }
};

HWY_INLINE std::uint32_t bits_of(MF mask) {
    std::uint8_t bytes[8] = {};
    hn::StoreMaskBits(f, mask, bytes);
    return kLanes > 8 ? std::uint32_t(bytes[0] | bytes[1] << 8) : std::uint32_t(bytes[0]);
}

HWY_INLINE MF mask_of(std::uint32_t bits) {
    const std::uint8_t bytes[8] = {std::uint8_t(bits), std::uint8_t(bits >> 8)};
    return hn::LoadMaskBits(f, bytes);
}

HWY_INLINE Linear linear_of(const DMat3& tile_from_world, int row, const DMat3& world_from_mesh, const DVec3& offset) {
    const DVec3 r(tile_from_world[0][row], tile_from_world[1][row], tile_from_world[2][row]);
    return {float(glm::dot(r, world_from_mesh[0])), float(glm::dot(r, world_from_mesh[1])),
            float(glm::dot(r, world_from_mesh[2])), float(glm::dot(r, offset))};
}

// Cells first..last of a row or column, as four bits.
HWY_INLINE VI range_of_cells(VI first, VI last) {
    return hn::Or(first, hn::ShiftLeft<2>(hn::Sub(last, first)));
}

// The least of every rectangle of cells from the cells' own.
HWY_INLINE void combine_cells(Tile& tile) {
    const hn::CappedTag<float, kCells> d;
    static_assert(hn::MaxLanes(d) == std::size_t(kCells));
    for (int first = 0; first < kCells; ++first) {
        auto rows = hn::Load(d, tile.cell_best[first]);
        for (int more = 0; first + more < kCells; ++more) {
            rows = hn::Min(rows, hn::Load(d, tile.cell_best[first + more]));
            float* to = tile.best + kLeast + (more << 6 | first << 4);
            const auto two = hn::Min(rows, hn::ShiftRightLanes<1>(d, rows));
            hn::Store(rows, d, to);
            hn::Store(two, d, to + 4);
            hn::Store(hn::Min(two, hn::ShiftRightLanes<2>(d, rows)), d, to + 8);
            hn::Store(hn::Min(two, hn::ShiftRightLanes<2>(d, two)), d, to + 12);
        }
    }
}

// Cells first_column..last_column of rows first_row..last_row, pixels all, as bits row by row.
HWY_INLINE std::uint32_t cells_of(int first_column, int last_column, int first_row, int last_row) {
    const std::uint32_t columns = (2u << last_column / 8) - (1u << first_column / 8);
    constexpr std::uint32_t kEveryRow = 0x1111u;
    const std::uint32_t rows = (2u << (last_row / 8 * kCells + kCells - 1)) - (1u << first_row / 8 * kCells);
    return columns * kEveryRow & rows;
}

// Brings these cells up to date. Most changes leave a cell's farthest pixel as it was.
HWY_INLINE void find_farthest(Tile& tile, std::uint32_t cells) {
    const hn::CappedTag<float, 8> eight;
    bool has_changed = false;
    for (; cells != 0; cells &= cells - 1) {
        const int cell = std::countr_zero(cells), cell_row = cell / kCells, column = cell % kCells;
        const float* first = tile.best + cell_row * 8 * kRowStride + column * 8;
        auto least = hn::LoadU(eight, first);
        for (int row = 0; row < 8; ++row) {
            for (int x = 0; x < 8; x += int(hn::MaxLanes(eight)))
                least = hn::Min(least, hn::LoadU(eight, first + row * kRowStride + x));
        }
        const float farthest = hn::GetLane(hn::MinOfLanes(eight, least));
        has_changed |= farthest != tile.cell_best[cell_row][column];
        tile.cell_best[cell_row][column] = farthest;
    }
    if (has_changed) combine_cells(tile);
}

// Brings the cells of the changed rows up to date.
HWY_INLINE void find_farthest(Tile& tile) {
    find_farthest(tile, cells_of(0, kBeamSize - 1, tile.first_changed, tile.last_changed));
    tile.first_changed = kBeamSize;
    tile.last_changed = -1;
}

// Bits of a row's pixels from `chunk` on, as a mask.
HWY_INLINE MF pixels_of(std::uint32_t row, int chunk) {
    const std::uint32_t bits = chunk < kBeamSize ? row >> chunk : 0;
    const std::uint8_t bytes[8] = {std::uint8_t(bits), std::uint8_t(bits >> 8)};
    return hn::LoadMaskBits(f, bytes);
}

// Pixels asked for, within the image; false when there are none.
HWY_INLINE bool begin_tile(const PinholeView& view, const BeamRequest& request, std::uint32_t (&rows)[kBeamSize],
                           Tile& tile) {
    const int columns = std::min(kBeamSize, view.width - int(request.x));
    const std::uint32_t in_image = columns < 32 ? (1u << columns) - 1u : ~0u;
    std::uint32_t any_column = 0, any_row = 0;
    for (int row = 0; row < kBeamSize; ++row) {
        const std::size_t left = std::size_t(row / kTileSize * 2);
        const auto asked = [&](std::size_t quarter) {
            const TileRequest* tile_request = request.quarters[quarter];
            return tile_request != nullptr ? std::uint32_t(tile_request->rows[row % kTileSize]) : 0u;
        };
        rows[row] = int(request.y) + row < view.height ? (asked(left) | asked(left + 1) << kTileSize) & in_image : 0u;
        any_column |= rows[row];
        if (rows[row] != 0) any_row |= 1u << row;
        for (int chunk = 0; chunk < kRowStride; chunk += kLanes) {
            const int at = row * kRowStride + chunk;
            hn::StoreU(hn::IfThenElse(pixels_of(rows[row], chunk), hn::Zero(f), hn::Set(f, kInf)), f, tile.best + at);
            if (rows[row] == 0) continue;
            hn::StoreU(hn::Set(ui, kSkyInstance), ui, tile.instance + at);
            hn::StoreU(hn::Zero(ui), ui, tile.triangle + at);
        }
    }
    if (any_column == 0) return false;
    tile.first_column = float(std::countr_zero(any_column));
    tile.last_column = float(31 - std::countl_zero(any_column));
    tile.first_row = float(std::countr_zero(any_row));
    tile.last_row = float(31 - std::countl_zero(any_row));
    for (float(&row)[kCells] : tile.cell_best) std::fill(std::begin(row), std::end(row), -1.0f);
    find_farthest(tile, 0xFFFFu);
    return true;
}

HWY_INLINE void write_tile(const Tile& tile, const BeamRequest& request, const std::uint32_t (&rows)[kBeamSize],
                           VisibilityBuffer& out) {
    constexpr std::uint32_t kAll = (1u << kLanes) - 1u;
    for (int row = 0; row < kBeamSize; ++row) {
        for (int chunk = 0; chunk < kBeamSize; chunk += kLanes) {
            const std::uint32_t bits = rows[row] >> chunk & kAll;
            if (bits == 0) continue;
            const int at = row * kRowStride + chunk;
            const std::size_t to = out.index(request.x + chunk, request.y + row);
            const VF depth = hn::Div(hn::Set(f, 1.0f), hn::LoadU(f, tile.best + at));
            const auto instance = hn::LoadU(ui, tile.instance + at), triangle = hn::LoadU(ui, tile.triangle + at);
            if (bits == kAll) {
                hn::StoreU(depth, f, out.depth.data() + to);
                hn::StoreU(instance, ui, out.instance.data() + to);
                hn::StoreU(triangle, ui, out.triangle.data() + to);
            } else {  // masked stores are slow on some machines, but leave what others may be writing
                const MF asked = pixels_of(rows[row], chunk);
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
