// The walk of a mesh's BVH and the drawing of its leaves into row masks.
//
// Boxes whose tiles are full are skipped; leaves are transformed and set up eight or sixteen triangles at a time; then
// each triangle is drawn eight or sixteen ROWS at a time: every lane has the interval [left, right) of one row as a bit
// mask. An edge is a line x = a + y * slope, moved inwards by the inset; the two edges that meet in the middle vertex
// bound the same side, and as a triangle is convex both may bound all rows.
#include "engine/farfield/opacity_raster.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "engine/farfield/opacity_raster.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace ff::farfield {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

constexpr hn::CappedTag<float, 16> d;
using DI = hn::RebindToSigned<decltype(d)>;
using V = hn::VFromD<decltype(d)>;
using VI = hn::VFromD<DI>;
constexpr DI di;
using DB = hn::Rebind<std::uint8_t, decltype(d)>;

constexpr float kGuardPx = 8192.0f;  ///< beyond, rounding of lines would reach the inset: clipped first
constexpr float kHuge = 1e9f;
constexpr float kLevelEdge = 1.0f / 1024.0f;  ///< edges that rise less (pixels) bound no row beyond their vertices

/// Screen triangles in, lines and bounds out; structure of arrays.
struct alignas(64) Batch {
    float x[3][16], y[3][16];
    float long_a[16], long_slope[16];          // first to last vertex by y
    float short_a[2][16], short_slope[2][16];  // by way of the middle one
    std::int32_t bulges_right[16];             // -1: the middle vertex lies right of the long edge; 0: left
    std::int32_t first_row[16], last_row[16], first_column[16], last_column[16];  // inclusive
};

HWY_INLINE std::uint32_t bits_of(hn::MFromD<decltype(d)> mask) {
    std::uint8_t bytes[8] = {};
    hn::StoreMaskBits(d, mask, bytes);
    return std::uint32_t(bytes[0]) | std::uint32_t(bytes[1]) << 8;
}

HWY_INLINE void sort_pair(V& ax, V& ay, V& bx, V& by) {
    const auto swap = hn::Lt(by, ay);
    const V x = hn::IfThenElse(swap, bx, ax), y = hn::IfThenElse(swap, by, ay);
    bx = hn::IfThenElse(swap, ax, bx);
    by = hn::IfThenElse(swap, ay, by);
    ax = x;
    ay = y;
}

/// Line through two vertices, moved by `shift` pixels square to itself (to the right where positive). Where the edge is
/// level it bounds nothing: it becomes x = none.
HWY_INLINE void line_of(V ax, V ay, V bx, V by, V shift, V none, V& a, V& slope) {
    const V rise = hn::Sub(by, ay);
    const auto is_level = hn::Lt(rise, hn::Set(d, kLevelEdge));
    slope = hn::Div(hn::Sub(bx, ax), rise);
    a = hn::Sub(ax, hn::Mul(ay, slope));
    // |(1, slope)| <= 1 + |slope|
    a = hn::Add(a, hn::Mul(shift, hn::Add(hn::Set(d, 1.0f), hn::Abs(slope))));
    slope = hn::IfThenElse(is_level, hn::Zero(d), slope);
    a = hn::IfThenElse(is_level, none, a);
}

