#pragma once

#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "engine/math/camera.h"
#include "engine/scene/static_scene.h"
#include "engine/visibility/cull_boxes.h"

namespace ff::visibility {

/// What a view may see, front to back.
struct VisibleSet {
    std::vector<std::uint32_t> cells;      ///< by the distance of their boxes, nearest first; equal ones by id
    std::vector<std::uint32_t> instances;  ///< ids, cell by cell in that order; dynamic ones first
    std::uint64_t boxes_tested = 0;

    // Scratch, kept so that steady frames allocate nothing.
    struct Candidate {
        double distance_m;
        std::uint32_t cell;
        bool inside;
    };
    std::vector<Candidate> candidates;
    std::vector<Overlap> overlaps;
};

/// Culls a scene's cells and instances through a uniform grid over the cells.
/// Threads: cull() may run on many at once, each with a set of its own.
class Culler {
  public:
    /// @param scene  must outlive the culler
    explicit Culler(const scene::StaticScene& scene);

    /// @param max_distance_m  only cells whose box is nearer than this to the viewer; dynamic instances at any distance
    /// @param dynamic         instances that move, named from StaticScene::instances.size() on
    void cull(const PinholeView& view, std::span<const scene::Instance> dynamic, VisibleSet& out,
              double max_distance_m = std::numeric_limits<double>::infinity()) const;

  private:
    struct Square {
        std::uint32_t first = 0, count = 0;  ///< of cells_
    };
    const scene::StaticScene& scene_;
    std::vector<Square> squares_;
    BoxArray square_boxes_;             ///< relative to scene.origin
    std::vector<std::uint32_t> cells_;  ///< ids, square by square
    BoxArray cell_boxes_;               ///< in the order of cells_, relative to scene.origin
    BoxArray instance_boxes_;           ///< by id, each relative to its cell's origin
    std::size_t most_ = 0;              ///< boxes of any one test
};

}  // namespace ff::visibility
