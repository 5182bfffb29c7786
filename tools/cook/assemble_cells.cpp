#include "tools/cook/assemble_cells.h"

#include <oneapi/tbb/parallel_sort.h>

#include <algorithm>
#include <cmath>
#include <tuple>

#include "engine/core/check.h"

namespace ff::cook {
namespace {

// Root squares are numbered from here: 1e9 m / 64 m fits with room to spare.
constexpr std::int64_t kRootBias = 1ll << 25;
constexpr int kRootBits = 26;

std::uint64_t spread_bits(std::uint64_t v) {  // abc -> 0a0b0c
    v = (v | v << 8) & 0x00FF00FFull;
    v = (v | v << 4) & 0x0F0F0F0Full;
    v = (v | v << 2) & 0x33333333ull;
    return (v | v << 1) & 0x55555555ull;
}

std::uint64_t gather_bits(std::uint64_t v) {
    v &= 0x55555555ull;
    v = (v | v >> 1) & 0x33333333ull;
    v = (v | v >> 2) & 0x0F0F0F0Full;
    v = (v | v >> 4) & 0x00FF00FFull;
    return (v | v >> 8) & 0x0000FFFFull;
}

}  // namespace

CellGrid::CellGrid(double largest_m, double smallest_m) : largest_m_(largest_m), smallest_m_(smallest_m) {
    while (levels_ < 6 && smallest_m * static_cast<double>(1 << levels_) < largest_m) ++levels_;
    FF_CHECK(smallest_m * static_cast<double>(1 << levels_) == largest_m, "cells of {} to {} m", largest_m, smallest_m);
}

std::uint64_t CellGrid::square_of(double x, double z) const {
    // The world's origin lies in the middle of a root: what is small and stands there is one cell, not four.
    x += 0.5 * largest_m_;
    z += 0.5 * largest_m_;
    const auto root_x = static_cast<std::int64_t>(std::floor(x / largest_m_));
    const auto root_z = static_cast<std::int64_t>(std::floor(z / largest_m_));
    const std::int64_t last = (1ll << levels_) - 1;
    const auto within = [&](double v, std::int64_t root) {
        const auto square = static_cast<std::int64_t>((v - static_cast<double>(root) * largest_m_) / smallest_m_);
        return static_cast<std::uint64_t>(std::clamp<std::int64_t>(square, 0, last));
    };
    const std::uint64_t morton = spread_bits(within(z, root_z)) << 1 | spread_bits(within(x, root_x));
    const std::uint64_t row = static_cast<std::uint64_t>(root_z + kRootBias);
    const std::uint64_t column = static_cast<std::uint64_t>(root_x + kRootBias);
    return (row << kRootBits | column) << (2 * levels_) | morton;
}

std::vector<CellRange> CellGrid::divide(std::vector<CellEntry>& entries, std::uint64_t max_weight) const {
    oneapi::tbb::parallel_sort(entries.begin(), entries.end(), [](const CellEntry& a, const CellEntry& b) {
        return std::tie(a.square, a.id) < std::tie(b.square, b.id);  // ids differ: one order for any worker count
    });
    std::vector<CellRange> cells;
    for (std::size_t begin = 0; begin < entries.size();) {
        const std::uint64_t root = entries[begin].square >> (2 * levels_);
        std::size_t end = begin;
        while (end < entries.size() && entries[end].square >> (2 * levels_) == root) ++end;
        split(entries, begin, end, 0, max_weight, cells);
        begin = end;
    }
    return cells;
}

void CellGrid::split(const std::vector<CellEntry>& entries, std::size_t begin, std::size_t end, int level,
                     std::uint64_t max_weight, std::vector<CellRange>& cells) const {
    std::uint64_t weight = 0;
    for (std::size_t i = begin; i < end; ++i) weight += entries[i].weight;
    const int shift = 2 * (levels_ - level);  // squares of this one share all bits above
    if (weight <= max_weight || level == levels_) {
        const std::uint64_t square = entries[begin].square >> shift;
        const double side = largest_m_ / static_cast<double>(1 << level);
        const std::uint64_t morton = square & ((1ull << (2 * level)) - 1), root = square >> (2 * level);
        const auto root_x = static_cast<std::int64_t>(root & ((1ull << kRootBits) - 1)) - kRootBias;
        const auto root_z = static_cast<std::int64_t>(root >> kRootBits) - kRootBias;
        cells.push_back({.begin = begin,
                         .end = end,
                         .x = (static_cast<double>(root_x) - 0.5) * largest_m_ +
                              (static_cast<double>(gather_bits(morton)) + 0.5) * side,
                         .z = (static_cast<double>(root_z) - 0.5) * largest_m_ +
                              (static_cast<double>(gather_bits(morton >> 1)) + 0.5) * side});
        return;
    }
    for (std::size_t at = begin; at < end;) {
        const std::uint64_t child = entries[at].square >> (shift - 2);
        std::size_t child_end = at;
        while (child_end < end && entries[child_end].square >> (shift - 2) == child) ++child_end;
        split(entries, at, child_end, level + 1, max_weight, cells);
        at = child_end;
    }
}

}  // namespace ff::cook