/// Sets up the triangles of the first `count` lanes. @return bit i: triangle i has a pixel centre in its bounds.
std::uint32_t set_up(Batch& batch, int count, float inset, int width, int height) {
    std::uint32_t drawable = 0;
    const V half = hn::Set(d, 0.5f), zero = hn::Zero(d), shift = hn::Set(d, inset);
    for (int i = 0; i < count; i += int(hn::Lanes(d))) {
        V x0 = hn::Load(d, batch.x[0] + i), y0 = hn::Load(d, batch.y[0] + i);
        V x1 = hn::Load(d, batch.x[1] + i), y1 = hn::Load(d, batch.y[1] + i);
        V x2 = hn::Load(d, batch.x[2] + i), y2 = hn::Load(d, batch.y[2] + i);
        sort_pair(x0, y0, x1, y1);
        sort_pair(x1, y1, x2, y2);
        sort_pair(x0, y0, x1, y1);

        const V low_x = hn::Min(x0, hn::Min(x1, x2)), high_x = hn::Max(x0, hn::Max(x1, x2));
        const auto first_of = [&](V low) HWY_ATTR { return hn::Ceil(hn::Sub(hn::Add(low, shift), half)); };
        const auto last_of = [&](V high) HWY_ATTR { return hn::Floor(hn::Sub(hn::Sub(high, shift), half)); };
        const V first_row = hn::Max(first_of(y0), zero), first_column = hn::Max(first_of(low_x), zero);
        const V last_row = hn::Min(last_of(y2), hn::Set(d, float(height - 1)));
        const V last_column = hn::Min(last_of(high_x), hn::Set(d, float(width - 1)));
        const auto has_pixels = hn::And(hn::Le(first_row, last_row), hn::Le(first_column, last_column));
        // Twice the area, positive where the middle vertex is right of the long edge.
        const V area = hn::Sub(hn::Mul(hn::Sub(x1, x0), hn::Sub(y2, y0)), hn::Mul(hn::Sub(x2, x0), hn::Sub(y1, y0)));
        const auto usable = hn::AndNot(hn::Eq(area, zero), has_pixels);
        const std::uint32_t bits = bits_of(usable);
        if (bits == 0) continue;
        drawable |= bits << i;

        const auto right = hn::Gt(area, zero);
        const V outwards = hn::IfThenElse(right, hn::Set(d, inset), hn::Set(d, -inset));
        const V none = hn::IfThenElse(right, hn::Set(d, kHuge), hn::Set(d, -kHuge));
        V a, slope;
        line_of(x0, y0, x2, y2, outwards, none, a, slope);
        hn::Store(a, d, batch.long_a + i);
        hn::Store(slope, d, batch.long_slope + i);
        line_of(x0, y0, x1, y1, hn::Neg(outwards), none, a, slope);
        hn::Store(a, d, batch.short_a[0] + i);
        hn::Store(slope, d, batch.short_slope[0] + i);
        line_of(x1, y1, x2, y2, hn::Neg(outwards), none, a, slope);
        hn::Store(a, d, batch.short_a[1] + i);
        hn::Store(slope, d, batch.short_slope[1] + i);
        hn::Store(hn::VecFromMask(di, hn::RebindMask(di, right)), di, batch.bulges_right + i);
        hn::Store(hn::ConvertTo(di, first_row), di, batch.first_row + i);
        hn::Store(hn::ConvertTo(di, last_row), di, batch.last_row + i);
        hn::Store(hn::ConvertTo(di, first_column), di, batch.first_column + i);
        hn::Store(hn::ConvertTo(di, last_column), di, batch.last_column + i);
    }
    return drawable;
}

/// All bits that a tile of the image has.
TileMask whole_tile(const OpacityTarget& target, int tile_x, int tile_y) {
    TileMask whole;
    const int columns = std::min(kTileSize, target.width - tile_x * kTileSize);
    const int rows = std::min(kTileSize, target.height - tile_y * kTileSize);
    for (int j = 0; j < rows; ++j) whole.rows[j] = std::uint16_t((1u << columns) - 1u);
    return whole;
}

HWY_INLINE bool is_full(const TileMask& tile) {
    std::uint64_t words[4];
    std::memcpy(words, tile.rows, sizeof words);
    return (words[0] & words[1] & words[2] & words[3]) == ~std::uint64_t(0);
}

void note_if_full(OpacityTarget& target, int tile_x, int tile_y) {
    const std::size_t index = std::size_t(tile_y) * std::size_t(target.tiles_x) + std::size_t(tile_x);
    const TileMask& tile = target.tiles[index];
    if (!is_full(tile)) {
        const bool cut = (tile_x + 1) * kTileSize > target.width || (tile_y + 1) * kTileSize > target.height;
        if (!cut) return;
        const TileMask whole = whole_tile(target, tile_x, tile_y);
        if (std::memcmp(&whole, &tile, sizeof whole) != 0) return;
    }
    target.full[index] = 1;
    --target.open_tiles;
}

