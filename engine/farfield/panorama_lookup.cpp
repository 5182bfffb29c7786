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

using Rows = TileClasses::Rows;

std::uint64_t count(const Rows& rows) {
    std::uint64_t bits = 0;
    for (const std::uint16_t row : rows) bits += std::uint64_t(std::popcount(row));
    return bits;
}

Rows rows_of(const TileRequest& tile) {
    Rows rows;
    std::copy_n(tile.rows, rows.size(), rows.begin());
    return rows;
}

Rows combine(const Rows& a, const Rows& b) {
    Rows rows;
    for (std::size_t j = 0; j < rows.size(); ++j) rows[j] = std::uint16_t(a[j] | b[j]);
    return rows;
}

template <class Visit>
void visit_pixels(const Rows& rows, Visit&& visit) {
    for (int j = 0; j < kTileSize; ++j)
        for (std::uint32_t bits = rows[std::size_t(j)]; bits != 0; bits &= bits - 1) visit(j, std::countr_zero(bits));
}

/// A tile's walk costs nearly the same for one pixel as for all: where nothing but a few edges asks for it, they are
/// verified instead.
void verify_few(int few, TileClasses& tile) {
    if (count(tile.worse) != 0 || count(tile.noise) > std::uint64_t(few)) return;
    tile.edge = combine(tile.edge, tile.noise);
    tile.noise.fill(0);
}

/// The pixels to cast of a tile. rank: of its first pixel among all of the threshold's class.
Rows choose_pixels(const TileClasses& tile, const Selection& selection, std::uint64_t rank) {
    Rows chosen{};
    if (selection.part == selection.whole && selection.threshold <= panorama::kClassFirstStale) {
        chosen = tile.worse;
        if (selection.threshold <= panorama::kClassNoise) chosen = combine(chosen, tile.noise);
        if (selection.threshold <= panorama::kClassEdge) chosen = combine(chosen, tile.edge);
        return chosen;
    }
    visit_pixels(combine(tile.worse, combine(tile.noise, tile.edge)), [&](int j, int i) {
        const std::uint8_t c = tile.class_at(j, i);
        if (c > selection.threshold || (c == selection.threshold && is_chosen(rank++, selection)))
            chosen[std::size_t(j)] = std::uint16_t(chosen[std::size_t(j)] | 1u << i);
    });
    return chosen;
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
    if (target.named != nullptr) target.named->reset(view.width, view.height);
    if (s.classes.size() < wanted.size()) s.classes.resize(wanted.size());
    if (s.at_threshold.size() < wanted.size()) s.at_threshold.resize(wanted.size());
    if (s.edge_tiles.capacity() < wanted.size()) s.edge_tiles.reserve(wanted.size());
    const std::size_t tasks = (wanted.size() + kTilesPerTask - 1) / kTilesPerTask;
    if (s.task_classes.size() < tasks) s.task_classes.resize(tasks), s.task_parallax.resize(tasks);

    // What the map knows, and how good it is.
    parallel_ranges(wanted.size(), kTilesPerTask, [&](std::size_t begin, std::size_t end) {
        Histogram& histogram = s.task_classes[begin / kTilesPerTask];
        histogram.fill(0);
        // The next tile's colours are on their way while one is looked up.
        panorama::TileFootprint next = panorama::footprint_of(s.map, view, wanted[begin]);
        for (std::size_t t = begin; t < end; ++t) {
            TileClasses& tile = s.classes[t];
            const panorama::TileFootprint footprint = next;
            if (t + 1 < end) {
                next = panorama::footprint_of(s.map, view, wanted[t + 1]);
                panorama::prefetch_colors(s.map, next);
            }
            panorama::lookup_tile(job, wanted[t], footprint, tile);
            if (!tile.any) continue;
            if (limits.edges == EdgeRule::verify) verify_few(s.settings.few_pixels, tile);
            histogram[panorama::kClassEdge] += count(tile.edge);
            histogram[panorama::kClassNoise] += count(tile.noise);
            visit_pixels(tile.worse, [&](int j, int i) { ++histogram[tile.class_at(j, i)]; });
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
        visit_pixels(combine(tile.worse, combine(tile.noise, tile.edge)),
                     [&](int j, int i) { before += tile.class_at(j, i) == selection.threshold; });
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
            const Rows asked = rows_of(wanted[t]);
            Rows shown = asked;
            std::uint64_t stale = 0;
            if (tile.any) {
                const Rows chosen = choose_pixels(tile, selection, s.at_threshold[t]);
                for (std::size_t j = 0; j < asked.size(); ++j) {
                    cast.rows[j] = chosen[j];
                    shown[j] = std::uint16_t(asked[j] & ~chosen[j]);
                    if (verify) edges.rows[j] = std::uint16_t((tile.edge[j] | tile.noise[j]) & ~chosen[j]);
                    const auto good = std::uint16_t(chosen[j] & ~tile.worse[j]);
                    counts[kCastEdgeCount] += std::uint64_t(std::popcount(good));
                    // What was never seen has nothing to show; the rest is shown as it was.
                    for (std::uint32_t bits = tile.worse[j] & shown[j]; bits != 0; bits &= bits - 1) {
                        const int i = std::countr_zero(bits);
                        if (tile.class_at(int(j), i) == panorama::kClassNever) {
                            shown[j] = std::uint16_t(shown[j] & ~(1u << i));
                            ++counts[kUnansweredCount];
                        } else {
                            ++stale;
                        }
                    }
                }
                counts[kCastCount] += count(chosen);
            }
            const std::uint64_t shown_count = count(shown);
            counts[panorama::kClassGood] += shown_count - stale;
            counts[kStaleCount] += stale;
            if (tile.parallax_differs)
                visit_pixels(shown,
                             [&](int j, int i) { ++reused_parallax[tile.parallax[std::size_t(j * kTileSize + i)]]; });
            else
                reused_parallax[tile.tile_parallax] += shown_count;
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
    const auto is_empty = [](const TileRequest& tile) {
        std::uint32_t any = 0;
        for (const std::uint16_t row : tile.rows) any |= row;
        return any == 0;
    };
    std::erase_if(to_cast, is_empty);
    s.edge_tiles.clear();
    for (std::size_t t = 0; verify && t < wanted.size(); ++t)
        if (!is_empty(s.edges[t])) s.edge_tiles.push_back(std::uint32_t(t));
    return stats;
}

}  // namespace ff::farfield
