#pragma once
// The ground divided into cells: a quadtree of squares over x and z, split where much stands.

#include <cstdint>
#include <vector>

#include "engine/math/types.h"

namespace ff::cook {

/// Something that belongs to one cell: a triangle or an instance.
struct CellEntry {
    std::uint64_t square = 0;  ///< see CellGrid::square_of
    std::uint32_t id = 0;      ///< the caller's; entries of a cell are in the order of square, then id
    std::uint32_t weight = 1;  ///< triangles that it draws
};

/// A cell's entries: [begin, end) of the sorted array.
struct CellRange {
    std::size_t begin = 0, end = 0;
    double x = 0, z = 0;  ///< the square's middle, metres
};

/// Squares of smallest_m, numbered so that those of any quadtree square are consecutive: rows of root squares, within
/// each the Morton order.
class CellGrid {
  public:
    /// Both are metres; largest_m / smallest_m is a power of two of at most 4096.
    CellGrid(double largest_m, double smallest_m);

    /// @param x, z  within 1e9 m of the origin
    [[nodiscard]] std::uint64_t square_of(double x, double z) const;

    /// Sorts the entries and cuts them into cells: quadtree squares that weigh at most max_weight or are of the
    /// smallest size. Deterministic.
    [[nodiscard]] std::vector<CellRange> divide(std::vector<CellEntry>& entries, std::uint64_t max_weight) const;

  private:
    void split(const std::vector<CellEntry>& entries, std::size_t begin, std::size_t end, int level,
               std::uint64_t max_weight, std::vector<CellRange>& cells) const;

    double largest_m_, smallest_m_;
    int levels_ = 0;  ///< below the root
};

}  // namespace ff::cook