/// Pixel bounds, inclusive.
struct PixelBounds {
    int first_row, last_row, first_column, last_column;
};

constexpr int kLanes = int(hn::MaxLanes(d));  ///< rows drawn at once

/// Covers, in each of the rows from y on, the pixels whose centres lie in [left, right].
HWY_INLINE void cover_rows(int y, V left, V right, const PixelBounds& bounds, OpacityTarget& target) {
    const V zero = hn::Zero(d), half = hn::Set(d, 0.5f), width = hn::Set(d, float(target.width));
    const VI ones = hn::Set(di, 0xFFFF), tile_end = hn::Set(di, kTileSize);
    const hn::Rebind<std::uint16_t, decltype(d)> d16;
    left = hn::Min(hn::Max(hn::Ceil(hn::Sub(left, half)), zero), width);
    right = hn::Min(hn::Max(hn::Add(hn::Floor(hn::Sub(right, half)), hn::Set(d, 1.0f)), zero), width);
    const VI row = hn::Iota(di, y);
    const auto outside = hn::Or(hn::Lt(row, hn::Set(di, bounds.first_row)), hn::Gt(row, hn::Set(di, bounds.last_row)));
    right = hn::IfThenElse(hn::RebindMask(d, outside), zero, right);
    const VI begin = hn::ConvertTo(di, left), end = hn::ConvertTo(di, right);

    const int tile_y = y / kTileSize;
    std::uint8_t* full = target.full + std::size_t(tile_y) * std::size_t(target.tiles_x);
    TileMask* tiles = target.tiles + std::size_t(tile_y) * std::size_t(target.tiles_x);
    for (int tile_x = bounds.first_column / kTileSize; tile_x <= bounds.last_column / kTileSize; ++tile_x) {
        if (full[tile_x]) continue;
        const VI offset = hn::Set(di, tile_x * kTileSize);
        const VI from = hn::Min(hn::Max(hn::Sub(begin, offset), hn::Zero(di)), tile_end);
        const VI to = hn::Min(hn::Max(hn::Sub(end, offset), hn::Zero(di)), tile_end);
        const VI mask = hn::And(hn::AndNot(hn::Shl(ones, to), hn::Shl(ones, from)), ones);
        std::uint16_t* rows = tiles[tile_x].rows + (y & (kTileSize - 1));
        hn::StoreU(hn::Or(hn::LoadU(d16, rows), hn::DemoteTo(d16, mask)), d16, rows);
        note_if_full(target, tile_x, tile_y);
    }
}

void draw_triangle(const Batch& batch, int i, OpacityTarget& target) {
    const V long_a = hn::Set(d, batch.long_a[i]), long_slope = hn::Set(d, batch.long_slope[i]);
    const V a1 = hn::Set(d, batch.short_a[0][i]), slope1 = hn::Set(d, batch.short_slope[0][i]);
    const V a2 = hn::Set(d, batch.short_a[1][i]), slope2 = hn::Set(d, batch.short_slope[1][i]);
    const auto bulges_right = hn::RebindMask(d, hn::Lt(hn::Set(di, batch.bulges_right[i]), hn::Zero(di)));
    const PixelBounds bounds{batch.first_row[i], batch.last_row[i], batch.first_column[i], batch.last_column[i]};
    for (int y = bounds.first_row / kLanes * kLanes; y <= bounds.last_row; y += kLanes) {
        const V center = hn::Iota(d, float(y) + 0.5f);
        const V x_long = hn::Add(long_a, hn::Mul(center, long_slope));
        const V x1 = hn::Add(a1, hn::Mul(center, slope1)), x2 = hn::Add(a2, hn::Mul(center, slope2));
        const V left = hn::IfThenElse(bulges_right, x_long, hn::Max(x1, x2));
        const V right = hn::IfThenElse(bulges_right, hn::Min(x1, x2), x_long);
        cover_rows(y, left, right, bounds, target);
    }
}

constexpr int kMaxPolygon = 12;  ///< a triangle and one vertex more for each of five clipping planes, and room

