#include <algorithm>
#include <array>
#include <atomic>

#include "engine/core/jobs.h"
#include "engine/farfield/reproject_votes.h"
#include "engine/farfield/tile_regroup.h"

namespace ff::farfield {
namespace {

using reprojection::Landed;

constexpr std::size_t kTilesPerTask = 8;
constexpr std::size_t kTilesTogether = 4;  // whose primitives are fetched at once

struct TileWork {
    Landed landed;
    TileMask inside, resampled;
    TileMask all_filled;     ///< pixels around which nine points landed
    TileRequest candidates;  ///< pixels to intersect
};

/// Scratch of a task; only what is used of it is ever touched.
struct Task {
    PrimitiveSet primitives;
    std::array<PrimitiveId, kTilesTogether * PrimitiveSet::kCapacity> ids;
    std::array<KnownTriangle, kTilesTogether * PrimitiveSet::kCapacity> triangles;
    std::array<TileWork, kTilesTogether> tiles;
    std::array<std::size_t, kTilesTogether + 1> first{};
};

/// row = function(j) for all rows of a mask.
template <class Function>
TileMask mask_of(Function&& function) {
    TileMask mask;
    for (int j = 0; j < kTileSize; ++j) mask.rows[j] = std::uint16_t(function(j));
    return mask;
}

bool any_of(const std::uint32_t (&rows)[kTileSize + 2]) {
    return std::any_of(std::begin(rows), std::end(rows), [](std::uint32_t row) { return row != 0; });
}

/// Asks main memory for what a tile will read and write: rows of tiles are too short for processors to see them coming.
void prefetch_tile(const AuxiliaryImage& auxiliary, int x, int y, VisibilityBuffer& out) {
    for (int j = -1; j <= kTileSize; ++j) {
        const std::size_t at = auxiliary.index(x, y + j);
        __builtin_prefetch(&auxiliary.instance[at]);
        __builtin_prefetch(&auxiliary.triangle[at]);
        __builtin_prefetch(&auxiliary.depth[at]);
    }
    for (int j = 0; j < kTileSize; ++j) {
        const std::size_t at = out.index(x, y + j);
        __builtin_prefetch(&out.instance[at], 1);
        __builtin_prefetch(&out.triangle[at], 1);
        __builtin_prefetch(&out.depth[at], 1);
    }
}

void begin_tile(const AuxiliaryImage& auxiliary, const PinholeView& view, const ReprojectSettings& settings,
                std::uint64_t frame_number, int tile_x, int tile_y, TileWork& work, PrimitiveSet& primitives) {
    const int x = tile_x * kTileSize, y = tile_y * kTileSize;
    read_tile(auxiliary, x, y, work.landed, primitives);
    TileRequest whole{std::uint16_t(x), std::uint16_t(y), {}};
    std::fill(std::begin(whole.rows), std::end(whole.rows), std::uint16_t(0xFFFF));
    work.inside = mask_of([&](int j) { return row_inside(whole, j, view.width, view.height); });
    work.resampled = resample_mask(settings, tile_x, tile_y, frame_number);
    const TileMask dense = reprojection::count_around(work.landed.filled, settings.min_count);
    work.all_filled = reprojection::count_around(work.landed.filled, 9);
    work.candidates = {std::uint16_t(x), std::uint16_t(y), {}};
    for (int j = 0; j < kTileSize; ++j)
        work.candidates.rows[j] = std::uint16_t(work.inside.rows[j] & dense.rows[j] & ~work.resampled.rows[j]);
}

void write_background(const TileRequest& tile, const TileMask& background, VisibilityBuffer& out) {
    const auto write = [&](std::size_t at) {
        out.instance[at] = kSkyInstance;
        out.triangle[at] = 0u;
        out.depth[at] = std::numeric_limits<float>::infinity();
    };
    for (int j = 0; j < kTileSize; ++j) {
        const std::size_t first = out.index(tile.x, tile.y + j);
        if (background.rows[j] == 0xFFFFu) {  // most rows: a few whole registers
            for (std::size_t i = 0; i < kTileSize; ++i) write(first + i);
            continue;
        }
        for (std::uint32_t left = background.rows[j]; left != 0; left &= left - 1)
            write(first + std::size_t(std::countr_zero(left)));
    }
}

/// Adds up the counts of parallel tasks. Sums of integers: the same for any number of workers.
struct CountsSum {
    std::atomic<std::uint64_t> verified{0}, background{0}, failed{0}, resampled{0}, abrupt{0}, primitives{0};

