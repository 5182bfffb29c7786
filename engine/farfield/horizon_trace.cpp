// The traversal of the height grid: one quadtree walk for all columns, sixteen children (two levels) at a time. Where
// the finest level is not needed, one step goes down a single level, so that the last ones still end on sixteen.
//
// A square bounds what any of its descendants can add to a column: its height over its gap to the eye. The formulas of
// both are the same float expressions, monotone in their inputs, so a square that raises no column has no descendant
// that would, to the last bit, and the result does not depend on the order of the walk. Order and guesses only decide
// how early the columns are high enough to reject the rest. It is an occlusion buffer with one row (compare Greene,
// Kass, Miller, "Hierarchical Z-Buffer Visibility", SIGGRAPH 1993).
#include "engine/farfield/horizon_trace.h"

#include <algorithm>
#include <bit>
#include <limits>

#include "engine/farfield/horizon_azimuth.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "engine/farfield/horizon_trace.cpp"
#include <hwy/cache_control.h>
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "engine/farfield/horizon_columns-inl.h"

HWY_BEFORE_NAMESPACE();
namespace ff::farfield {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

/// Distance from which squares of twice the size will do, per column of the circle: they are then at most as wide as
/// 1.6 columns.
constexpr float kDistantSquaresPerColumn = 0.2f;
constexpr float kSlackSquares = 1e-6f;  // covers the rounding of offsets beside the eye

struct Square : Bound {
    int x, z, level;
};

/// Sixteen squares of one level, structure of arrays.
struct alignas(64) Batch {
    std::int32_t x[16], z[16];
    float height[16];
    float rise[16], a[16], b[16];
    std::int32_t first[16], count[16];