/// Draws a convex polygon whole: a fan's inner edges would leave cracks. Any orientation; pixels.
/// @return false where it holds no pixel centre.
bool draw_polygon(const double* x, const double* y, int count, double inset, OpacityTarget& target) {
    double area = 0.0, low_x = x[0], high_x = x[0], low_y = y[0], high_y = y[0];
    for (int i = 0; i < count; ++i) {
        const int next = (i + 1) % count;
        area += (x[i] - x[0]) * (y[next] - y[0]) - (x[next] - x[0]) * (y[i] - y[0]);
        low_x = std::min(low_x, x[i]);
        high_x = std::max(high_x, x[i]);
        low_y = std::min(low_y, y[i]);
        high_y = std::max(high_y, y[i]);
    }
    const auto first_of = [&](double low) { return std::max(0, int(std::ceil(low + inset - 0.5))); };
    const auto last_of = [&](double high, int end) { return std::min(end - 1, int(std::floor(high - inset - 0.5))); };
    const PixelBounds bounds{first_of(low_y), last_of(high_y, target.height), first_of(low_x),
                             last_of(high_x, target.width)};
    if (!(area != 0.0) || bounds.first_row > bounds.last_row || bounds.first_column > bounds.last_column) return false;

    // With y downwards and a positive area, edges that go up are left ones.
    float line_a[2][kMaxPolygon], line_slope[2][kMaxPolygon];
    int lines[2] = {0, 0};
    for (int i = 0; i < count; ++i) {
        const int next = (i + 1) % count;
        const double rise = y[next] - y[i];
        if (std::abs(rise) < double(kLevelEdge)) continue;
        const int side = (rise > 0.0) == (area > 0.0) ? 1 : 0;
        const double slope = (x[next] - x[i]) / rise;
        const double shift = (side == 0 ? inset : -inset) * (1.0 + std::abs(slope));
        line_a[side][lines[side]] = float(x[i] - y[i] * slope + shift);
        line_slope[side][lines[side]++] = float(slope);
    }
    for (int y0 = bounds.first_row / kLanes * kLanes; y0 <= bounds.last_row; y0 += kLanes) {
        const V center = hn::Iota(d, float(y0) + 0.5f);
        V left = hn::Set(d, -kHuge), right = hn::Set(d, kHuge);
        for (int i = 0; i < lines[0]; ++i)
            left = hn::Max(left, hn::Add(hn::Set(d, line_a[0][i]), hn::Mul(center, hn::Set(d, line_slope[0][i]))));
        for (int i = 0; i < lines[1]; ++i)
            right = hn::Min(right, hn::Add(hn::Set(d, line_a[1][i]), hn::Mul(center, hn::Set(d, line_slope[1][i]))));
        cover_rows(y0, left, right, bounds, target);
    }
    return true;
}

/// A vertex while clipping: numerators of pixel coordinates, and depth, metres.
struct ClipVertex {
    double x, y, depth;
};

/// Keeps the part of a convex polygon where distance(vertex) >= 0. Room for one vertex more than before.
template <class Distance>
int clip(const ClipVertex* in, int count, ClipVertex* out, const Distance& distance) {
    int kept = 0;
    for (int i = 0; i < count; ++i) {
        const ClipVertex& a = in[i];
        const ClipVertex& b = in[(i + 1) % count];
        const double da = distance(a), db = distance(b);
        if (da >= 0.0) out[kept++] = a;
        if ((da >= 0.0) != (db >= 0.0)) {
            const double t = da / (da - db);
            out[kept++] = {a.x + t * (b.x - a.x), a.y + t * (b.y - a.y), a.depth + t * (b.depth - a.depth)};
        }
    }
    return kept;
}

/// A leaf's vertices on the screen, and before division.
struct alignas(64) LeafVertices {
    float x[32], y[32];  // pixels
    float form_x[32], form_y[32], depth[32];
};

class MeshDrawing {
  public:
    MeshDrawing(const OpacityMesh& mesh, OpacityTarget& target, OpacityCost& cost)
        : mesh_(mesh), target_(target), cost_(cost) {}

