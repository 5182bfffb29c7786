#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "engine/farfield/reproject_votes.cpp"
#include <hwy/foreach_target.h>  // must come before highway.h
#include <hwy/highway.h>

#include <algorithm>
#include <bit>
#include <limits>

#include "engine/farfield/lane_bits-inl.h"
#include "engine/farfield/reproject_votes.h"

HWY_BEFORE_NAMESPACE();
namespace ff::farfield::reprojection {
namespace HWY_NAMESPACE {
namespace {
namespace hn = hwy::HWY_NAMESPACE;

using U = hn::CappedTag<std::uint32_t, 16>;
using F = hn::RebindToFloat<U>;
using I = hn::RebindToSigned<U>;
constexpr U ui;
constexpr F f;
constexpr I si;
constexpr int kLanes = int(hn::MaxLanes(ui));

HWY_INLINE std::uint32_t bits_of(hn::Mask<U> mask) {
    return farfield::HWY_NAMESPACE::lane_bits(ui, mask);
}

}  // namespace

void ReadTile(const AuxiliaryBand& band, int x, int y, Landed& landed, PrimitiveSet& primitives) {
    const auto first_name = hn::Set(ui, AuxiliaryBand::kAbrupt);  // from here on there is no instance
    for (int j = 0; j < kTileSize + 2; ++j) {
        const std::size_t first = band.index(x, y + j - 1);
        const std::uint32_t *const instance = band.instance.data() + first, *const triangle =
                                                                                band.triangle.data() + first;
        std::uint32_t filled = 0, sky = 0, abrupt = 0, fresh = 0;
        for (int i = 0; i < kTileSize; i += kLanes) {
            const auto here = hn::LoadU(ui, instance + i);
            const auto is_instance = hn::Lt(here, first_name);
            if (!hn::AllTrue(ui, is_instance)) {
                sky |= bits_of(hn::Eq(here, hn::Set(ui, kSkyInstance))) << i;
                abrupt |= bits_of(hn::Eq(here, first_name)) << i;
            }
            const std::uint32_t solid = bits_of(is_instance);
            filled |= solid << i;
            if (solid == 0) continue;
            // A pixel that shows what its left or upper neighbour shows adds nothing.
            const auto own = hn::LoadU(ui, triangle + i);
            const auto same = [&](std::ptrdiff_t offset) {
                return hn::And(hn::Eq(here, hn::LoadU(ui, instance + i - offset)),
                               hn::Eq(own, hn::LoadU(ui, triangle + i - offset)));
            };
            std::uint32_t known = bits_of(same(1));
            if (i == 0) known &= ~1u;  // that neighbour asks this pixel
            if (j > 0) known |= bits_of(same(band.stride));
            fresh |= (solid & ~known) << i;
        }
        filled |= sky;
        const auto border = [&](int i, int inner) {
            if (instance[i] == AuxiliaryBand::kEmpty) return;
            const std::uint32_t bit = 1u << (i + 1);
            if (instance[i] == AuxiliaryBand::kAbrupt) {
                landed.abrupt[j] |= bit;
                return;
            }
            landed.filled[j] |= bit;
            if (instance[i] == kSkyInstance) {
                landed.sky[j] |= bit;
                return;
            }
            const auto shows = [&](std::ptrdiff_t other) {
                return instance[i] == instance[other] && triangle[i] == triangle[other];
            };
            if (!shows(inner) && !(j > 0 && shows(i - band.stride))) primitives.add(instance[i], triangle[i]);
        };
        landed.sky[j] = sky << 1;
        landed.abrupt[j] = abrupt << 1;
        landed.filled[j] = filled << 1;
        border(-1, 0);
        border(kTileSize, kTileSize - 1);
        for (std::uint32_t left = fresh; left != 0; left &= left - 1) {
            const int i = std::countr_zero(left);
            primitives.add(instance[i], triangle[i]);
        }
    }
}

// Least and greatest depth of the 3 x 3 pixels around each of a register, whatever they show.
struct Range {
    hn::Vec<F> least, greatest;
};
HWY_INLINE Range range_around(const AuxiliaryBand& band, int x, int y) {
    Range range{hn::Set(f, 0.0f), hn::Set(f, 0.0f)};
    for (int dy = -1; dy <= 1; ++dy) {
        const float* at = band.depth.data() + band.index(x, y + dy);
        const auto left = hn::LoadU(f, at - 1), middle = hn::LoadU(f, at), right = hn::LoadU(f, at + 1);
        const auto least = hn::Min(left, hn::Min(middle, right)), greatest = hn::Max(left, hn::Max(middle, right));
        range.least = dy < 0 ? least : hn::Min(range.least, least);
        range.greatest = dy < 0 ? greatest : hn::Max(range.greatest, greatest);
    }
    return range;
}

TileMask CountVotes(const AuxiliaryBand& band, const VisibilityBuffer& hits, const TileRequest& tile,
                    const TileMask& all_solid, const ReprojectSettings& settings) {
    TileMask mask;
    const bool by_surface = settings.vote == Vote::surface;
    const auto too_few = hn::Set(si, settings.min_count - 1);
    for (int j = 0; j < kTileSize; ++j) {
        if (tile.rows[j] == 0) continue;
        std::uint32_t accepted = 0;
        for (int i = 0; i < kTileSize; i += kLanes) {
            const std::size_t hit = hits.index(tile.x + i, tile.y + j);
            const auto instance = hn::LoadU(ui, hits.instance.data() + hit);
            const auto triangle = hn::LoadU(ui, hits.triangle.data() + hit);
            const auto depth = hn::LoadU(f, hits.depth.data() + hit);
            const auto slack = hn::Mul(depth, hn::Set(f, settings.surface_share));
            const std::uint32_t asked = (std::uint32_t(tile.rows[j]) >> i) & ((1u << kLanes) - 1u);
            if (asked == 0) continue;
            // On a surface all nine agree.
            if (by_surface && (asked & ~(std::uint32_t(all_solid.rows[j]) >> i)) == 0) {
                const Range range = range_around(band, tile.x + i, tile.y + j);
                const auto agree = bits_of(hn::RebindMask(ui, hn::And(hn::Le(hn::Sub(range.greatest, depth), slack),
                                                                      hn::Le(hn::Sub(depth, range.least), slack))));
                if ((asked & ~agree) == 0) {
                    accepted |= asked << i;
                    continue;
                }
            }
            auto votes = hn::Zero(si);
            for (int dy = -1; dy <= 1; ++dy)
                for (int dx = -1; dx <= 1; ++dx) {
                    const std::size_t at = band.index(tile.x + i + dx, tile.y + j + dy);
                    const auto other = hn::LoadU(ui, band.instance.data() + at);
                    auto agrees =
                        hn::And(hn::Eq(other, instance), hn::Eq(hn::LoadU(ui, band.triangle.data() + at), triangle));
                    if (by_surface) {
                        const auto apart = hn::Abs(hn::Sub(hn::LoadU(f, band.depth.data() + at), depth));
                        const auto exists = hn::Lt(other, hn::Set(ui, AuxiliaryBand::kAbrupt));
                        agrees = hn::Or(agrees, hn::And(exists, hn::RebindMask(ui, hn::Le(apart, slack))));
                    }
                    votes = hn::Sub(votes, hn::VecFromMask(si, hn::RebindMask(si, agrees)));
                }
            accepted |= bits_of(hn::RebindMask(ui, hn::Gt(votes, too_few))) << i;
        }
        mask.rows[j] = std::uint16_t(accepted & tile.rows[j]);
    }
    return mask;
}

}  // namespace HWY_NAMESPACE
}  // namespace ff::farfield::reprojection
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace ff::farfield::reprojection {
HWY_EXPORT(ReadTile);
HWY_EXPORT(CountVotes);

void read_tile(const AuxiliaryBand& band, int x, int y, Landed& landed, PrimitiveSet& primitives) {
    HWY_DYNAMIC_DISPATCH(ReadTile)(band, x, y, landed, primitives);
}

TileMask count_votes(const AuxiliaryBand& band, const VisibilityBuffer& hits, const TileRequest& tile,
                     const TileMask& all_solid, const ReprojectSettings& settings) {
    return HWY_DYNAMIC_DISPATCH(CountVotes)(band, hits, tile, all_solid, settings);
}

void write_origins(const AuxiliaryBand& band, const TileRequest& tile, const TileMask& shifted, float surface_share,
                   VisibilityBuffer& out) {
    for (int j = 0; j < kTileSize; ++j)
        for (std::uint32_t left = tile.rows[j]; left != 0; left &= left - 1) {
            const int i = std::countr_zero(left), x = tile.x + i, y = tile.y + j;
            float& origin = out.depth[out.index(x, y)];
            origin = 0.0f;
            if (((shifted.rows[j] >> i) & 1) == 0) continue;
            float nearest = std::numeric_limits<float>::infinity();
            for (int dy = -1; dy <= 1; ++dy)
                for (int dx = -1; dx <= 1; ++dx) {
                    const std::size_t at = band.index(x + dx, y + dy);
                    if (band.instance[at] < AuxiliaryBand::kAbrupt) nearest = std::min(nearest, band.depth[at]);
                }
            if (nearest < std::numeric_limits<float>::infinity()) origin = nearest * (1.0f - surface_share);
        }
}

TileMask count_around(const std::uint32_t (&bits)[kTileSize + 2], int least) {
    constexpr std::uint32_t kWhole = (1u << (kTileSize + 2)) - 1u;
    std::uint32_t everywhere = kWhole;
    for (const std::uint32_t row : bits) everywhere &= row;
    if (everywhere == kWhole) {
        TileMask all;
        std::fill(std::begin(all.rows), std::end(all.rows), std::uint16_t(0xFFFF));
        return all;
    }
    // All columns of a row at once: numbers of up to four bits, a word a digit.
    std::uint32_t ones[kTileSize + 2], twos[kTileSize + 2];
    for (int j = 0; j < kTileSize + 2; ++j) {
        const std::uint32_t left = bits[j], middle = bits[j] >> 1, right = bits[j] >> 2;
        ones[j] = left ^ middle ^ right;
        twos[j] = (left & middle) | (right & (left | middle));
    }
    TileMask mask;
    for (int j = 0; j < kTileSize; ++j) {
        const std::uint32_t carry = (ones[j] & ones[j + 1]) | (ones[j + 2] & (ones[j] | ones[j + 1]));
        const std::uint32_t t0 = twos[j], t1 = twos[j + 1], t2 = twos[j + 2];
        const std::uint32_t sum = t0 ^ t1 ^ t2, over = (t0 & t1) | (t2 & (t0 | t1));
        const std::uint32_t digits[4] = {ones[j] ^ ones[j + 1] ^ ones[j + 2], sum ^ carry, over ^ (sum & carry),
                                         over & sum & carry};
        // Compare from the highest digit down.
        std::uint32_t greater = 0, equal = ~0u;
        for (int digit = 3; digit >= 0; --digit) {
            const std::uint32_t wanted = ((least >> digit) & 1) != 0 ? ~0u : 0u;
            greater |= equal & digits[digit] & ~wanted;
            equal &= ~(digits[digit] ^ wanted);
        }
        mask.rows[j] = std::uint16_t(greater | equal);
    }
    return mask;
}

}  // namespace ff::farfield::reprojection
#endif
