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

/// One tile on its way through the kernel.
struct Tile {
    int x, y;
    std::uint16_t wanted[kTileSize];            ///< static surfaces, but for blocks that are due
    float depths[kBlockStride * kBlockStride];  ///< pixel (i - 1, j - 1) of the tile; the image's border repeats
    std::uint16_t answered[kTileSize];          ///< out
    std::uint32_t* out_words;                   ///< out, at the tile's first pixel
    std::uint8_t* out_lit;                      ///< out, likewise
    std::size_t out_stride;
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

void reuse_tile(const Reprojection& r, Tile& tile) {
    const int lanes = int(hn::Lanes(f));
    for (int j = 0; j < kTileSize; ++j) {
        tile.answered[j] = 0;
        if (tile.wanted[j] == 0) continue;
        const float v = (float(tile.y + j) + 0.5f) * r.v_step + r.v_first;
        for (int i = 0; i < kTileSize; i += lanes) {
            const std::uint32_t wanted = std::uint32_t(tile.wanted[j]) >> i & ((1u << lanes) - 1u);
            if (wanted == 0) continue;
            const float* at = tile.depths + (j + 1) * kBlockStride + i + 1;
            const VF depth = hn::LoadU(f, at);
            const VF column = hn::Add(hn::ConvertTo(f, hn::Iota(si, tile.x + i)), splat(0.5f));
            const VF ray_u = hn::MulAdd(column, splat(r.u_step), splat(r.u_first));
            const auto row_of = [&](int k) HWY_ATTR {
                const VF direction = hn::MulAdd(splat(r.last_from_camera[0][k]), ray_u,
                                                splat(r.last_from_camera[1][k] * v - r.last_from_camera[2][k]));
                return hn::MulAdd(direction, depth, splat(r.offset[k]));
            };
            const VF last_depth = hn::Neg(row_of(2));
            const VF inverse = hn::Div(splat(1.0f), hn::Max(last_depth, splat(1e-6f)));
            const auto pixel_of = [&](VF along, float first, float scale) HWY_ATTR {
                return hn::Sub(hn::Mul(hn::Sub(hn::Mul(along, inverse), splat(first)), splat(scale)), splat(0.5f));
            };
            const VF x = pixel_of(row_of(0), r.last_u_first, r.last_u_scale);
            const VF y = pixel_of(row_of(1), r.last_v_first, r.last_v_scale);
            const auto in_view = [&](VF p, int size) HWY_ATTR {
                return hn::And(hn::Ge(p, splat(-kOnPixel)), hn::Le(p, splat(float(size - 1) + kOnPixel)));
            };
            auto good = hn::And(hn::And(in_view(x, r.width), in_view(y, r.height)), hn::Gt(last_depth, splat(1e-5f)));
            if (hn::AllFalse(f, good)) continue;

            const VF last_column = splat(float(r.width - 1)), last_row = splat(float(r.height - 1));
            const auto low_of = [&](VF p, VF most) HWY_ATTR {
                return hn::Min(hn::Max(hn::Floor(hn::Add(p, splat(kOnPixel))), hn::Zero(f)), most);
            };
            const auto high_of = [&](VF p, VF most) HWY_ATTR {
                return hn::Min(hn::Max(hn::Ceil(hn::Sub(p, splat(kOnPixel))), hn::Zero(f)), most);
            };
            const auto x0 = hn::ConvertTo(si, low_of(x, last_column)), x1 = hn::ConvertTo(si, high_of(x, last_column));
            const auto stride = hn::Set(si, r.stride);
            const auto y0 = hn::Mul(hn::ConvertTo(si, low_of(y, last_row)), stride);
            const auto y1 = hn::Mul(hn::ConvertTo(si, high_of(y, last_row)), stride);

            const VF steps =
                hn::Add(step_between(depth, at - 1, at + 1), step_between(depth, at - kBlockStride, at + kBlockStride));
            const VF slope = hn::Min(steps, hn::Mul(splat(kMaxStepShare), last_depth));
            const VF slack = hn::MulAdd(splat(kDepthSteps), slope, hn::Mul(splat(kDepthShare), last_depth));
            VU all = hn::Set(ui, ~0u), any = hn::Zero(ui), age = hn::Zero(ui);
            const auto ask = [&](auto index) HWY_ATTR {
                const VU word = hn::GatherIndex(ui, r.words, index);
                const VF seen = hn::BitCast(f, hn::And(word, hn::Set(ui, kDepthBits)));
                good = hn::And(good, hn::Le(hn::Abs(hn::Sub(seen, last_depth)), slack));
                all = hn::And(all, word);
                any = hn::Or(any, word);
                age = hn::Max(age, hn::And(word, hn::Set(ui, kAgeBits)));
            };
            ask(hn::Add(y0, x0));
            ask(hn::Add(y0, x1));
            ask(hn::Add(y1, x0));
            ask(hn::Add(y1, x1));
            const VU lit = hn::And(all, hn::Set(ui, kLitBit));
            good = hn::And(good, hn::RebindMask(f, hn::Eq(lit, hn::And(any, hn::Set(ui, kLitBit)))));

            std::uint8_t bytes[8] = {};
            hn::StoreMaskBits(f, good, bytes);
            const std::uint32_t found = (std::uint32_t(bytes[0]) | std::uint32_t(bytes[1]) << 8) & wanted;
            if (found == 0) continue;
            tile.answered[j] = std::uint16_t(tile.answered[j] | found << i);
            const VU older = hn::Min(hn::Add(age, hn::Set(ui, 1u)), hn::Set(ui, kAgeBits));
            const VU word = hn::Or(hn::Or(hn::And(hn::BitCast(ui, depth), hn::Set(ui, kDepthBits)), lit), older);
            alignas(64) std::uint32_t words[kTileSize];
            hn::Store(word, ui, words);
            const std::size_t first = std::size_t(j) * tile.out_stride + std::size_t(i);
            for (std::uint32_t bits = found; bits != 0; bits &= bits - 1) {
                const int lane = std::countr_zero(bits);
                tile.out_words[first + std::size_t(lane)] = words[lane];
                tile.out_lit[first + std::size_t(lane)] = words[lane] & kLitBit ? 255 : 0;
            }
        }
    }
}

}  // namespace

