// The traversal of the height grid: one quadtree walk for all columns, sixteen children at a time.
//
// A square bounds what any of its descendants can add to a column: its height over its gap to the eye. The formulas of
// both are the same float expressions, monotone in their inputs, so a square that raises no column has no descendant
// that would, to the last bit, and the result does not depend on the order of the walk. Order and guesses only decide
// how early the columns are high enough to reject the rest. It is an occlusion buffer with one row (compare Greene,
// Kass, Miller, "Hierarchical Z-Buffer Visibility", SIGGRAPH 1993).
#include "engine/farfield/horizon_trace.h"

#include <algorithm>
#include <limits>

#include "engine/farfield/horizon_azimuth.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "engine/farfield/horizon_trace.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace ff::farfield {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using D = hn::CappedTag<float, 16>;
using DI = hn::RebindToSigned<D>;
using V = hn::VFromD<D>;
constexpr D d;
constexpr DI di;

/// A square and what it may add: in column c, where it rises above the eye
///   rise * min(max_x[c] * a, max_z[c] * b, 1 / near), a and b being 1 / gap along x and z,
/// else rise * max(min_x[c] * a, min_z[c] * b) with a and b 1 / farthest.
struct Bound {
    float rise, a, b;
    int first, count;  // columns
    int x, z, level;
};

/// Sixteen squares of one level, structure of arrays.
struct alignas(64) Batch {
    std::int32_t x[16], z[16];
    float height[16];
    float rise[16], a[16], b[16];
    std::int32_t first[16], count[16];

    Bound at(int i, int level) const { return {rise[i], a[i], b[i], first[i], count[i], x[i], z[i], level}; }
};

HWY_INLINE V azimuth_turn_v(V x, V z) {
    const V ax = hn::Abs(x), az = hn::Abs(z);
    const V t = hn::Div(hn::Min(ax, az), hn::Max(hn::Max(ax, az), hn::Set(d, 1e-37f)));
    V turn =
        hn::Mul(t, hn::Add(hn::Set(d, 0.125f), hn::Mul(hn::Set(d, kQuasiAngleBend), hn::Sub(hn::Set(d, 1.0f), t))));
    turn = hn::IfThenElse(hn::Gt(ax, az), hn::Sub(hn::Set(d, 0.25f), turn), turn);
    turn = hn::IfThenElse(hn::Gt(z, hn::Zero(d)), hn::Sub(hn::Set(d, 0.5f), turn), turn);
    return hn::IfThenElse(hn::Lt(x, hn::Zero(d)), hn::Sub(hn::Set(d, 1.0f), turn), turn);
}

