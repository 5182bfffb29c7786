#pragma once
// All static triangles of a world in world space, in pieces that a grid can pick by their boxes.

#include <array>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "engine/math/bounds.h"
#include "tools/cook/world_source.h"

namespace ff::cook {

/// What a walker makes of a triangle.
enum class SurfaceKind : std::uint8_t {
    wall,     ///< solid, too steep or facing down: blocks
    floor,    ///< solid, faces up: can be stood upon
    foliage,  ///< masked or blended: in the way at the height of the body, else ignored
};

struct WorldTriangle {
    std::array<DVec3, 3> corners;
    SurfaceKind kind = SurfaceKind::wall;
    bool is_level = false;  ///< horizontal, or without area: gives nothing to see
};

/// Some triangles of one placement.
struct TrianglePiece {
    std::uint32_t placement = 0;  ///< WorldSource::placements
    std::uint32_t first = 0;      ///< of the mesh's triangles, or of its list of large ones
    std::uint32_t count = 0;
    DBox3 bounds;  ///< world; contains the triangles
};

/// Placements that may move are left out, as are triangles that are not finite. Of meshes that stand in the world very
/// often only the largest triangles are given, so that a forest costs no more than `kMostDrawnTriangles`: a tree keeps
/// its trunk and loses leaves.
class StaticTriangles {
  public:
    static constexpr std::uint64_t kMostDrawnTriangles = 40'000'000;

    /// Keeps a reference to the world, whose meshes and placements must stay as they are.
    explicit StaticTriangles(const WorldSource& world);

    [[nodiscard]] const std::vector<TrianglePiece>& pieces() const { return pieces_; }
    [[nodiscard]] const DBox3& bounds() const { return bounds_; }  ///< of all; empty for an empty world

    /// Calls visit(const WorldTriangle&) for the triangles of a piece in order. Threads: any number.
    template <class Visit>
    void visit(const TrianglePiece& piece, Visit&& visit_one) const {
        const std::vector<std::uint32_t>& chosen = chosen_[world_.placements[piece.placement].mesh];
        WorldTriangle triangle;
        for (std::uint32_t i = piece.first; i < piece.first + piece.count; ++i)
            if (make(piece.placement, chosen.empty() ? i : chosen[i], triangle)) visit_one(std::as_const(triangle));
    }

  private:
    bool make(std::uint32_t placement, std::uint32_t triangle, WorldTriangle& out) const;
    void choose_large_triangles();
    void cut_into_pieces();

    const WorldSource& world_;
    std::vector<std::vector<std::uint32_t>> chosen_;  ///< per mesh; empty: all
    std::vector<TrianglePiece> pieces_;
    DBox3 bounds_;
};

}  // namespace ff::cook