    void add(const ReprojectCounts& counts) {
        verified += counts.verified;
        background += counts.background;
        failed += counts.failed;
        resampled += counts.resampled;
        abrupt += counts.abrupt;
        primitives += counts.primitives;
    }
};

}  // namespace

ReprojectCounts Reprojection::verify(const PinholeView& view, const ReprojectSettings& settings,
                                     std::uint64_t frame_number, VisibilityBuffer& out,
                                     std::vector<TileRequest>& left) {
    for (PixelMask* mask :
         {&causes_.verified, &causes_.background, &causes_.failed, &causes_.resampled, &causes_.abrupt})
        mask->reset(view.width, view.height);
    const int tiles_x = causes_.failed.tiles_x;
    const std::size_t tile_count = causes_.failed.tiles.size();
    const beam::BeamView beam_view(view);
    CountsSum sum;

    const auto end_tile = [&](std::size_t t, const TileWork& work, std::span<const KnownTriangle> triangles,
                              ReprojectCounts& counts) {
        const TileRequest& asked = work.candidates;
        TileRequest missed = asked;
        TileMask verified, background, abrupt;
        if (!triangles.empty()) {
            cast_known_tile(scene_, beam_view, asked, triangles, out, missed);
            TileRequest hits = asked;
            for (int j = 0; j < kTileSize; ++j) hits.rows[j] = std::uint16_t(asked.rows[j] & ~missed.rows[j]);
            verified = settings.vote == Vote::any
                           ? mask_of([&](int j) { return hits.rows[j]; })
                           : reprojection::count_votes(auxiliary_, out, hits, work.all_filled, settings);
        }
        if (any_of(work.landed.sky)) {
            const TileMask sky = reprojection::count_around(work.landed.sky, std::max(1, settings.min_count));
            background = mask_of([&](int j) { return missed.rows[j] & sky.rows[j]; });
            write_background(asked, background, out);
        }
        const auto left_over = [&](int j) { return work.inside.rows[j] & ~verified.rows[j] & ~background.rows[j]; };
        const TileMask resampled = mask_of([&](int j) { return left_over(j) & work.resampled.rows[j]; });
        if (any_of(work.landed.abrupt)) {
            const TileMask near_abrupt = reprojection::count_around(work.landed.abrupt, 1);
            abrupt = mask_of([&](int j) { return left_over(j) & ~resampled.rows[j] & near_abrupt.rows[j]; });
        }
        const TileMask failed = mask_of([&](int j) { return left_over(j) & ~resampled.rows[j] & ~abrupt.rows[j]; });
        causes_.verified.tiles[t] = verified;
        causes_.background.tiles[t] = background;
        causes_.resampled.tiles[t] = resampled;
        causes_.abrupt.tiles[t] = abrupt;
        causes_.failed.tiles[t] = failed;
        counts.verified += std::uint64_t(verified.count());
        counts.background += std::uint64_t(background.count());
        counts.resampled += std::uint64_t(resampled.count());
        counts.abrupt += std::uint64_t(abrupt.count());
        counts.failed += std::uint64_t(failed.count());
    };
    parallel_ranges(tile_count, kTilesPerTask, [&](std::size_t begin, std::size_t end) {
        Task task;
        ReprojectCounts counts;
        for (std::size_t first = begin; first < end; first += kTilesTogether) {
            const std::size_t count = std::min(kTilesTogether, end - first);
            const auto column_of = [&](std::size_t t) { return int((first + t) % std::size_t(tiles_x)); };
            const auto row_of = [&](std::size_t t) { return int((first + t) / std::size_t(tiles_x)); };
            for (std::size_t t = 0; t < count; ++t)
                prefetch_tile(auxiliary_, column_of(t) * kTileSize, row_of(t) * kTileSize, out);
            for (std::size_t t = 0; t < count; ++t) {
                task.primitives.start(std::span(task.ids).subspan(task.first[t]));
                begin_tile(auxiliary_, view, settings, frame_number, column_of(t), row_of(t), task.tiles[t],
                           task.primitives);
                task.first[t + 1] = task.first[t] + task.primitives.ids().size();
            }
            fetch_triangles(scene_, std::span(task.ids).first(task.first[count]), task.triangles);
            for (std::size_t t = 0; t < count; ++t)
                end_tile(first + t, task.tiles[t],
                         std::span(task.triangles).subspan(task.first[t], task.first[t + 1] - task.first[t]), counts);
            counts.primitives += task.first[count];
        }
        sum.add(counts);
    });

    left.clear();
    for (std::size_t t = 0; t < tile_count; ++t) {
        TileRequest request{std::uint16_t(t % std::size_t(tiles_x) * kTileSize),
                            std::uint16_t(t / std::size_t(tiles_x) * kTileSize),
                            {}};
        std::uint32_t any = 0;
        for (int j = 0; j < kTileSize; ++j)
            any |= request.rows[j] = std::uint16_t(
                causes_.failed.tiles[t].rows[j] | causes_.resampled.tiles[t].rows[j] | causes_.abrupt.tiles[t].rows[j]);
        if (any != 0) left.push_back(request);
    }
    return {sum.verified, sum.background, sum.failed, sum.resampled, sum.abrupt, sum.primitives};
}

}  // namespace ff::farfield