void ReuseTile(const Reprojection& r, Tile& tile) {
    reuse_tile(r, tile);
}

}  // namespace HWY_NAMESPACE
}  // namespace ff::farfield::sun
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace ff::farfield {
namespace sun {
HWY_EXPORT(ReuseTile);
void reuse_tile(const Reprojection& reprojection, Tile& tile) {
    HWY_DYNAMIC_DISPATCH(ReuseTile)(reprojection, tile);
}
}  // namespace sun

namespace {

constexpr std::size_t kTilesPerTask = 16;
constexpr int kRefreshBlock = 4;  ///< pixels a side: what is cast together is near together

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

/// Bit i: the pixel sees a surface that stands still.
std::uint16_t static_pixels(const VisibilityBuffer& visibility, std::size_t first, std::uint16_t row,
                            std::uint32_t static_instances) {
    std::uint32_t bits = 0;
    for (int i = 0; i < kTileSize; ++i)
        bits |= std::uint32_t(visibility.instance[first + std::size_t(i)] < static_instances) << i;
    return std::uint16_t(bits & row);
}

std::uint16_t surface_pixels(const VisibilityBuffer& visibility, std::size_t first, std::uint16_t row) {
    std::uint32_t bits = 0;
    for (int i = 0; i < kTileSize; ++i)
        bits |= std::uint32_t(visibility.instance[first + std::size_t(i)] < kUnresolved) << i;
    return std::uint16_t(bits & row);
}

/// Bit i: pixel i of these rows lies in a block that is due this frame.
std::uint16_t due_pixels(int x, int y, std::uint64_t frame, int refresh_frames) {
    if (refresh_frames == 0) return 0;
    std::uint32_t bits = 0;
    for (int i = 0; i < kTileSize; i += kRefreshBlock) {
        std::uint32_t hash =
            std::uint32_t((x + i) / kRefreshBlock) * 0x9E3779B1u ^ std::uint32_t(y / kRefreshBlock) * 0x85EBCA6Bu;
        hash ^= hash >> 15;
        hash *= 0x2C1B3C6Du;
        hash ^= hash >> 13;
        if (hash % std::uint32_t(refresh_frames) == frame % std::uint64_t(refresh_frames)) bits |= 0xFu << i;
    }
    return std::uint16_t(bits);
}

}  // namespace

void SunHistory::begin_frame(const SunHistoryInput& input) {
    const VisibilityBuffer& visibility = input.visibility;
    ++frame_;
    if (input.to_sun != to_sun_) clear();
    to_sun_ = input.to_sun;
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
        sun::Tile tile;
        std::uint64_t count = 0;
        for (std::size_t t = begin; t < end; ++t) {
            TileRequest& request = undecided_[t];
            tile.x = request.x;
            tile.y = request.y;
            std::uint32_t any = 0;
            const int columns = std::clamp(visibility.width - tile.x, 0, kTileSize);
            for (int j = 0; j < kTileSize; ++j) {
                const std::size_t first = visibility.index(tile.x, tile.y + j);
                const bool inside = tile.y + j < visibility.height;
                request.rows[j] = std::uint16_t(inside ? request.rows[j] & ((1u << columns) - 1u) : 0u);
                tile.wanted[j] = static_pixels(visibility, first, request.rows[j], input.static_instances);
                request.rows[j] = surface_pixels(visibility, first, request.rows[j]);
                if (!knows) continue;
                tile.wanted[j] =
                    std::uint16_t(tile.wanted[j] & ~due_pixels(tile.x, tile.y + j, frame_, input.refresh_frames));
                any |= tile.wanted[j];
            }
            if (!knows || any == 0) continue;
            load_depths(visibility, tile.x, tile.y, tile.depths);
            if (may_be_shaded(input.view, visibility, request, moving_, input.to_sun)) continue;
            const std::size_t first = visibility.index(tile.x, tile.y);
            tile.out_words = current_.words.data() + first;
            tile.out_lit = lit + first;
            tile.out_stride = std::size_t(visibility.stride);
            sun::reuse_tile(reprojection, tile);
            for (int j = 0; j < kTileSize; ++j) {
                count += std::uint64_t(std::popcount(tile.answered[j]));
                request.rows[j] = std::uint16_t(request.rows[j] & ~tile.answered[j]);
            }
        }
        total.fetch_add(count, std::memory_order_relaxed);
    });
    left.clear();
    for (const TileRequest& request : undecided_)
        if (std::any_of(std::begin(request.rows), std::end(request.rows), [](std::uint16_t row) { return row != 0; }))
            left.push_back(request);
    return total;
}