    void draw() {
        // Deep enough for any BVH of a mesh that fits in memory: 15 siblings wait on each of its levels.
        constexpr int kStack = 15 * 64 + 16;
        Child stack[kStack];
        int top = 0;
        stack[top++] = {0, 0.0f, 0, 0, std::uint16_t(target_.tiles_x - 1), std::uint16_t(target_.tiles_y - 1)};
        while (top > 0 && target_.open_tiles > 0) {
            const Child child = stack[--top];
            if (is_hidden(child)) continue;
            if (child.id & scene::kBvhLeafBit) {
                draw_leaf(mesh_.leaves[child.id & ~scene::kBvhLeafBit]);
                continue;
            }
            const int first = top;
            top = push_children(mesh_.nodes[child.id], stack, top);
            std::sort(stack + first, stack + top, [](const Child& a, const Child& b) {
                return a.depth != b.depth ? a.depth > b.depth : a.id > b.id;
            });
            if (top > kStack - 16) return;  // misses cost rays, never holes
        }
    }

  private:
    struct Child {
        std::uint32_t id;
        float depth;  ///< of its nearest point
        std::uint16_t first_tile_x, first_tile_y, last_tile_x, last_tile_y;
    };

    bool is_hidden(const Child& child) const {
        for (int y = child.first_tile_y; y <= child.last_tile_y; ++y)
            for (int x = child.first_tile_x; x <= child.last_tile_x; ++x)
                if (!target_.full[std::size_t(y) * std::size_t(target_.tiles_x) + std::size_t(x)]) return false;
        return true;
    }

    /// The range of a form over boxes: center and reach.
    static HWY_INLINE void range_of(const OpacityMesh::Form& form, const V c[3], const V e[3], V& middle, V& reach) {
        middle = hn::Add(hn::Add(hn::Mul(hn::Set(d, form.x), c[0]), hn::Mul(hn::Set(d, form.y), c[1])),
                         hn::Add(hn::Mul(hn::Set(d, form.z), c[2]), hn::Set(d, form.w)));
        reach =
            hn::Add(hn::Add(hn::Mul(hn::Set(d, std::abs(form.x)), e[0]), hn::Mul(hn::Set(d, std::abs(form.y)), e[1])),
                    hn::Mul(hn::Set(d, std::abs(form.z)), e[2]));
    }

