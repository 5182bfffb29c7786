// Choosing and entering whole tiles of texels.

#include <bit>

#include "engine/core/check.h"
#include "engine/core/jobs.h"
#include "engine/farfield/panorama_state.h"

namespace ff::farfield {
namespace {

constexpr std::size_t kTilesPerTask = 64;
/// Pixels between the samples of a tile that sees more than one face, and the texels around a sample that count as
/// seen: at least as many as lie between two samples, threefold at a face's corner.
constexpr int kSampleStep = 5;
constexpr float kSampleReach = 16.0f;

/// Calls visit(texel tile) for the tiles of texels that a tile of pixels looks at; may name some twice and some that
/// it just misses.
template <class Visit>
void visit_texel_tiles(const PanoramaMap& map, const PinholeView& view, const TileRequest& tile, Visit&& visit) {
    const auto visit_box = [&](int x0, int x1, int y0, int y1) {
        for (int ty = y0 / kTileSize; ty <= y1 / kTileSize; ++ty)
            for (int tx = x0 / kTileSize; tx <= x1 / kTileSize; ++tx) visit(std::uint32_t(ty * map.tiles_side + tx));
    };
    const panorama::TileFootprint footprint = panorama::footprint_of(map, view, tile);
    if (footprint.face >= 0) {
        visit_box(footprint.x0, footprint.x1, footprint.y0, footprint.y1);
        return;
    }
    const float reach = kSampleReach * std::max(1.0f, view.pixel_angle() * float(map.size) * 0.5f);
    const int last = map.size - 1;
    for (int j = 0; j <= kTileSize; j += kSampleStep)
        for (int i = 0; i <= kTileSize; i += kSampleStep) {
            const Vec3 d = view.direction(int(tile.x) + i, int(tile.y) + j);
            // On its own face and on those whose edge is near: a tile may cut a corner of one between two samples.
            for (int face = 0; face < 6; ++face) {
                const FacePoint p = point_on_face(d, face);
                if (!(p.axis > 0)) continue;
                const float x = texel_x(map, p.a), y = texel_y(map, p.b), end = float(last) + reach;
                if (!(x > -reach && x < end && y > -reach && y < end)) continue;
                const int face_row = face * map.size;
                visit_box(std::clamp(int(x - reach), 0, last), std::clamp(int(x + reach), 0, last),
                          face_row + std::clamp(int(y - reach), 0, last),
                          face_row + std::clamp(int(y + reach), 0, last));
            }
        }
}

}  // namespace

std::span<const TileRequest> Panorama::fill_requests(int face) const {
    return state_->requests[std::size_t(face)];
}

std::uint64_t Panorama::plan_fill(const PinholeView& view, std::span<const TileRequest> wanted,
                                  const PanoramaLimits& limits) {
    State& s = *state_;
    FF_CHECK(s.record != kNeverTraced, "plan_fill before begin_frame");
    for (auto& list : s.requests) list.clear();
    const panorama::LookupJob job = s.job(view, limits);

    // Most tiles need nothing, and that is found out in parallel.
    s.needs.resize(std::max(s.needs.size(), wanted.size()));
    parallel_ranges(wanted.size(), kTilesPerTask, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            bool needs = false;
            visit_texel_tiles(s.map, view, wanted[i],
                              [&](std::uint32_t tile) { needs |= !panorama::is_tile_good(job, s.map.tiles[tile]); });
            s.needs[i] = needs;
        }
    });
    ++s.stamp;
    s.candidates.clear();
    for (std::size_t i = 0; i < wanted.size(); ++i) {
        if (s.needs[i] == 0) continue;
        visit_texel_tiles(s.map, view, wanted[i], [&](std::uint32_t tile) {
            const TexelTile& texels = s.map.tiles[tile];
            if (s.marked[tile] == s.stamp || panorama::is_tile_good(job, texels)) return;
            s.marked[tile] = s.stamp;
            const float bound = panorama::tile_parallax_bound(job, texels);
            const std::uint8_t worth = !texels.complete ? panorama::kClassNever : panorama::bin_of(bound);
            s.candidates.push_back({tile, kTileSize * kTileSize, worth});
        });
    }

    // Texels of mixed tiles are asked for one by one: some may be good.
    const auto side = std::uint32_t(s.map.tiles_side);
    const auto make_request = [&](const State::Candidate& candidate) {
        TileRequest request{
            std::uint16_t(candidate.tile % side * kTileSize), std::uint16_t(candidate.tile / side * kTileSize), {}};
        const std::uint16_t tile_record = s.map.tiles[candidate.tile].record;
        for (int j = 0; j < kTileSize; ++j) {
            const std::size_t row = s.map.index(request.x, request.y + j);
            for (std::size_t i = 0; i < kTileSize; ++i) {
                const std::uint16_t r = s.map.records[row + i];
                const TexelTile texel{
                    .record = r, .complete = r != kNeverTraced, .nearest_m = s.map.visibility.depth[row + i]};
                if (tile_record != kMixedRecords || !panorama::is_tile_good(job, texel))
                    request.rows[j] = std::uint16_t(request.rows[j] | 1u << i);
            }
        }
        return request;
    };
    // Worst first, ties by place.
    std::sort(s.candidates.begin(), s.candidates.end(), [](const State::Candidate& a, const State::Candidate& b) {
        return a.worth != b.worth ? a.worth > b.worth : a.tile < b.tile;
    });
    std::uint64_t left = limits.ray_budget, chosen = 0;
    s.is_fill_complete = left > 0 || s.candidates.empty();
    std::size_t first = 0;
    while (first < s.candidates.size() && left > 0) {
        std::size_t end = first;
        while (end < s.candidates.size() && s.candidates[end].worth == s.candidates[first].worth) ++end;
        // Where a class does not fit, every n-th of it (P0 5.2).
        const std::uint64_t texels = (end - first) * kTileSize * kTileSize;
        const std::size_t n = texels > left ? std::size_t((texels + left - 1) / left) : 1;
        for (std::size_t i = first; i < end; i += n) {
            const TileRequest request = make_request(s.candidates[i]);
            std::uint64_t count = 0;
            for (const std::uint16_t row : request.rows) count += std::uint64_t(std::popcount(row));
            if (count > left) {
                s.is_fill_complete = false;
                continue;
            }
            left -= count;
            chosen += count;
            s.requests[std::size_t(request.y) / std::size_t(s.map.size)].push_back(request);
        }
        s.is_fill_complete &= n == 1;
        first = end;
    }
    s.is_fill_complete &= first == s.candidates.size();
    return chosen;
}