void SunHistory::commit(const SunHistoryInput& input, std::span<const TileRequest> cast, const std::uint8_t* lit) {
    const VisibilityBuffer& visibility = input.visibility;
    parallel_ranges(cast.size(), 4 * kTilesPerTask, [&](std::size_t begin, std::size_t end) {
        for (const TileRequest& request : cast.subspan(begin, end - begin)) {
            for (int j = 0; j < kTileSize; ++j) {
                const std::size_t first = visibility.index(request.x, request.y + j);
                const std::uint32_t fixed = static_pixels(visibility, first, request.rows[j], input.static_instances);
                for (std::uint32_t bits = fixed; bits != 0; bits &= bits - 1) {
                    const std::size_t at = first + std::size_t(std::countr_zero(bits));
                    const std::uint32_t depth = std::bit_cast<std::uint32_t>(visibility.depth[at]) & sun::kDepthBits;
                    current_.words[at] = depth | (lit[at] != 0 ? sun::kLitBit : 0u);
                }
            }
        }
    });
    std::swap(last_, current_);
}

int SunHistory::age(int x, int y) const {
    if (last_.width == 0) return -1;
    const std::uint32_t word = last_.words[std::size_t(y) * std::size_t(last_.stride) + std::size_t(x)];
    return word == 0 ? -1 : int(word & sun::kAgeBits);
}

}  // namespace ff::farfield
#endif