/// Fills rise, a, b, first and count from x, z and height.
void compute_bounds(const HorizonTraceInput& in, int level, Batch& batch) {
    const V zero = hn::Zero(d), one = hn::Set(d, 1.0f);
    const V size = hn::Set(d, float(1 << level));
    const V columns = hn::Set(d, float(in.columns));
    // Coarser squares get a wider margin than what they hold, so that rounding cannot leave a descendant outside.
    const V margin = hn::Set(d, in.column_margin * float(1 + level));
    const V slack = hn::Set(d, 1e-6f);
    for (std::size_t i = 0; i < 16; i += hn::Lanes(d)) {
        const auto corner_x = hn::Sub(hn::ShiftLeftSame(hn::Load(di, batch.x + i), level), hn::Set(di, in.eye_x));
        const auto corner_z = hn::Sub(hn::ShiftLeftSame(hn::Load(di, batch.z + i), level), hn::Set(di, in.eye_z));
        const V low_x = hn::Sub(hn::ConvertTo(d, corner_x), hn::Set(d, in.frac_x));
        const V low_z = hn::Sub(hn::ConvertTo(d, corner_z), hn::Set(d, in.frac_z));
        const V high_x = hn::Add(low_x, size), high_z = hn::Add(low_z, size);

        const V gap_x = hn::Max(hn::Sub(hn::Max(low_x, hn::Neg(high_x)), slack), zero);
        const V gap_z = hn::Max(hn::Sub(hn::Max(low_z, hn::Neg(high_z)), slack), zero);
        const V far_x = hn::Add(hn::Max(hn::Neg(low_x), high_x), slack);
        const V far_z = hn::Add(hn::Max(hn::Neg(low_z), high_z), slack);

        V rise =
            hn::Mul(hn::Sub(hn::Load(d, batch.height + i), hn::Set(d, in.eye_height_m)), hn::Set(d, in.squares_per_m));
        // Wholly nearer than the near distance: not ours.
        const V far2 = hn::Add(hn::Mul(far_x, far_x), hn::Mul(far_z, far_z));
        rise = hn::IfThenElse(hn::Le(far2, hn::Set(d, in.near_squares * in.near_squares)),
                              hn::Set(d, -std::numeric_limits<float>::infinity()), rise);
        const auto above = hn::Gt(rise, zero);
        hn::Store(rise, d, batch.rise + i);
        hn::Store(hn::Div(one, hn::IfThenElse(above, gap_x, far_x)), d, batch.a + i);
        hn::Store(hn::Div(one, hn::IfThenElse(above, gap_z, far_z)), d, batch.b + i);

        // The two corners of the silhouette, clockwise, from which of the nine regions around it the eye looks.
        const auto east = hn::Gt(low_x, zero), west = hn::Lt(high_x, zero);
        const auto south = hn::Gt(low_z, zero), north = hn::Lt(high_z, zero);
        const auto between_x = hn::Not(hn::Or(east, west)), between_z = hn::Not(hn::Or(north, south));
        const auto level_east = hn::And(between_z, east);
        const V start_x = hn::IfThenElse(hn::Or(north, level_east), low_x, high_x);
        const V start_z = hn::IfThenElse(hn::Or(east, hn::And(between_x, south)), low_z, high_z);
        const V end_x = hn::IfThenElse(hn::Or(south, level_east), low_x, high_x);
        const V end_z = hn::IfThenElse(hn::Or(east, hn::And(between_x, north)), high_z, low_z);

        const V start = hn::Floor(hn::Sub(hn::Mul(azimuth_turn_v(start_x, start_z), columns), margin));
        const V end = hn::Floor(hn::Add(hn::Mul(azimuth_turn_v(end_x, end_z), columns), margin));
        V count = hn::Add(hn::Sub(end, start), one);
        count = hn::IfThenElse(hn::Le(count, zero), hn::Add(count, columns), count);
        // With the eye in the square (or as near as rounding can tell) it is all around.
        const auto inside = hn::And(hn::Eq(gap_x, zero), hn::Eq(gap_z, zero));
        count = hn::IfThenElse(inside, columns, hn::Min(count, columns));
        V first = hn::IfThenElse(hn::Lt(start, zero), hn::Add(start, columns), start);
        first = hn::IfThenElse(hn::Or(inside, hn::Ge(first, columns)), zero, first);
        hn::Store(hn::ConvertTo(di, first), di, batch.first + i);
        hn::Store(hn::ConvertTo(di, count), di, batch.count + i);
    }
}

template <bool kAbove>
HWY_INLINE V tangents_of(const HorizonTraceInput& in, std::size_t c, V rise, V a, V b, V inverse_near) {
    if (kAbove)
        return hn::Mul(rise,
                       hn::Min(hn::Min(hn::Mul(hn::LoadU(d, in.max_x + c), a), hn::Mul(hn::LoadU(d, in.max_z + c), b)),
                               inverse_near));
    return hn::Mul(rise, hn::Max(hn::Mul(hn::LoadU(d, in.min_x + c), a), hn::Mul(hn::LoadU(d, in.min_z + c), b)));
}