    Bound bound(int i) const { return {rise[i], a[i], b[i], first[i], count[i]}; }
    Square at(int i, int level) const { return {bound(i), x[i], z[i], level}; }
};

HWY_INLINE Extent extent_of(const HorizonTraceInput& in, int level, const Batch& batch, std::size_t i) {
    // An eye that moves by this much sees what a box that is so much larger shows to one that does not.
    const V roam = hn::Set(d, in.roam), size = hn::Set(d, float(1 << level) + 2.0f * in.roam);
    const V zero = hn::Zero(d), slack = hn::Set(d, kSlackSquares);
    const auto corner_x = hn::Sub(hn::ShiftLeftSame(hn::Load(di, batch.x + i), level), hn::Set(di, in.eye_x));
    const auto corner_z = hn::Sub(hn::ShiftLeftSame(hn::Load(di, batch.z + i), level), hn::Set(di, in.eye_z));
    Extent e;
    e.low_x = hn::Sub(hn::Sub(hn::ConvertTo(d, corner_x), hn::Set(d, in.frac_x)), roam);
    e.low_z = hn::Sub(hn::Sub(hn::ConvertTo(d, corner_z), hn::Set(d, in.frac_z)), roam);
    e.high_x = hn::Add(e.low_x, size);
    e.high_z = hn::Add(e.low_z, size);
    e.gap_x = hn::Max(hn::Sub(hn::Max(e.low_x, hn::Neg(e.high_x)), slack), zero);
    e.gap_z = hn::Max(hn::Sub(hn::Max(e.low_z, hn::Neg(e.high_z)), slack), zero);
    return e;
}

/// Height over the eye, in squares, and the distances that divide it: the gap where above, else the farthest.
struct Rise {
    V rise, by_x, by_z;
    hn::MFromD<D> above;
};

HWY_INLINE Rise rise_of(const HorizonTraceInput& in, const Extent& e, V height) {
    const V slack = hn::Set(d, kSlackSquares);
    const V far_x = hn::Add(hn::Max(hn::Neg(e.low_x), e.high_x), slack);
    const V far_z = hn::Add(hn::Max(hn::Neg(e.low_z), e.high_z), slack);
    Rise r;
    r.rise =
        hn::MulAdd(hn::Sub(height, hn::Set(d, in.eye_height_m)), hn::Set(d, in.squares_per_m), hn::Set(d, in.climb));
    // Wholly nearer than the near distance: not ours.
    const V far2 = hn::Add(hn::Mul(far_x, far_x), hn::Mul(far_z, far_z));
    r.rise = hn::IfThenElse(hn::Le(far2, hn::Set(d, in.wedges.near_distance * in.wedges.near_distance)),
                            hn::Set(d, -std::numeric_limits<float>::infinity()), r.rise);
    r.above = hn::Gt(r.rise, hn::Zero(d));
    r.by_x = hn::IfThenElse(r.above, e.gap_x, far_x);
    r.by_z = hn::IfThenElse(r.above, e.gap_z, far_z);
    return r;
}

/// Fills rise, a and b of a vector of squares.
HWY_INLINE void store_rise(const Rise& r, Batch& batch, std::size_t i) {
    const V one = hn::Set(d, 1.0f);
    hn::Store(r.rise, d, batch.rise + i);
    hn::Store(hn::Div(one, r.by_x), d, batch.a + i);
    hn::Store(hn::Div(one, r.by_z), d, batch.b + i);
}

/// Coarser squares get a wider margin than what they hold, so that rounding cannot leave a descendant outside.
HWY_INLINE float margin_scale(int level) {
    return float(1 + level);
}

/// Fills rise, a, b, first and count from x, z and height.
void compute_bounds(const HorizonTraceInput& in, int level, Batch& batch) {
    for (std::size_t i = 0; i < 16; i += hn::Lanes(d)) {
        const Extent extent = extent_of(in, level, batch, i);
        const Rise r = rise_of(in, extent, hn::Load(d, batch.height + i));
        store_rise(r, batch, i);
        compute_columns(in.wedges, margin_scale(level), extent, batch.first + i, batch.count + i);
        const auto something = hn::Gt(r.rise, hn::Set(d, -std::numeric_limits<float>::infinity()));
        hn::Store(hn::IfThenElseZero(hn::RebindMask(di, something), hn::Load(di, batch.count + i)), di,
                  batch.count + i);
    }
}

/// Of a vector of squares, what the tests for promise need: multiplied out and rounded in favour of the squares, a
/// column rises to a tangent t only where neither rise * |x| < t * by_x nor rise * |z| < t * by_z. Above the eye |x|
/// and |z| are the wedge's largest, below it the smallest.
struct Contender {
    V rise, by_x, by_z;
    hn::MFromD<D> above;
    hn::MFromD<D> nothing;  ///< to raise with
};

HWY_INLINE Contender contender_of(const Rise& r) {
    Contender who;
    who.rise = hn::Add(r.rise, hn::Mul(hn::Abs(r.rise), hn::Set(d, 2e-6f)));
    who.by_x = r.by_x;
    who.by_z = r.by_z;
    who.above = r.above;
    who.nothing = hn::Eq(r.rise, hn::Set(d, -std::numeric_limits<float>::infinity()));
    return who;
}

/// Where a contender fails to raise a wedge with a tangent. A NaN (nothing known, no gap) is no failure.
HWY_INLINE hn::MFromD<D> fails(const Contender& who, V tangent, V max_x, V max_z, V min_x, V min_z) {
    const V left_x = hn::Mul(who.rise, hn::IfThenElse(who.above, max_x, min_x));
    const V left_z = hn::Mul(who.rise, hn::IfThenElse(who.above, max_z, min_z));
    return hn::Or(hn::Lt(left_x, hn::Mul(tangent, who.by_x)), hn::Lt(left_z, hn::Mul(tangent, who.by_z)));
}

HWY_INLINE std::uint32_t bits_of(hn::MFromD<D> mask) {
    std::uint8_t lanes[8] = {};
    hn::StoreMaskBits(d, mask, lanes);
    return std::uint32_t(lanes[0]) | std::uint32_t(lanes[1]) << 8;
}

/// Fills the batch like compute_bounds, but where a square cannot raise any of its parent's columns.
/// @return bit i: square i may; a necessary condition, cheaper than asking every column.
std::uint32_t compute_promising(const HorizonTraceInput& in, int level, const Survey& survey, Batch& batch) {
    const V lowest = hn::Set(d, survey.lowest);
    const V max_x = hn::Set(d, survey.max_x), max_z = hn::Set(d, survey.max_z);
    const V min_x = hn::Set(d, survey.min_x), min_z = hn::Set(d, survey.min_z);
    std::uint32_t bits = 0;
    for (std::size_t i = 0; i < 16; i += hn::Lanes(d)) {
        const Extent extent = extent_of(in, level, batch, i);
        const Rise r = rise_of(in, extent, hn::Load(d, batch.height + i));
        const Contender who = contender_of(r);
        const auto failed = hn::Or(who.nothing, fails(who, lowest, max_x, max_z, min_x, min_z));
        if (hn::AllTrue(d, failed)) continue;
        compute_columns(in.wedges, margin_scale(level), extent, batch.first + i, batch.count + i);
        bits |= bits_of(hn::Not(failed)) << i;
        store_rise(r, batch, i);
    }
    return bits;
}

/// Those of a batch's squares that raise any of their columns.
HWY_INLINE std::uint32_t raising(const HorizonTraceInput& in, const Batch& batch, std::uint32_t candidates,
                                 const float* tangents) {
    std::uint32_t bits = 0;
    for (; candidates != 0; candidates &= candidates - 1) {
        const int i = std::countr_zero(candidates);
        bits |= std::uint32_t(raises_any(in.wedges, batch.bound(i), tangents)) << i;
    }
    return bits;
}

/// The name of a square of the finest level; of a coarser one, that of its first.
HWY_INLINE std::uint32_t winner_id(const HorizonTraceInput& in, const Square& square) {
    const int shift = square.level - in.finest_level;
    return std::uint32_t((square.z << shift) << in.size_log2 | square.x << shift);
}

HWY_INLINE void raise_by(const HorizonTraceInput& in, const Square& square, float* tangents, std::uint32_t* winner) {
    const auto id = [&] { return winner_id(in, square); };
    raise(in.wedges, square, id, tangents, winner);
}

/// Whether squares one level above the finest are still hardly wider than a column, from any part of this one: then
/// they are taken instead. Depends on places alone, so the result still does not depend on the order of the walk.
HWY_INLINE bool is_distant(const HorizonTraceInput& in, const Square& square) {
    const int size = 1 << square.level;
    const int x = (square.x << square.level) - in.eye_x, z = (square.z << square.level) - in.eye_z;
    const int gap = std::max(std::max(x, -x - size), std::max(z, -z - size));
    return float(gap) > kDistantSquaresPerColumn * float(in.wedges.columns) * float(1 << in.finest_level);
}

/// Collects squares of one level until there are sixteen, then raises the columns by them.
class Primer {
  public:
    Primer(const HorizonTraceInput& in, int level, float* tangents, std::uint32_t* winner)
        : in_(in), level_(level), tangents_(tangents), winner_(winner) {}
    ~Primer() { flush(); }
    void add(int x, int z) {
        batch_.x[count_] = x;
        batch_.z[count_] = z;
        batch_.height[count_] = in_.level_heights[level_][(z << (in_.size_log2 - level_)) + x];
        if (++count_ == 16) flush();
    }

