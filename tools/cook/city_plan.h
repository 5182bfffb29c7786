#pragma once
// Where a city's streets and blocks are: a grid without end whose lines and crossings are moved a little, so that any
// part of it can be known from the seed alone.

#include <array>
#include <compare>
#include <cstdint>
#include <vector>

#include "tools/cook/city.h"

namespace ff::cook::city {

using Quad =
    std::array<DVec2, 4>;  ///< plan, counter-clockwise; of a block: south-west, south-east, north-east, north-west

enum class BlockKind : std::uint8_t { downtown, perimeter, houses, park, square };

/// Column (eastwards) and row (northwards); block (0, 0) is in the middle.
struct BlockIndex {
    int column = 0, row = 0;
    auto operator<=>(const BlockIndex&) const = default;
};

struct CityBlock {
    BlockIndex index;
    BlockKind kind = BlockKind::houses;
    Quad kerb{};            ///< the block's outline along its streets' kerbs
    double centrality = 0;  ///< 0 in the middle of a downtown, 1 at its edge, more outside
    std::uint64_t seed = 0;
};

class CityPlan {
  public:
    explicit CityPlan(const CitySettings& settings) : settings_(settings) {}

    [[nodiscard]] CityBlock block(BlockIndex index) const;
    [[nodiscard]] Quad kerb(BlockIndex index) const;
    /// The block with the streets around it.
    [[nodiscard]] Quad with_streets(BlockIndex index) const;
    /// Width of the street west of a column, or south of a row. [12, 26]
    [[nodiscard]] double street_width(int line, bool west) const;

    /// Distance from the middle by which the city grows, metres: it rounds the corners and frays the edge.
    [[nodiscard]] double reach(BlockIndex index) const;
    /// Whether `a` is built before `b`. A street belongs to the earlier of the blocks beside it, so that a larger
    /// city leaves the streets of a smaller one as they are.
    [[nodiscard]] bool is_before(BlockIndex a, BlockIndex b) const;
    /// All blocks with reach up to `limit_m`, earliest first.
    [[nodiscard]] std::vector<BlockIndex> blocks_within(double limit_m) const;

    [[nodiscard]] double pitch() const;  ///< mean distance of streets
    [[nodiscard]] const CitySettings& settings() const { return settings_; }

  private:
    [[nodiscard]] DVec2 crossing(int column, int row) const;
    [[nodiscard]] double line_position(int line, bool west) const;
    [[nodiscard]] DVec2 middle(BlockIndex index) const;

    CitySettings settings_;
};

/// A point of a quad: u from corner 0 to 1, v from corner 0 to 3.
[[nodiscard]] DVec2 point_in(const Quad& quad, double u, double v);
[[nodiscard]] Quad part_of(const Quad& quad, double u0, double u1, double v0, double v1);
/// Sides moved inwards, side i from corner i to i + 1, each by its own distance.
[[nodiscard]] Quad inset_quad(const Quad& quad, const std::array<double, 4>& distances);
[[nodiscard]] inline Quad inset_quad(const Quad& quad, double d) {
    return inset_quad(quad, {d, d, d, d});
}

}  // namespace ff::cook::city
