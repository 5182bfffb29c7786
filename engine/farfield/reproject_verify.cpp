#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <cstring>
#include <limits>
#include <mutex>
#include <type_traits>

#include "engine/core/check.h"
#include "engine/core/jobs.h"
#include "engine/farfield/reproject_changes.h"
#include "engine/farfield/reproject_votes.h"
#include "engine/farfield/tile_regroup.h"

namespace ff::farfield {
namespace {

using reprojection::Landed;

using reprojection::AuxiliaryBand;

constexpr std::size_t kTilesTogether = 4;  // whose primitives are fetched at once

struct TileWork {
    Landed landed;
    TileMask inside, resampled;
    TileMask all_solid;      ///< pixels around which nine points of instances landed
    TileRequest candidates;  ///< pixels to intersect
};

}  // namespace

/// Of one worker at a time; only what is used of it is ever touched.
struct Reprojection::Scratch {
    struct Task {
        AuxiliaryBand band;
        PrimitiveSet primitives;
        std::array<PrimitiveId, kTilesTogether * PrimitiveSet::kCapacity> ids;
        std::array<KnownTriangle, kTilesTogether * PrimitiveSet::kCapacity> triangles;
        std::array<TileWork, kTilesTogether> tiles;
        std::array<std::size_t, kTilesTogether + 1> first{};
    };

    /// @param tasks  that may run at once
    void reserve(int tasks, const AuxiliaryLayout& layout) {
        while (all.size() < std::size_t(tasks)) all.push_back(std::make_unique<Task>());
        free.clear();
        for (const auto& task : all) {
            task->band.resize(layout);
            free.push_back(task.get());
        }
    }
    Task* take() {
        const std::lock_guard lock(mutex);
        FF_CHECK(!free.empty(), "more tasks at once than the {} reserved", all.size());
        Task* const task = free.back();
        free.pop_back();
        return task;
    }
    void give(Task* task) {
        const std::lock_guard lock(mutex);
        free.push_back(task);
    }

