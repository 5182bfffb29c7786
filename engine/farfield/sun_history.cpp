#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "engine/farfield/sun_history.cpp"
#include <hwy/foreach_target.h>  // must come before highway.h
#include <hwy/highway.h>

#include <algorithm>
#include <atomic>
#include <bit>
#include <cmath>
#include <cstring>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include "engine/core/jobs.h"
#include "engine/farfield/sun_history.h"

#ifndef FF_SUN_HISTORY_SHARED_
#define FF_SUN_HISTORY_SHARED_
namespace ff::farfield::sun {

constexpr std::uint32_t kDepthBits = 0xFFFFF000u;
constexpr std::uint32_t kLitBit = 1u << 8;
/// None of the eight round it sees more or less of the sun: set over whole frames, once all is known.
constexpr std::uint32_t kSettledBit = 1u << 9;
constexpr std::uint32_t kAgeBits = 0xFFu;
/// Columns of the block of depths round a tile: a border pixel on each side.
constexpr int kBlockStride = kTileSize + 2;

/// From a pixel of this frame to where its point was in the last one.
struct Reprojection {
    const std::uint32_t* words;
    int width, height, stride;
    Mat3 last_from_camera;                                         ///< camera axes of this frame to those of the last
    Vec3 offset;                                                   ///< this eye in the last camera's axes
    float u_step, u_first, v_step, v_first;                        ///< this view
    float last_u_scale, last_u_first, last_v_scale, last_v_first;  ///< the last one; scale = 1 / step
};

/// One tile on its way through the kernel. Pointers are to its first pixel.
struct Tile {
    int x, y;
    std::uint32_t static_instances;  ///< those below stand still
    const std::uint32_t* instances;  ///< rows of `stride`
    const float* depths;             ///< rows of `depth_stride`; the pixels round the tile are there, too
    std::uint32_t* words;            ///< out where answered; else 0 as before
    std::uint8_t* lit;               ///< out where answered
    std::ptrdiff_t stride, depth_stride;
    std::uint16_t rows[kTileSize];  ///< in: asked for; out: surfaces that are left
    std::uint16_t anew[kTileSize];  ///< those that the last frame may not answer
    std::uint32_t answered;         ///< out: how many
};

}  // namespace ff::farfield::sun
#endif

HWY_BEFORE_NAMESPACE();
namespace ff::farfield::sun {
namespace HWY_NAMESPACE {
namespace {
namespace hn = hwy::HWY_NAMESPACE;

using F = hn::CappedTag<float, kTileSize>;
using U = hn::RebindToUnsigned<F>;
using I = hn::RebindToSigned<F>;
constexpr F f;
constexpr U ui;
constexpr I si;
using VF = hn::Vec<F>;
using VU = hn::Vec<U>;

/// Points are looked for between pixel centres of the last frame; this near to one (pixels), it alone is asked: the
/// rounding of a viewer who rests.
constexpr float kOnPixel = 1.0f / 64.0f;
/// Depths differ by this share for the records' and the reprojection's rounding ...
constexpr float kDepthShare = 0.002f;
/// ... and by this many times what they change from pixel to pixel in this frame,
constexpr float kDepthSteps = 1.5f;
/// which is at most this share: more is no slope but two silhouettes.
constexpr float kMaxStepShare = 0.2f;

VF splat(float x) {
    return hn::Set(f, x);
}

/// How much depth changes to the more similar of two neighbours: across a silhouette that is the own surface.
VF step_between(VF own, const float* before, const float* after) {
    return hn::Min(hn::Abs(hn::Sub(own, hn::LoadU(f, before))), hn::Abs(hn::Sub(hn::LoadU(f, after), own)));
}

std::uint32_t bits_of(hn::Mask<F> mask) {
    std::uint8_t bytes[8] = {};
    hn::StoreMaskBits(f, mask, bytes);
    return std::uint32_t(bytes[0]) | std::uint32_t(bytes[1]) << 8;
}

/// Where a vector's points lie in the last frame: columns, and row offsets, of the four pixels round each.
struct Corners {
    hn::Vec<I> x0, x1, y0, y1;
};

/// Reads words at the corners: as they lie in memory where the points follow each other as the pixels do, which is
/// nearly everywhere.
class WordsAround {
  public:
    HWY_INLINE WordsAround(const Reprojection& r, const Corners& c) : r_(r), c_(c) {
        const auto low = hn::Add(c.y0, c.x0);
        first_ = hn::GetLane(low);
        right_ = hn::GetLane(c.x1) - hn::GetLane(c.x0);
        down_ = hn::GetLane(c.y1) - hn::GetLane(c.y0);
        const auto in_row = hn::Add(hn::Set(si, first_), hn::Iota(si, 0));
        const auto follow = hn::And(hn::Eq(low, in_row), hn::And(hn::Eq(hn::Sub(c.x1, c.x0), hn::Set(si, right_)),
                                                                 hn::Eq(hn::Sub(c.y1, c.y0), hn::Set(si, down_))));
        follows_ = hn::AllTrue(si, follow);
    }
    /// The corner in the left or right column and the upper or lower row.
    template <bool right, bool lower>
    HWY_INLINE VU at() const {
        if (follows_) return hn::LoadU(ui, r_.words + first_ + (right ? right_ : 0) + (lower ? down_ : 0));
        return hn::GatherIndex(ui, r_.words, hn::Add(lower ? c_.y1 : c_.y0, right ? c_.x1 : c_.x0));
    }

