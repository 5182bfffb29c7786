// Answering pixels from the map, and choosing which of the rest to cast (P0 5.2).

#include <bit>

#include "engine/core/check.h"
#include "engine/core/jobs.h"
#include "engine/farfield/panorama_state.h"

namespace ff::farfield {
namespace {

using panorama::TileClasses;

constexpr std::size_t kTilesPerTask = 20;

using Histogram = PixelHistogram;

/// Entries of a task's counts in the second pass, beside kClassGood.
constexpr std::size_t kStaleCount = 1, kCastCount = 2, kCastEdgeCount = 3, kUnansweredCount = 4;

/// Which pixels are cast: all of classes above the threshold, and `part` of `whole` of the threshold's, evenly.
struct Selection {
    int threshold = 256;
    std::uint64_t part = 0, whole = 1;
};

Selection choose(const Histogram& classes, std::uint64_t budget, EdgeRule edges) {
    const int lowest = edges == EdgeRule::cast     ? panorama::kClassEdge
                       : edges == EdgeRule::verify ? panorama::kClassNoise
                                                   : panorama::kClassFirstStale;
    Selection selection;
    for (int c = 255; c >= lowest; --c) {
        const std::uint64_t count = classes[std::size_t(c)];
        selection.threshold = c;
        if (count > budget) {
            selection.part = budget;
            selection.whole = count;
            return selection;
        }
        selection.part = selection.whole = std::max<std::uint64_t>(count, 1);
        budget -= count;
    }
    return selection;
}

/// Every n-th among equals: of `whole` in a row, the i-th is chosen so that `part` are, evenly spread.
bool is_chosen(std::uint64_t i, const Selection& s) {
    return (i + 1) * s.part / s.whole > i * s.part / s.whole;
}

template <class Visit>
void visit_pixels(const TileRequest& tile, Visit&& visit) {
    for (int j = 0; j < kTileSize; ++j)
        for (std::uint32_t bits = tile.rows[j]; bits != 0; bits &= bits - 1) visit(j, std::countr_zero(bits));
}

/// A tile's walk costs nearly the same for one pixel as for all: where nothing but a few edges asks for it, they are
/// verified instead.
void verify_few(const TileRequest& wanted, int few, TileClasses& tile) {
    int noise = 0;
    bool must_cast = false;
    visit_pixels(wanted, [&](int j, int i) {
        const std::uint8_t c = tile.classes[std::size_t(j * kTileSize + i)];
        noise += c == panorama::kClassNoise;
        must_cast |= c >= panorama::kClassFirstStale;
    });
    if (must_cast || noise > few) return;
    for (std::uint8_t& c : tile.classes)
        if (c == panorama::kClassNoise) c = panorama::kClassEdge;
}

std::uint64_t count_wanted(const TileRequest& tile) {
    std::uint64_t count = 0;
    for (const std::uint16_t row : tile.rows) count += std::uint64_t(std::popcount(row));
    return count;
}

}  // namespace

PanoramaStats Panorama::lookup(const PinholeView& view, std::span<const TileRequest> wanted,
                               const PanoramaLimits& limits, const PanoramaTarget& target,
                               std::vector<TileRequest>& to_cast) {
    State& s = *state_;
    FF_CHECK(s.record != kNeverTraced, "lookup before begin_frame");
    FF_CHECK(target.colors != nullptr, "a lookup without a place for its colours");
    panorama::LookupJob job = s.job(view, limits);
    job.target = target;
    if (s.classes.size() < wanted.size()) s.classes.resize(wanted.size());
    if (s.at_threshold.size() < wanted.size()) s.at_threshold.resize(wanted.size());
    const std::size_t tasks = (wanted.size() + kTilesPerTask - 1) / kTilesPerTask;
    if (s.task_classes.size() < tasks) s.task_classes.resize(tasks), s.task_parallax.resize(tasks);

    // What the map knows, and how good it is.
    parallel_ranges(wanted.size(), kTilesPerTask, [&](std::size_t begin, std::size_t end) {
        Histogram& histogram = s.task_classes[begin / kTilesPerTask];
        histogram.fill(0);
        for (std::size_t t = begin; t < end; ++t) {
            TileClasses& tile = s.classes[t];
            panorama::lookup_tile(job, wanted[t], tile);
            if (!tile.any) continue;
            if (limits.edges == EdgeRule::verify) verify_few(wanted[t], s.settings.few_pixels, tile);
            visit_pixels(wanted[t], [&](int j, int i) { ++histogram[tile.classes[std::size_t(j * kTileSize + i)]]; });
        }
    });
    Histogram histogram{};
    for (std::size_t task = 0; task < tasks; ++task)
        for (std::size_t c = 0; c < 256; ++c) histogram[c] += s.task_classes[task][c];

    // Lowest confidence first, until the budget is spent.
    const Selection selection = choose(histogram, limits.ray_budget, limits.edges);
    std::uint64_t before = 0;
    for (std::size_t t = 0; t < wanted.size(); ++t) {
        const TileClasses& tile = s.classes[t];
        s.at_threshold[t] = std::uint32_t(before);
        if (!tile.any || selection.part == selection.whole) continue;
        visit_pixels(wanted[t], [&](int j, int i) {
            before += tile.classes[std::size_t(j * kTileSize + i)] == selection.threshold;
        });
    }
    const bool verify = limits.edges == EdgeRule::verify;
    for (std::vector<TileRequest>* list : {&to_cast, &s.edges}) {
        if (list->capacity() < wanted.size()) list->reserve(wanted.size());
        list->resize(wanted.size());
    }
    parallel_ranges(wanted.size(), kTilesPerTask, [&](std::size_t begin, std::size_t end) {
        Histogram& reused_parallax = s.task_parallax[begin / kTilesPerTask];
        Histogram& counts = s.task_classes[begin / kTilesPerTask];
        reused_parallax.fill(0);
        counts.fill(0);
        for (std::size_t t = begin; t < end; ++t) {
            const TileClasses& tile = s.classes[t];
            TileRequest &cast = to_cast[t], &edges = s.edges[t];
            cast = edges = {wanted[t].x, wanted[t].y, {}};
            if (!tile.any && !tile.checked) {
                const std::uint64_t count = count_wanted(wanted[t]);
                counts[panorama::kClassGood] += count;
                reused_parallax[tile.tile_parallax] += count;
                continue;
            }
            std::uint64_t rank = s.at_threshold[t];
            visit_pixels(wanted[t], [&](int j, int i) {
                const std::size_t at = std::size_t(j * kTileSize + i);
                const std::uint8_t c = tile.classes[at];
                const bool chosen =
                    c > selection.threshold || (c == selection.threshold && is_chosen(rank++, selection));
                if (chosen) {
                    cast.rows[j] = std::uint16_t(cast.rows[j] | 1u << i);
                    ++counts[kCastCount];
                    counts[kCastEdgeCount] += c < panorama::kClassFirstStale;
                    return;
                }
                if (c == panorama::kClassNever) {
                    ++counts[kUnansweredCount];
                    return;
                }
                if (verify && (c == panorama::kClassEdge || c == panorama::kClassNoise))
                    edges.rows[j] = std::uint16_t(edges.rows[j] | 1u << i);
                ++counts[c < panorama::kClassFirstStale ? panorama::kClassGood : kStaleCount];
                ++reused_parallax[tile.checked ? tile.parallax[at] : tile.tile_parallax];
            });
        }
    });

    PanoramaStats stats;
    Histogram parallax{};
    for (std::size_t task = 0; task < tasks; ++task) {
        stats.reused += s.task_classes[task][panorama::kClassGood];
        stats.stale += s.task_classes[task][kStaleCount];
        stats.cast += s.task_classes[task][kCastCount];
        stats.edges += s.task_classes[task][kCastEdgeCount];
        stats.unanswered += s.task_classes[task][kUnansweredCount];
        for (std::size_t b = 0; b < 256; ++b) parallax[b] += s.task_parallax[task][b];
    }
    stats.wanted = stats.reused + stats.stale + stats.cast + stats.unanswered;
    const std::uint64_t shown = stats.reused + stats.stale;
    std::uint64_t seen = 0;
    for (std::size_t b = 0; b < 256; ++b) {
        if (parallax[b] == 0) continue;
        if (seen * 100 < shown * 99) stats.parallax_p99_px = panorama::bin_upper_end(std::uint8_t(b));
        seen += parallax[b];
        stats.parallax_max_px = panorama::bin_upper_end(std::uint8_t(b));
    }
    for (std::vector<TileRequest>* list : {&to_cast, &s.edges})
        std::erase_if(*list, [](const TileRequest& tile) {
            std::uint32_t any = 0;
            for (const std::uint16_t row : tile.rows) any |= row;
            return any == 0;
        });
    return stats;
}

}  // namespace ff::farfield