    std::mutex mutex;
    std::vector<std::unique_ptr<Task>> all;
    std::vector<Task*> free;
};

Reprojection::Reprojection(const scene::StaticScene& scene) : scene_(scene), scratch_(std::make_unique<Scratch>()) {}
Reprojection::~Reprojection() = default;

namespace {

/// row = function(j) for all rows of a mask.
template <class Function>
TileMask mask_of(Function&& function) {
    TileMask mask;
    for (int j = 0; j < kTileSize; ++j) mask.rows[j] = std::uint16_t(function(j));
    return mask;
}

/// As TileMask::count(), four rows at once; of the masks of a tile most are empty.
std::uint64_t count_bits(const TileMask& mask) {
    const auto words = std::bit_cast<std::array<std::uint64_t, sizeof(TileMask) / sizeof(std::uint64_t)>>(mask);
    std::uint64_t bits = 0;
    for (const std::uint64_t word : words)
        if (word != 0) bits += std::uint64_t(std::popcount(word));
    return bits;
}

bool any_of(const std::uint32_t (&rows)[kTileSize + 2]) {
    return std::any_of(std::begin(rows), std::end(rows), [](std::uint32_t row) { return row != 0; });
}

/// Asks main memory for what a tile will write: rows of tiles are too short for processors to see them coming.
void prefetch_tile(VisibilityBuffer& out, int x, int y) {
    for (int j = 0; j < kTileSize; ++j) {
        const std::size_t at = out.index(x, y + j);
        __builtin_prefetch(&out.instance[at], 1);
        __builtin_prefetch(&out.triangle[at], 1);
        __builtin_prefetch(&out.depth[at], 1);
    }
}

void begin_tile(const AuxiliaryBand& band, const PinholeView& view, const ReprojectSettings& settings,
                std::uint64_t frame_number, int tile_x, int tile_y, TileWork& work, PrimitiveSet& primitives) {
    const int x = tile_x * kTileSize, y = tile_y * kTileSize;
    TileRequest whole{std::uint16_t(x), std::uint16_t(y), {}};
    std::fill(std::begin(whole.rows), std::end(whole.rows), std::uint16_t(0xFFFF));
    work.inside = mask_of([&](int j) { return row_inside(whole, j, view.width, view.height); });
    work.resampled = resample_mask(settings, tile_x, tile_y, frame_number);
    work.candidates = {std::uint16_t(x), std::uint16_t(y), {}};
    work.landed = {};
    std::uint32_t wanted = 0;
    for (int j = 0; j < kTileSize; ++j) wanted |= std::uint32_t(work.inside.rows[j] & ~work.resampled.rows[j]);
    if (wanted == 0) return;
    read_tile(band, x, y, work.landed, primitives);
    const TileMask dense = reprojection::count_around(work.landed.filled, settings.min_count);
    std::uint32_t solid[kTileSize + 2];
    for (int j = 0; j < kTileSize + 2; ++j) solid[j] = work.landed.filled[j] & ~work.landed.sky[j];
    work.all_solid = reprojection::count_around(solid, 9);
    for (int j = 0; j < kTileSize; ++j)
        work.candidates.rows[j] = std::uint16_t(work.inside.rows[j] & dense.rows[j] & ~work.resampled.rows[j]);
}

/// A row of a tile, all sky.
struct SkyRow {
    std::uint32_t instance[kTileSize];
    std::uint32_t triangle[kTileSize]{};
    float depth[kTileSize];
    constexpr SkyRow() : instance(), depth() {
        for (std::uint32_t& value : instance) value = kSkyInstance;
        for (float& value : depth) value = std::numeric_limits<float>::infinity();
    }
};
constexpr SkyRow kSkyRow;

void write_background(const TileRequest& tile, const TileMask& background, VisibilityBuffer& out) {
    const auto write = [&](std::size_t at, auto count) {
        std::memcpy(&out.instance[at], kSkyRow.instance, sizeof(float) * count());
        std::memcpy(&out.triangle[at], kSkyRow.triangle, sizeof(float) * count());
        std::memcpy(&out.depth[at], kSkyRow.depth, sizeof(float) * count());
    };
    for (int j = 0; j < kTileSize; ++j) {
        const std::size_t first = out.index(tile.x, tile.y + j);
        if (background.rows[j] == 0xFFFFu) {
            write(first, std::integral_constant<std::size_t, kTileSize>());
            continue;
        }
        for (std::uint32_t left = background.rows[j]; left != 0; left &= left - 1)
            write(first + std::size_t(std::countr_zero(left)), std::integral_constant<std::size_t, 1>());
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
                                     std::uint64_t frame_number, VisibilityBuffer& frame,
                                     std::vector<TileRequest>& left) {
    // Bands still want old rows when others have written new ones.
    std::swap(frame, last_);
    if (frame.width != view.width || frame.height != view.height) frame.resize(view.width, view.height);
    VisibilityBuffer& out = frame;
    for (PixelMask* mask :
         {&causes_.verified, &causes_.background, &causes_.failed, &causes_.resampled, &causes_.abrupt})
        mask->reset(view.width, view.height);
    const auto tiles_x = std::size_t(causes_.failed.tiles_x), tiles_y = std::size_t(causes_.failed.tiles_y);
    scratch_->reserve(worker_count(), points_.layout);
    const beam::BeamView beam_view(view);
    CountsSum sum;

    const auto end_tile = [&](std::size_t t, const AuxiliaryBand& band, const TileWork& work,
                              std::span<const KnownTriangle> triangles, ReprojectCounts& counts) {
        const TileRequest& asked = work.candidates;
        TileRequest missed = asked;
        TileMask verified, background, abrupt;
        if (!triangles.empty()) {
            cast_known_tile(scene_, beam_view, asked, triangles, out, missed);
            TileRequest hits = asked;
            for (int j = 0; j < kTileSize; ++j) hits.rows[j] = std::uint16_t(asked.rows[j] & ~missed.rows[j]);
            verified = settings.vote == Vote::any
                           ? mask_of([&](int j) { return hits.rows[j]; })
                           : reprojection::count_votes(band, out, hits, work.all_solid, settings);
        }
        if (any_of(work.landed.sky)) {
            const TileMask sky = reprojection::count_around(work.landed.sky, std::max(1, settings.min_count));
            background = mask_of([&](int j) { return missed.rows[j] & sky.rows[j]; });
            write_background(asked, background, out);
        }
        TileMask changed;
        if (!changed_.empty()) {
            TileRequest answered = asked;
            for (int j = 0; j < kTileSize; ++j) answered.rows[j] = std::uint16_t(verified.rows[j] | background.rows[j]);
            changed = reprojection::pixels_behind(changed_, view, answered, out);
            verified = mask_of([&](int j) { return verified.rows[j] & ~changed.rows[j]; });
            background = mask_of([&](int j) { return background.rows[j] & ~changed.rows[j]; });
        }
        const auto left_over = [&](int j) { return work.inside.rows[j] & ~verified.rows[j] & ~background.rows[j]; };
        const TileMask resampled = mask_of([&](int j) { return left_over(j) & work.resampled.rows[j]; });
        if (any_of(work.landed.abrupt)) {
            const TileMask near_abrupt = reprojection::count_around(work.landed.abrupt, 1);
            abrupt = mask_of([&](int j) { return left_over(j) & ~resampled.rows[j] & near_abrupt.rows[j]; });
        }
        const TileMask failed = mask_of([&](int j) { return left_over(j) & ~resampled.rows[j] & ~abrupt.rows[j]; });
        if (settings.shift_origin) {
            const TileMask filled = reprojection::count_around(work.landed.filled, 9);
            TileRequest cast = asked;
            for (int j = 0; j < kTileSize; ++j) cast.rows[j] = std::uint16_t(left_over(j));
            // With a change pending nobody knows what is nearer.
            const TileMask shifted = mask_of(
                [&](int j) { return changed_.empty() ? cast.rows[j] & ~resampled.rows[j] & filled.rows[j] : 0; });
            reprojection::write_origins(band, cast, shifted, settings.surface_share, out);
        }
        causes_.verified.tiles[t] = verified;
        causes_.background.tiles[t] = background;
        causes_.resampled.tiles[t] = resampled;
        causes_.abrupt.tiles[t] = abrupt;
        causes_.failed.tiles[t] = failed;
        counts.verified += count_bits(verified);
        counts.background += count_bits(background);
        counts.resampled += count_bits(resampled);
        counts.abrupt += count_bits(abrupt);
        counts.failed += count_bits(failed);
    };
    const auto answer_band = [&](std::size_t tile_y, Scratch::Task& task) {
        reprojection::fill_band(last_, points_, int(tile_y), task.band);
        ReprojectCounts counts;
        for (std::size_t begin = 0; begin < tiles_x; begin += kTilesTogether) {
            const std::size_t count = std::min(kTilesTogether, tiles_x - begin);
            for (std::size_t t = 0; t < count; ++t)
                prefetch_tile(out, int(begin + t) * kTileSize, int(tile_y) * kTileSize);
            for (std::size_t t = 0; t < count; ++t) {
                task.primitives.start(std::span(task.ids).subspan(task.first[t]));
                begin_tile(task.band, view, settings, frame_number, int(begin + t), int(tile_y), task.tiles[t],
                           task.primitives);
                task.first[t + 1] = task.first[t] + task.primitives.ids().size();
            }
            fetch_triangles(scene_, std::span(task.ids).first(task.first[count]), task.triangles);
            for (std::size_t t = 0; t < count; ++t)
                end_tile(tile_y * tiles_x + begin + t, task.band, task.tiles[t],
                         std::span(task.triangles).subspan(task.first[t], task.first[t + 1] - task.first[t]), counts);
            counts.primitives += task.first[count];
        }
        sum.add(counts);
    };
    parallel_for(tiles_y, [&](std::size_t tile_y) {
        Scratch::Task* const task = scratch_->take();
        answer_band(tile_y, *task);
        scratch_->give(task);
    });

    changed_.clear();

    left.clear();
    for (std::size_t t = 0; t < tiles_x * tiles_y; ++t) {
        TileRequest request{std::uint16_t(t % tiles_x * kTileSize), std::uint16_t(t / tiles_x * kTileSize), {}};
        std::uint32_t any = 0;
        for (int j = 0; j < kTileSize; ++j)
            any |= request.rows[j] = std::uint16_t(
                causes_.failed.tiles[t].rows[j] | causes_.resampled.tiles[t].rows[j] | causes_.abrupt.tiles[t].rows[j]);
        if (any != 0) left.push_back(request);
    }
    return {sum.verified, sum.background, sum.failed, sum.resampled, sum.abrupt, sum.primitives};
}

}  // namespace ff::farfield