template <bool kAbove>
bool raises_any(const HorizonTraceInput& in, const Bound& bound, const float* tangents) {
    const V rise = hn::Set(d, bound.rise), a = hn::Set(d, bound.a), b = hn::Set(d, bound.b);
    const V inverse_near = hn::Set(d, 1.0f / in.near_squares);
    const int end = bound.first + bound.count;
    const auto range = [&](int first, int last) {
        for (int c = first; c < last; c += int(hn::Lanes(d))) {
            const auto higher =
                hn::Gt(tangents_of<kAbove>(in, std::size_t(c), rise, a, b, inverse_near), hn::LoadU(d, tangents + c));
            if (!hn::AllFalse(d, hn::And(higher, hn::FirstN(d, std::size_t(last - c))))) return true;
        }
        return false;
    };
    if (end <= in.columns) return range(bound.first, end);
    return range(bound.first, in.columns) || range(0, end - in.columns);
}

template <bool kAbove>
void raise(const HorizonTraceInput& in, const Bound& bound, float* tangents, std::uint32_t* winner) {
    const V rise = hn::Set(d, bound.rise), a = hn::Set(d, bound.a), b = hn::Set(d, bound.b);
    const V inverse_near = hn::Set(d, 1.0f / in.near_squares);
    const auto id = hn::Set(di, std::int32_t(bound.z << in.size_log2 | bound.x));
    const int end = bound.first + bound.count;
    const auto range = [&](int first, int last) {
        for (int c = first; c < last; c += int(hn::Lanes(d))) {
            const V old = hn::LoadU(d, tangents + c);
            const V tangent = tangents_of<kAbove>(in, std::size_t(c), rise, a, b, inverse_near);
            const auto higher = hn::And(hn::Gt(tangent, old), hn::FirstN(d, std::size_t(last - c)));
            if (hn::AllFalse(d, higher)) continue;
            hn::StoreU(hn::IfThenElse(higher, tangent, old), d, tangents + c);
            std::int32_t* ids = reinterpret_cast<std::int32_t*>(winner) + c;
            hn::StoreU(hn::IfThenElse(hn::RebindMask(di, higher), id, hn::LoadU(di, ids)), di, ids);
        }
    };
    if (end <= in.columns) return range(bound.first, end);
    range(bound.first, in.columns);
    range(0, end - in.columns);
}

void raise_any_sign(const HorizonTraceInput& in, const Bound& bound, float* tangents, std::uint32_t* winner) {
    if (bound.rise > 0.0f)
        raise<true>(in, bound, tangents, winner);
    else
        raise<false>(in, bound, tangents, winner);
}

/// Collects squares of the finest level until there are sixteen, then raises the columns by them.
class Primer {
  public:
    Primer(const HorizonTraceInput& in, float* tangents, std::uint32_t* winner)
        : in_(in), tangents_(tangents), winner_(winner) {}
    ~Primer() { flush(); }
    void add(int x, int z) {
        batch_.x[count_] = x;
        batch_.z[count_] = z;
        batch_.height[count_] = in_.level_heights[in_.finest_level][(z << (in_.size_log2 - in_.finest_level)) + x];
        if (++count_ == 16) flush();
    }
    std::uint32_t squares = 0;

  private:
    void flush() {
        if (count_ == 0) return;
        for (int i = count_; i < 16; ++i) batch_.x[i] = batch_.z[i] = 0, batch_.height[i] = 0.0f;
        compute_bounds(in_, in_.finest_level, batch_);
        for (int i = 0; i < count_; ++i) raise_any_sign(in_, batch_.at(i, in_.finest_level), tangents_, winner_);
        squares += std::uint32_t(count_);
        count_ = 0;
    }
    const HorizonTraceInput& in_;
    float* tangents_;
    std::uint32_t* winner_;
    Batch batch_;
    int count_ = 0;
};