    int push_children(const scene::BvhNode& node, Child* stack, int top) {
        ++cost_.nodes;
        alignas(64) float depth[16], low_x[16], low_y[16], high_x[16], high_y[16];
        const V half = hn::Set(d, 0.5f), near_plane = hn::Set(d, mesh_.near_plane_m);
        const V width = hn::Set(d, float(target_.width)), height = hn::Set(d, float(target_.height)),
                zero = hn::Zero(d);
        std::uint32_t seen = 0;
        for (std::size_t i = 0; i < 16; i += hn::Lanes(d)) {
            const float* lows[3] = {node.low_x + i, node.low_y + i, node.low_z + i};
            const float* highs[3] = {node.high_x + i, node.high_y + i, node.high_z + i};
            V c[3], e[3];
            for (int axis = 0; axis < 3; ++axis) {
                const V low = hn::Load(d, lows[axis]), high = hn::Load(d, highs[axis]);
                c[axis] = hn::Mul(hn::Add(low, high), half);
                e[axis] = hn::Mul(hn::Sub(high, low), half);
            }
            V middle_x, reach_x, middle_y, reach_y, middle_depth, reach_depth;
            range_of(mesh_.pixel_x, c, e, middle_x, reach_x);
            range_of(mesh_.pixel_y, c, e, middle_y, reach_y);
            range_of(mesh_.depth, c, e, middle_depth, reach_depth);
            const V nearest = hn::Max(hn::Sub(middle_depth, reach_depth), near_plane);
            const V farthest = hn::Add(middle_depth, reach_depth);
            const V by_nearest = hn::Div(hn::Set(d, 1.0f), nearest), by_farthest = hn::Div(hn::Set(d, 1.0f), farthest);
            const V lx = hn::Sub(middle_x, reach_x), hx = hn::Add(middle_x, reach_x);
            const V ly = hn::Sub(middle_y, reach_y), hy = hn::Add(middle_y, reach_y);
            const V cx = hn::Set(d, mesh_.center_x), cy = hn::Set(d, mesh_.center_y);
            V left = hn::Add(hn::Min(hn::Mul(lx, by_nearest), hn::Mul(lx, by_farthest)), cx);
            V right = hn::Add(hn::Max(hn::Mul(hx, by_nearest), hn::Mul(hx, by_farthest)), cx);
            V upper = hn::Add(hn::Min(hn::Mul(ly, by_nearest), hn::Mul(ly, by_farthest)), cy);
            V lower = hn::Add(hn::Max(hn::Mul(hy, by_nearest), hn::Mul(hy, by_farthest)), cy);
            // Empty lanes are inf - inf = NaN and fail every comparison.
            const auto visible =
                hn::And(hn::And(hn::Ge(farthest, near_plane), hn::And(hn::Lt(left, width), hn::Gt(right, zero))),
                        hn::And(hn::Lt(upper, height), hn::Gt(lower, zero)));
            seen |= bits_of(visible) << i;
            hn::Store(nearest, d, depth + i);
            const V last_x = hn::Sub(width, hn::Set(d, 1.0f)), last_y = hn::Sub(height, hn::Set(d, 1.0f));
            hn::Store(hn::Min(hn::Max(left, zero), last_x), d, low_x + i);
            hn::Store(hn::Min(hn::Max(right, zero), last_x), d, high_x + i);
            hn::Store(hn::Min(hn::Max(upper, zero), last_y), d, low_y + i);
            hn::Store(hn::Min(hn::Max(lower, zero), last_y), d, high_y + i);
        }
        for (; seen != 0; seen &= seen - 1) {
            const int i = std::countr_zero(seen);
            if (node.child[i] == scene::kBvhEmpty) continue;
            const Child child{node.child[i],
                              depth[i],
                              std::uint16_t(int(low_x[i]) / kTileSize),
                              std::uint16_t(int(low_y[i]) / kTileSize),
                              std::uint16_t(int(high_x[i]) / kTileSize),
                              std::uint16_t(int(high_y[i]) / kTileSize)};
            if (!is_hidden(child)) stack[top++] = child;
        }
        return top;
    }

    static HWY_INLINE V value_of(const OpacityMesh::Form& form, V x, V y, V z) {
        return hn::Add(hn::Add(hn::Mul(hn::Set(d, form.x), x), hn::Mul(hn::Set(d, form.y), y)),
                       hn::Add(hn::Mul(hn::Set(d, form.z), z), hn::Set(d, form.w)));
    }

    void draw_leaf(const scene::BvhLeaf& leaf) {
        ++cost_.leaves;
        V nearest = hn::Set(d, std::numeric_limits<float>::infinity()), widest = hn::Zero(d);
        for (int i = 0; i < leaf.vertex_count; i += int(hn::Lanes(d))) {
            const V x = hn::Load(d, leaf.x + i), y = hn::Load(d, leaf.y + i), z = hn::Load(d, leaf.z + i);
            const V depth = value_of(mesh_.depth, x, y, z);
            const V form_x = value_of(mesh_.pixel_x, x, y, z), form_y = value_of(mesh_.pixel_y, x, y, z);
            const V inverse = hn::Div(hn::Set(d, 1.0f), depth);
            const V px = hn::Add(hn::Mul(form_x, inverse), hn::Set(d, mesh_.center_x));
            const V py = hn::Add(hn::Mul(form_y, inverse), hn::Set(d, mesh_.center_y));
            nearest = hn::Min(nearest, depth);
            widest = hn::Max(widest, hn::Max(hn::Abs(px), hn::Abs(py)));
            hn::Store(px, d, vertices_.x + i);
            hn::Store(py, d, vertices_.y + i);
            hn::Store(form_x, d, vertices_.form_x + i);
            hn::Store(form_y, d, vertices_.form_y + i);
            hn::Store(depth, d, vertices_.depth + i);
        }
        const std::uint32_t opaque = ((1u << leaf.triangle_count) - 1u) & ~std::uint32_t(leaf.alpha_triangles);
        const float nearest_depth = hn::GetLane(hn::MinOfLanes(d, nearest));
        if (!(nearest_depth >= mesh_.near_plane_m && hn::GetLane(hn::MaxOfLanes(d, widest)) < kGuardPx)) {
            draw_clipped(leaf, opaque);
            return;
        }
        for (int corner = 0; corner < 3; ++corner)
            for (int i = 0; i < leaf.triangle_count; i += int(hn::Lanes(d))) {
                const VI vertex = hn::PromoteTo(di, hn::LoadU(DB(), leaf.corner[corner] + i));
                hn::Store(hn::GatherIndex(d, vertices_.x, vertex), d, batch_.x[corner] + i);
                hn::Store(hn::GatherIndex(d, vertices_.y, vertex), d, batch_.y[corner] + i);
            }
        draw_batch(leaf.triangle_count, opaque, nearest_depth);
    }