  private:
    const Reprojection& r_;
    const Corners& c_;
    std::int32_t first_, right_, down_;
    bool follows_;
};

/// Asks the last frame about a vector of pixels and keeps what it answers.
/// @param wanted  bits of the lanes that may be answered
/// @return bits of those that are
HWY_INLINE std::uint32_t reuse_lanes(const Reprojection& r, const Tile& tile, int i, int j, std::uint32_t wanted) {
    const float v = (float(tile.y + j) + 0.5f) * r.v_step + r.v_first;
    const float* at = tile.depths + j * tile.depth_stride + i;
    const VF depth = hn::LoadU(f, at);
    const VF column = hn::Add(hn::ConvertTo(f, hn::Iota(si, tile.x + i)), splat(0.5f));
    const VF ray_u = hn::MulAdd(column, splat(r.u_step), splat(r.u_first));
    const auto axis = [&](int k) HWY_ATTR {
        const VF direction = hn::MulAdd(splat(r.last_from_camera[0][k]), ray_u,
                                        splat(r.last_from_camera[1][k] * v - r.last_from_camera[2][k]));
        return hn::MulAdd(direction, depth, splat(r.offset[k]));
    };
    const VF last_depth = hn::Neg(axis(2));
    const VF inverse = hn::Div(splat(1.0f), hn::Max(last_depth, splat(1e-6f)));
    const auto pixel = [&](VF along, float first, float scale) HWY_ATTR {
        return hn::Sub(hn::Mul(hn::Sub(hn::Mul(along, inverse), splat(first)), splat(scale)), splat(0.5f));
    };
    const VF x = pixel(axis(0), r.last_u_first, r.last_u_scale);
    const VF y = pixel(axis(1), r.last_v_first, r.last_v_scale);
    const auto in_view = [&](VF p, int size) HWY_ATTR {
        return hn::And(hn::Ge(p, splat(-kOnPixel)), hn::Le(p, splat(float(size - 1) + kOnPixel)));
    };
    auto good = hn::And(hn::And(in_view(x, r.width), in_view(y, r.height)), hn::Gt(last_depth, splat(1e-5f)));
    if (hn::AllFalse(f, good)) return 0;

    const auto low = [&](VF p, int size) HWY_ATTR {
        const VF floor = hn::Floor(hn::Add(p, splat(kOnPixel)));
        return hn::ConvertTo(si, hn::Min(hn::Max(floor, hn::Zero(f)), splat(float(size - 1))));
    };
    const auto high = [&](VF p, int size) HWY_ATTR {
        const VF ceil = hn::Ceil(hn::Sub(p, splat(kOnPixel)));
        return hn::ConvertTo(si, hn::Min(hn::Max(ceil, hn::Zero(f)), splat(float(size - 1))));
    };
    const auto stride = hn::Set(si, r.stride);
    const Corners corners{low(x, r.width), high(x, r.width), hn::Mul(low(y, r.height), stride),
                          hn::Mul(high(y, r.height), stride)};
    const WordsAround words(r, corners);

    const VF steps = hn::Add(step_between(depth, at - 1, at + 1),
                             step_between(depth, at - tile.depth_stride, at + tile.depth_stride));
    const VF slope = hn::Min(steps, hn::Mul(splat(kMaxStepShare), last_depth));
    const VF slack = hn::MulAdd(splat(kDepthSteps), slope, hn::Mul(splat(kDepthShare), last_depth));
    VU all = hn::Set(ui, ~0u), any = hn::Zero(ui), age = hn::Zero(ui);
    const auto ask = [&](VU word) HWY_ATTR {
        const VF seen = hn::BitCast(f, hn::And(word, hn::Set(ui, kDepthBits)));
        good = hn::And(good, hn::Le(hn::Abs(hn::Sub(seen, last_depth)), slack));
        all = hn::And(all, word);
        any = hn::Or(any, word);
        age = hn::Max(age, hn::And(word, hn::Set(ui, kAgeBits)));
    };
    ask(words.at<false, false>());
    ask(words.at<true, false>());
    ask(words.at<false, true>());
    ask(words.at<true, true>());
    const VU lit_bit = hn::Set(ui, kLitBit), light = hn::And(all, lit_bit);
    good = hn::And(good, hn::RebindMask(f, hn::Eq(light, hn::And(any, lit_bit))));
    // Those round them must agree, too, or the light may change within a pixel; unless the point is a pixel's own.
    const auto on_pixel = hn::And(hn::Eq(corners.x0, corners.x1), hn::Eq(corners.y0, corners.y1));
    const auto settled = hn::Ne(hn::And(all, hn::Set(ui, kSettledBit)), hn::Zero(ui));
    good = hn::And(good, hn::Or(hn::RebindMask(f, on_pixel), hn::RebindMask(f, settled)));
    const std::uint32_t found = bits_of(good) & wanted;
    if (found == 0) return 0;

    std::uint8_t found_bytes[8] = {std::uint8_t(found), std::uint8_t(found >> 8)};
    const auto answered = hn::LoadMaskBits(ui, found_bytes);
    const VU older = hn::Min(hn::Add(age, hn::Set(ui, 1u)), hn::Set(ui, kAgeBits));
    const VU word = hn::Or(hn::Or(hn::And(hn::BitCast(ui, depth), hn::Set(ui, kDepthBits)), light), older);
    hn::StoreU(hn::IfThenElseZero(answered, word), ui, tile.words + j * tile.stride + i);
    const hn::Rebind<std::uint8_t, I> bytes;
    std::uint8_t* lit = tile.lit + j * tile.stride + i;
    const VU before = hn::PromoteTo(ui, hn::LoadU(bytes, lit));
    const VU after =
        hn::IfThenElse(answered, hn::IfThenElseZero(hn::Ne(light, hn::Zero(ui)), hn::Set(ui, 255u)), before);
    hn::StoreU(hn::DemoteTo(bytes, hn::BitCast(si, after)), bytes, lit);
    return found;
}

void reuse_row(const Reprojection& r, Tile& tile, int j) {
    const int lanes = int(hn::Lanes(f));
    std::uint32_t left = 0;
    for (int i = 0; i < kTileSize; i += lanes) {
        const std::uint32_t asked = std::uint32_t(tile.rows[j]) >> i & ((1u << lanes) - 1u);
        if (asked == 0) continue;
        const VU instance = hn::LoadU(ui, tile.instances + j * tile.stride + i);
        const auto below = [&](std::uint32_t id)
                               HWY_ATTR { return bits_of(hn::RebindMask(f, hn::Lt(instance, hn::Set(ui, id)))); };
        std::uint32_t surfaces = asked & below(kUnresolved);
        const std::uint32_t wanted = surfaces & ~(std::uint32_t(tile.anew[j]) >> i) & below(tile.static_instances);
        if (wanted != 0) {
            const std::uint32_t found = reuse_lanes(r, tile, i, j, wanted);
            tile.answered += std::uint32_t(std::popcount(found));
            surfaces &= ~found;
        }
        left |= surfaces << i;
    }
    tile.rows[j] = std::uint16_t(left);
}

}  // namespace

/// Sets kSettledBit in one row of words. Rows above and below are the row itself at the image's border.
void SettleRow(const std::uint32_t* above, std::uint32_t* row, const std::uint32_t* below, int width) {
    const std::uint32_t* const rows[3] = {above, row, below};
    const VU lit_bit = hn::Set(ui, kLitBit), zero = hn::Zero(ui);
    const int lanes = int(hn::Lanes(f));
    const auto settle_one = [&](int x) {
        bool agree = row[x] != 0;
        for (const std::uint32_t* const at : rows)
            for (int i = std::max(0, x - 1); i <= std::min(width - 1, x + 1); ++i)
                agree &= at[i] == 0 || ((at[i] ^ row[x]) & kLitBit) == 0;
        if (agree) row[x] |= kSettledBit;
    };
    int x = 1;
    if (width > 0) settle_one(0);
    for (; x + lanes < width; x += lanes) {
        const VU own = hn::LoadU(ui, row + x);
        VU differ = zero;
        for (const std::uint32_t* const at : rows)
            for (int i = x - 1; i <= x + 1; ++i) {
                const VU word = hn::LoadU(ui, at + i);
                differ = hn::Or(differ, hn::IfThenElseZero(hn::Ne(word, zero), hn::Xor(word, own)));
            }
        const auto agree = hn::And(hn::Eq(hn::And(differ, lit_bit), zero), hn::Ne(own, zero));
        hn::StoreU(hn::Or(own, hn::IfThenElseZero(agree, hn::Set(ui, kSettledBit))), ui, row + x);
    }
    for (; x < width; ++x) settle_one(x);
}

void ReuseTiles(const Reprojection& r, std::span<Tile> tiles) {
    // Row by row over neighbours: memory is read as it lies, which the processor sees coming.
    for (int j = 0; j < kTileSize; ++j)
        for (Tile& tile : tiles)
            if (tile.rows[j] != 0) reuse_row(r, tile, j);
}

}  // namespace HWY_NAMESPACE
}  // namespace ff::farfield::sun
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace ff::farfield {
namespace sun {
HWY_EXPORT(ReuseTiles);
HWY_EXPORT(SettleRow);
void reuse_tiles(const Reprojection& reprojection, std::span<Tile> tiles) {
    HWY_DYNAMIC_DISPATCH(ReuseTiles)(reprojection, tiles);
}
void settle_row(const std::uint32_t* above, std::uint32_t* row, const std::uint32_t* below, int width) {
    HWY_DYNAMIC_DISPATCH(SettleRow)(above, row, below, width);
}
}  // namespace sun

namespace {

constexpr std::size_t kTilesPerTask = 16;

sun::Reprojection make_reprojection(const PinholeView& view, const PinholeView& last) {
    const Mat3 last_camera_from_world = glm::transpose(last.world_from_camera);
    sun::Reprojection r{};
    r.last_from_camera = last_camera_from_world * view.world_from_camera;
    r.offset = last_camera_from_world * Vec3(view.position - last.position);
    r.u_step = view.u_step;
    r.u_first = view.u_first;
    r.v_step = view.v_step;
    r.v_first = view.v_first;
    r.last_u_scale = 1.0f / last.u_step;
    r.last_u_first = last.u_first;
    r.last_v_scale = 1.0f / last.v_step;
    r.last_v_first = last.v_first;
    return r;
}

/// Depths of a tile and of the pixels round it; beyond the image those of its border.
void load_depths(const VisibilityBuffer& visibility, int x, int y, float* out) {
    for (int j = -1; j <= kTileSize; ++j) {
        const int row = std::clamp(y + j, 0, visibility.height - 1);
        const float* depths = visibility.depth.data() + visibility.index(0, row);
        float* to = out + (j + 1) * sun::kBlockStride;
        if (x > 0 && x + kTileSize < visibility.width) {
            std::memcpy(to, depths + x - 1, sizeof(float) * sun::kBlockStride);
            continue;
        }
        for (int i = -1; i <= kTileSize; ++i) to[i + 1] = depths[std::clamp(x + i, 0, visibility.width - 1)];
    }
}

/// Whether a tile is looked at anew in this frame.
bool is_due(const TileRequest& tile, std::uint64_t frame, int refresh_frames) {
    if (refresh_frames == 0) return false;
    std::uint32_t hash =
        std::uint32_t(tile.x / kTileSize) * 0x9E3779B1u ^ std::uint32_t(tile.y / kTileSize) * 0x85EBCA6Bu;
    hash ^= hash >> 15;
    hash *= 0x2C1B3C6Du;
    hash ^= hash >> 13;
    return hash % std::uint32_t(refresh_frames) == frame % std::uint64_t(refresh_frames);
}

/// Drops the pixels of a request that lie beyond the image.
void trim(int width, int height, TileRequest& tile) {
    const int columns = std::clamp(width - tile.x, 0, kTileSize);
    for (int j = 0; j < kTileSize; ++j)
        tile.rows[j] = std::uint16_t(tile.y + j < height ? tile.rows[j] & ((1u << columns) - 1u) : 0u);
}

}  // namespace

void SunHistory::begin_frame(const SunHistoryInput& input) {
    const VisibilityBuffer& visibility = input.visibility;
    if (input.to_sun != to_sun_) clear();
    to_sun_ = input.to_sun;
    ++frame_;
    const std::size_t count = std::size_t(visibility.stride) * std::size_t(visibility.rows);
    current_.words.resize(std::max(count, current_.words.size()));
    current_.width = visibility.width;
    current_.height = visibility.height;
    current_.stride = visibility.stride;
    current_.view = input.view;
    std::memset(current_.words.data(), 0, count * sizeof(std::uint32_t));
    moving_.assign(last_moving_.begin(), last_moving_.end());
    moving_.insert(moving_.end(), input.moving.begin(), input.moving.end());
    last_moving_.assign(input.moving.begin(), input.moving.end());
    shadows_.begin(input.view, moving_, input.to_sun);
    undecided_.assign(input.tiles.begin(), input.tiles.end());
}

std::uint64_t SunHistory::reuse(const SunHistoryInput& input, std::uint8_t* lit, std::vector<TileRequest>& left) {
    begin_frame(input);
    const VisibilityBuffer& visibility = input.visibility;
    const bool knows = last_.width > 0;
    sun::Reprojection reprojection{};
    if (knows) {
        reprojection = make_reprojection(input.view, last_.view);
        reprojection.words = last_.words.data();
        reprojection.width = last_.width;
        reprojection.height = last_.height;
        reprojection.stride = last_.stride;
    }
    std::atomic<std::uint64_t> total{0};
    parallel_ranges(input.tiles.size(), kTilesPerTask, [&](std::size_t begin, std::size_t end) {
        float blocks[kTilesPerTask][sun::kBlockStride * sun::kBlockStride];
        sun::Tile tiles[kTilesPerTask];
        for (std::size_t t = begin; t < end; ++t) {
            TileRequest& request = undecided_[t];
            trim(visibility.width, visibility.height, request);
            const std::size_t first = visibility.index(request.x, request.y);
            const bool at_border = request.x == 0 || request.y == 0 || request.x + kTileSize >= visibility.width ||
                                   request.y + kTileSize >= visibility.height;
            float* const block = blocks[t - begin];
            if (at_border) load_depths(visibility, request.x, request.y, block);
            tiles[t - begin] = {.x = request.x,
                                .y = request.y,
                                .static_instances = input.static_instances,
                                .instances = visibility.instance.data() + first,
                                .depths = at_border ? block + sun::kBlockStride + 1 : visibility.depth.data() + first,
                                .words = current_.words.data() + first,
                                .lit = lit + first,
                                .stride = visibility.stride,
                                .depth_stride = at_border ? sun::kBlockStride : visibility.stride};
            std::copy(std::begin(request.rows), std::end(request.rows), tiles[t - begin].rows);
            TileRequest anew = request;
            if (knows && !is_due(request, frame_, input.refresh_frames)) (void)shadows_.find(visibility, anew);
            std::copy(std::begin(anew.rows), std::end(anew.rows), tiles[t - begin].anew);
        }
        sun::reuse_tiles(reprojection, std::span(tiles, end - begin));
        std::uint64_t count = 0;
        for (std::size_t t = begin; t < end; ++t) {
            std::copy(std::begin(tiles[t - begin].rows), std::end(tiles[t - begin].rows), undecided_[t].rows);
            count += tiles[t - begin].answered;
        }
        total.fetch_add(count, std::memory_order_relaxed);
    });
    left.clear();
    for (const TileRequest& request : undecided_)
        if (!request.is_empty()) left.push_back(request);
    return total;
}

void SunHistory::commit(const SunHistoryInput& input, std::span<const TileRequest> cast, const std::uint8_t* lit) {
    const VisibilityBuffer& visibility = input.visibility;
    parallel_ranges(cast.size(), 4 * kTilesPerTask, [&](std::size_t begin, std::size_t end) {
        for (const TileRequest& request : cast.subspan(begin, end - begin)) {
            for (int j = 0; j < kTileSize; ++j) {
                const std::size_t first = visibility.index(request.x, request.y + j);
                for (std::uint32_t bits = request.rows[j]; bits != 0; bits &= bits - 1) {
                    const std::size_t at = first + std::size_t(std::countr_zero(bits));
                    if (visibility.instance[at] >= input.static_instances) continue;
                    const std::uint32_t depth = std::bit_cast<std::uint32_t>(visibility.depth[at]) & sun::kDepthBits;
                    current_.words[at] = depth | (lit[at] != 0 ? sun::kLitBit : 0u);
                }
            }
        }
    });
    settle();
    std::swap(last_, current_);
}

void SunHistory::settle() {
    const auto row_at = [&](int y) { return current_.words.data() + std::size_t(y) * std::size_t(current_.stride); };
    const int last = current_.height - 1;
    // Every other row at a time: a row is read by its neighbours.
    for (int turn = 0; turn < 2; ++turn)
        parallel_ranges(std::size_t((current_.height + 1 - turn) / 2), kTilesPerTask,
                        [&](std::size_t begin, std::size_t end) {
                            for (int y = 2 * int(begin) + turn; y < 2 * int(end) + turn; y += 2)
                                sun::settle_row(row_at(std::max(y - 1, 0)), row_at(y), row_at(std::min(y + 1, last)),
                                                current_.width);
                        });
}

int SunHistory::age(int x, int y) const {
    if (last_.width == 0) return -1;
    const std::uint32_t word = last_.words[std::size_t(y) * std::size_t(last_.stride) + std::size_t(x)];
    return word == 0 ? -1 : int(word & sun::kAgeBits);
}

}  // namespace ff::farfield
#endif