/// Raises the columns by squares that probably make the skyline, so that the walk can reject nearly everything.
std::uint32_t prime(const HorizonTraceInput& in, float* tangents, std::uint32_t* winner) {
    Primer primer(in, tangents, winner);
    const std::uint32_t mask = (1u << in.size_log2) - 1;
    bool guessed = false;
    std::uint32_t last = kNoSquare;
    for (int c = 0; c < in.columns; ++c) {
        const std::uint32_t square = winner[c];
        if (square == last || square == kNoSquare) continue;
        last = square;
        if (tangents[c] == std::numeric_limits<float>::infinity()) continue;  // not wanted
        primer.add(int(square & mask), int(square >> in.size_log2));
        guessed = true;
    }
    if (guessed) return primer.squares;
    // Nothing known: the tallest square of each block of 32 x 32.
    const int block_level = std::min(in.size_log2, in.finest_level + 5);
    const int blocks = 1 << (in.size_log2 - block_level);
    for (int block = 0; block < blocks * blocks; ++block) {
        int x = block % blocks, z = block / blocks;
        for (int level = block_level; level > in.finest_level; --level) {
            const float* below = in.level_heights[level - 1];
            const int row = 1 << (in.size_log2 - level + 1);
            x *= 2;
            z *= 2;
            float tallest = below[z * row + x];
            int best = 0;
            for (int child = 1; child < 4; ++child) {
                const float height = below[(z + child / 2) * row + x + child % 2];
                if (height > tallest) tallest = height, best = child;
            }
            x += best % 2;
            z += best / 2;
        }
        primer.add(x, z);
    }
    return primer.squares;
}

std::uint32_t trace_horizon(const HorizonTraceInput& in, float* tangents, std::uint32_t* winner) {
    std::uint32_t squares = prime(in, tangents, winner);

    Bound stack[16 * 8];
    int top = 0;
    Batch batch;
    // Steps go down two levels at once and end on the finest, so they start on the coarsest that allows it.
    const int start_level = in.finest_level + (in.size_log2 - in.finest_level) / 2 * 2;
    const int start_row = 1 << (in.size_log2 - start_level);
    for (int i = 0; i < 16; ++i) {
        const int square = std::min(i, start_row * start_row - 1);
        batch.x[i] = square % start_row;
        batch.z[i] = square / start_row;
        batch.height[i] = in.level_heights[start_level][square];
    }
    compute_bounds(in, start_level, batch);
    for (int i = 0; i < start_row * start_row; ++i) stack[top++] = batch.at(i, start_level);

    while (top > 0) {
        const Bound bound = stack[--top];
        if (bound.level == in.finest_level) {
            raise_any_sign(in, bound, tangents, winner);
            continue;
        }
        if (!(bound.rise > 0.0f ? raises_any<true>(in, bound, tangents) : raises_any<false>(in, bound, tangents)))
            continue;
        const int level = bound.level - 2;
        const int row = 1 << (in.size_log2 - level);
        // Nearest children last, so that they are taken first and hide the others.
        const int flip_x = (bound.x << bound.level) + (1 << (bound.level - 1)) > in.eye_x ? 3 : 0;
        const int flip_z = (bound.z << bound.level) + (1 << (bound.level - 1)) > in.eye_z ? 3 : 0;
        for (int i = 0; i < 16; ++i) {
            batch.x[i] = bound.x * 4 + ((i & 3) ^ flip_x);
            batch.z[i] = bound.z * 4 + ((i >> 2) ^ flip_z);
            batch.height[i] = in.level_heights[level][batch.z[i] * row + batch.x[i]];
        }
        compute_bounds(in, level, batch);
        squares += 16;
        for (int i = 0; i < 16; ++i)
            if (batch.rise[i] > -std::numeric_limits<float>::infinity()) stack[top++] = batch.at(i, level);
    }
    return squares;
}

}  // namespace HWY_NAMESPACE
}  // namespace ff::farfield
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace ff::farfield {
HWY_EXPORT(trace_horizon);
std::uint32_t trace_horizon(const HorizonTraceInput& input, float* tangents, std::uint32_t* winner) {
    return HWY_DYNAMIC_DISPATCH(trace_horizon)(input, tangents, winner);
}
}  // namespace ff::farfield
#endif