  private:
    void flush() {
        if (count_ == 0) return;
        for (int i = count_; i < 16; ++i) batch_.x[i] = batch_.z[i] = 0, batch_.height[i] = 0.0f;
        compute_bounds(in_, level_, batch_);
        for (int i = 0; i < count_; ++i) raise_by(in_, batch_.at(i, level_), tangents_, winner_);
        count_ = 0;
    }
    const HorizonTraceInput& in_;
    const int level_;
    float* tangents_;
    std::uint32_t* winner_;
    Batch batch_;
    int count_ = 0;
};

/// Whether the squares around (x, z) of the finest level are taken two by two, as the walk decides it.
HWY_INLINE bool is_taken_whole(const HorizonTraceInput& in, int x, int z) {
    Square around{};
    around.x = x >> 2;
    around.z = z >> 2;
    around.level = in.finest_level + 2;
    return is_distant(in, around);
}

/// Replaces each guessed square of the finest level of `coarse` by the tallest one of level `fine` inside it.
void descend_to_tallest(const HorizonTraceInput& coarse, int fine, std::uint32_t* guess) {
    const std::uint32_t mask = (1u << coarse.size_log2) - 1;
    std::uint32_t last = kNoSquare, last_tallest = kNoSquare;
    for (int c = 0; c < coarse.wedges.columns; ++c) {
        if (guess[c] == kNoSquare) continue;
        if (guess[c] != last) {
            last = guess[c];
            std::uint32_t x = last & mask, z = last >> coarse.size_log2;
            const int whole = is_taken_whole(coarse, int(x), int(z)) ? 1 : 0;
            x >>= whole;
            z >>= whole;
            for (int level = coarse.finest_level + whole; level > fine; --level) {
                const float* below = coarse.level_heights[level - 1];
                const std::uint32_t row = 1u << (coarse.size_log2 - level + 1);
                x *= 2;
                z *= 2;
                std::uint32_t tallest = 0;
                for (std::uint32_t child = 1; child < 4; ++child)
                    if (below[(z + child / 2) * row + x + child % 2] > below[(z + tallest / 2) * row + x + tallest % 2])
                        tallest = child;
                x += tallest % 2;
                z += tallest / 2;
            }
            last_tallest = z << coarse.size_log2 | x;
        }
        guess[c] = last_tallest;
    }
}

/// Raises the columns by the squares that are guessed to make the skyline, so that the walk can reject nearly all.
/// @return false where there was no guess.
bool prime(const HorizonTraceInput& in, const std::uint32_t* guess, float* tangents, std::uint32_t* winner,
           std::uint32_t& squares) {
    const int finest = in.finest_level;
    Primer near_squares(in, finest, tangents, winner), distant_squares(in, finest + 1, tangents, winner);
    const std::uint32_t mask = (1u << in.size_log2) - 1;
    std::uint32_t last = kNoSquare;
    bool guessed = false;
    for (int c = 0; c < in.wedges.columns; ++c) {
        const std::uint32_t square = guess[c];
        const bool is_wanted = tangents[c] != std::numeric_limits<float>::infinity();
        if (!is_wanted || square == last || square == kNoSquare) continue;
        last = square;
        const int x = int(square & mask), z = int(square >> in.size_log2);
        if (is_taken_whole(in, x, z))
            distant_squares.add(x >> 1, z >> 1);
        else
            near_squares.add(x, z);
        ++squares;
        guessed = true;
    }
    return guessed;
}

/// Puts the sixteen squares of `level` that make up `parent` into the batch, row by row.
void load_children(const HorizonTraceInput& in, const Square& parent, int level, Batch& batch) {
    const int row = 1 << (in.size_log2 - level);
    const float* heights = in.level_heights[level] + std::ptrdiff_t(parent.z) * 4 * row + std::ptrdiff_t(parent.x) * 4;
    const hn::Full128<float> d4;
    const hn::Full128<std::int32_t> di4;
    const auto x = hn::Iota(di4, parent.x * 4);
    for (int j = 0; j < 4; ++j) {
        hn::Store(x, di4, batch.x + 4 * j);
        hn::Store(hn::Set(di4, parent.z * 4 + j), di4, batch.z + 4 * j);
        hn::Store(hn::LoadU(d4, heights + std::ptrdiff_t(j) * row), d4, batch.height + 4 * j);
    }
}

/// Puts the four squares of `level` that make up `parent` into the batch, and nothing into the rest.
void load_quarters(const HorizonTraceInput& in, const Square& parent, int level, Batch& batch) {
    const int row = 1 << (in.size_log2 - level);
    for (int i = 0; i < 4; ++i) {
        batch.x[i] = parent.x * 2 + i % 2;
        batch.z[i] = parent.z * 2 + i / 2;
        batch.height[i] = in.level_heights[level][std::ptrdiff_t(batch.z[i]) * row + batch.x[i]];
    }
    for (int i = 4; i < 16; ++i) {
        batch.x[i] = batch.x[0];
        batch.z[i] = batch.z[0];
        batch.height[i] = -std::numeric_limits<float>::infinity();
    }
}

/// The heights of the finest levels are larger than the caches near the core.
HWY_INLINE void prefetch_children(const HorizonTraceInput& in, const Square& square) {
    const int level = square.level - 2, row = 1 << (in.size_log2 - level);
    const float* heights = in.level_heights[level] + std::ptrdiff_t(square.z) * 4 * row + std::ptrdiff_t(square.x) * 4;
    for (int j = 0; j < 4; ++j) hwy::Prefetch(heights + std::ptrdiff_t(j) * row);
}

std::uint32_t walk_grid(const HorizonTraceInput& in, float* tangents, std::uint32_t* winner) {
    std::uint32_t squares = 0;
    if (!prime(in, winner, tangents, winner, squares) && in.finest_level + 2 < in.size_log2) {
        // Nothing known of an earlier eye: guess from the horizon of coarser squares.
        HorizonTraceInput coarse = in;
        coarse.finest_level = in.finest_level + 2;
        alignas(64) float coarse_tangents[kMaxHorizonColumns + 16];
        alignas(64) std::uint32_t guess[kMaxHorizonColumns + 16];
        std::copy(tangents, tangents + in.wedges.columns + 16, coarse_tangents);
        std::fill(guess, guess + in.wedges.columns + 16, kNoSquare);
        squares += walk_grid(coarse, coarse_tangents, guess);
        descend_to_tallest(coarse, in.finest_level, guess);
        prime(in, guess, tangents, winner, squares);
    }

    Square stack[16 * 8];
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
        const Square bound = stack[--top];
        if (bound.level == in.finest_level) {  // only where the walk starts there
            raise_by(in, bound, tangents, winner);
            continue;
        }
        if (!raises_any(in.wedges, bound, tangents)) continue;
        const Survey survey = survey_columns(in.wedges, bound, tangents);
        int level = bound.level - 2;
        if ((bound.level - in.finest_level) % 2 == 0 && is_distant(in, bound)) {
            load_quarters(in, bound, ++level, batch);
            squares += 4;
        } else {
            load_children(in, bound, level, batch);
            squares += 16;
        }
        std::uint32_t bits = compute_promising(in, level, survey, batch);
        if (level <= in.finest_level + 1) {
            for (; bits != 0; bits &= bits - 1) raise_by(in, batch.at(std::countr_zero(bits), level), tangents, winner);
        } else {
            bits = raising(in, batch, bits, tangents);
            // Nearest last, so that they are taken first and hide the others.
            const int half = 1 << (bound.level - 1);
            const int nearest = ((bound.x << bound.level) + half < in.eye_x ? 3 : 0) +
                                ((bound.z << bound.level) + half < in.eye_z ? 12 : 0);
            for (int i = 15; i >= 0; --i)
                if (bits >> (i ^ nearest) & 1) {
                    stack[top++] = batch.at(i ^ nearest, level);
                    prefetch_children(in, stack[top - 1]);
                }
        }
    }
    return squares;
}

}  // namespace HWY_NAMESPACE
}  // namespace ff::farfield
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace ff::farfield {
HWY_EXPORT(walk_grid);
std::uint32_t trace_horizon(const HorizonTraceInput& input, float* tangents, std::uint32_t* winner) {
    return HWY_DYNAMIC_DISPATCH(walk_grid)(input, tangents, winner);
}
}  // namespace ff::farfield
#endif
