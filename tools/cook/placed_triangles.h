#pragma once
// The triangles of a world's placements as one numbered list, in world space.

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "tools/cook/world_source.h"

namespace ff::cook {

/// A placement whose triangles count, and what they are compared with.
struct PlacementSlot {
    std::uint32_t placement = 0;  ///< WorldSource::placements
    bool with_itself = true;      ///< with triangles of the same placement
    bool with_others = true;      ///< with those of other placements that say so too
    bool stays_whole = false;     ///< an instance or dynamic: its mesh keeps a space of its own
};

/// Triangles of some placements, numbered placement by placement in the given order. Borrows the world.
class PlacedTriangles {
  public:
    /// @param slots  together fewer than 2^32 triangles
    PlacedTriangles(const WorldSource& world, std::vector<PlacementSlot> slots);

    [[nodiscard]] std::size_t size() const { return slot_of_.size(); }
    [[nodiscard]] const std::vector<PlacementSlot>& slots() const { return slots_; }
    /// Where the numbers of each slot's triangles begin; [slots + 1].
    [[nodiscard]] const std::vector<std::uint32_t>& first() const { return first_; }

    /// Index into slots(); the triangle's number in its mesh; its material.
    [[nodiscard]] std::uint32_t slot(std::uint32_t id) const { return slot_of_[id]; }
    [[nodiscard]] std::uint32_t triangle(std::uint32_t id) const { return id - first_[slot_of_[id]]; }
    [[nodiscard]] std::uint16_t material(std::uint32_t id) const;
    [[nodiscard]] const Placement& placement(std::uint32_t id) const;
    [[nodiscard]] const scene::MeshSource& mesh(std::uint32_t id) const;
    /// Whether the two are to be compared.
    [[nodiscard]] bool compares(std::uint32_t a, std::uint32_t b) const {
        const PlacementSlot &x = slots_[slot_of_[a]], &y = slots_[slot_of_[b]];
        return slot_of_[a] == slot_of_[b] ? x.with_itself : x.with_others && y.with_others;
    }

    /// Corners in metres, in the mesh's order: counter-clockwise from outside unless the placement mirrors.
    [[nodiscard]] std::array<DVec3, 3> corners(std::uint32_t id) const;
    /// 1, or -1 for a placement that mirrors: what the cross product of the edges is to be multiplied by to face out.
    [[nodiscard]] double facing_sign(std::uint32_t id) const { return signs_[slot_of_[id]]; }

  private:
    const WorldSource& world_;
    std::vector<PlacementSlot> slots_;
    std::vector<std::uint32_t> first_, slot_of_;
    std::vector<double> signs_;
};

}  // namespace ff::cook