bool Panorama::is_fill_complete() const {
    return state_->is_fill_complete;
}

bool Panorama::plan_refresh(std::uint64_t texels, std::uint32_t& next) {
    State& s = *state_;
    FF_CHECK(s.record != kNeverTraced, "plan_refresh before begin_frame");
    for (auto& list : s.requests) list.clear();
    const auto side = std::uint32_t(s.map.tiles_side);
    for (; next < s.map.tiles.size(); ++next) {
        if (s.map.tiles[next].record == kNeverTraced) continue;
        TileRequest request{std::uint16_t(next % side * kTileSize), std::uint16_t(next / side * kTileSize), {}};
        std::uint64_t count = 0;
        for (int j = 0; j < kTileSize; ++j) {
            const std::size_t row = s.map.index(request.x, request.y + j);
            for (std::size_t i = 0; i < kTileSize; ++i)
                if (s.map.records[row + i] != kNeverTraced) request.rows[j] = std::uint16_t(request.rows[j] | 1u << i);
            count += std::uint64_t(std::popcount(request.rows[j]));
        }
        if (count > texels) return false;
        texels -= count;
        s.requests[std::size_t(request.y) / std::size_t(s.map.size)].push_back(request);
    }
    return true;
}

void Panorama::commit_fill(int face, std::span<const std::uint32_t> colors, int stride,
                           std::span<const TileMask> marks) {
    State& s = *state_;
    const std::span<const TileRequest> requests = s.requests[std::size_t(face)];
    const auto side = std::uint32_t(s.map.tiles_side);
    FF_CHECK(requests.empty() || colors.size() >= std::size_t(stride) * std::size_t(6 * s.map.size),
             "colours of {} texels for a map of {} rows of {}", colors.size(), 6 * s.map.size, stride);
    FF_CHECK(marks.empty() || marks.size() == requests.size(), "{} marks for {} tiles", marks.size(), requests.size());
    parallel_ranges(requests.size(), 8, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            const TileRequest& request = requests[i];
            for (int j = 0; j < kTileSize; ++j) {
                const std::uint32_t marked = marks.empty() ? 0xFFFFu : marks[i].rows[j];
                const std::size_t to = s.map.index(request.x, request.y + j);
                const std::size_t from = std::size_t(request.y + j) * std::size_t(stride) + request.x;
                for (std::uint32_t bits = request.rows[j]; bits != 0; bits &= bits - 1) {
                    const auto bit = std::size_t(std::countr_zero(bits));
                    const std::uint32_t alpha = (marked >> bit & 1u) * (kTexelMarked << 24);
                    s.map.colors[to + bit] = (colors[from + bit] & 0x00FFFFFFu) | alpha;
                    s.map.records[to + bit] = s.record;
                }
            }
        }
    });
    s.changed.clear();
    for (std::size_t i = 0; i < requests.size(); ++i) {
        const std::uint32_t tile =
            requests[i].y / std::uint32_t(kTileSize) * side + requests[i].x / std::uint32_t(kTileSize);
        s.map.tiles[tile].any_marked = marks.empty() || marks[i].count() != 0;
        s.changed.push_back(tile);
    }
    s.refresh_changed();
}

}  // namespace ff::farfield