    void draw_batch(int count, std::uint32_t wanted, float nearest_depth) {
        std::uint32_t bits = set_up(batch_, count, inset_at(nearest_depth), target_.width, target_.height) & wanted;
        cost_.triangles += std::uint32_t(std::popcount(wanted));
        cost_.drawn += std::uint32_t(std::popcount(bits));
        for (; bits != 0; bits &= bits - 1) draw_triangle(batch_, std::countr_zero(bits), target_);
    }

    /// The slow way, for triangles that reach before the near plane or far outside the image.
    void draw_clipped(const scene::BvhLeaf& leaf, std::uint32_t opaque) {
        for (; opaque != 0; opaque &= opaque - 1) {
            const int triangle = std::countr_zero(opaque);
            ClipVertex a[kMaxPolygon], b[kMaxPolygon];
            for (int corner = 0; corner < 3; ++corner) {
                const int v = leaf.corner[corner][triangle];
                a[corner] = {double(vertices_.form_x[v]), double(vertices_.form_y[v]), double(vertices_.depth[v])};
            }
            // The guard band, in the units of the forms.
            const double guard = 0.5 * double(kGuardPx);
            int count = clip(a, 3, b, [&](const ClipVertex& v) { return v.depth - double(mesh_.near_plane_m); });
            count = clip(b, count, a, [&](const ClipVertex& v) { return guard * v.depth - v.x; });
            count = clip(a, count, b, [&](const ClipVertex& v) { return guard * v.depth + v.x; });
            count = clip(b, count, a, [&](const ClipVertex& v) { return guard * v.depth - v.y; });
            count = clip(a, count, b, [&](const ClipVertex& v) { return guard * v.depth + v.y; });
            if (count < 3) continue;
            double nearest = std::numeric_limits<double>::infinity();
            double px[kMaxPolygon], py[kMaxPolygon];
            for (int i = 0; i < count; ++i) {
                nearest = std::min(nearest, b[i].depth);
                px[i] = b[i].x / b[i].depth + double(mesh_.center_x);
                py[i] = b[i].y / b[i].depth + double(mesh_.center_y);
            }
            ++cost_.triangles;
            if (draw_polygon(px, py, count, double(inset_at(float(nearest))), target_)) ++cost_.drawn;
        }
    }

    /// Pixels by which triangles shrink whose nearest vertex is so deep.
    float inset_at(float depth) const { return mesh_.inset_px + mesh_.inset_m * mesh_.pixels_per_unit / depth; }

    const OpacityMesh& mesh_;
    OpacityTarget& target_;
    OpacityCost& cost_;
    LeafVertices vertices_;
    Batch batch_;
};

void draw_mesh(const OpacityMesh& mesh, OpacityTarget& target, OpacityCost& cost) {
    MeshDrawing(mesh, target, cost).draw();
}

}  // namespace HWY_NAMESPACE
}  // namespace ff::farfield
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace ff::farfield {
HWY_EXPORT(draw_mesh);
void draw_opacity_mesh(const OpacityMesh& mesh, OpacityTarget& target, OpacityCost& cost) {
    HWY_DYNAMIC_DISPATCH(draw_mesh)(mesh, target, cost);
}
}  // namespace ff::farfield
#endif
