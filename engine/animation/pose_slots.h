#pragma once
// Which copy of a skinned mesh takes which pose.

#include <cstdint>
#include <span>
#include <vector>

#include "engine/animation/animator.h"

namespace ff::animation {

/// Says everything that a pose depends on.
struct PoseKey {
    Animator animator;  ///< with what does not matter left out

    friend bool operator==(const PoseKey&, const PoseKey&) = default;
};

struct PoseRequest {
    PoseKey key;
    double distance_m = 0.0;
    std::uint32_t owner = 0;  ///< of the request, for the caller; breaks ties

    std::uint32_t slot = 0;    ///< out
    bool must_pose = false;    ///< out: the slot's contents are of another pose; set for one request a slot
    bool is_borrowed = false;  ///< out: the slot has another pose than asked for
};

/// The copies of one mesh. Equal poses share one, and one that is asked for again need not be computed.
class PoseSlotTable {
  public:
    explicit PoseSlotTable(std::uint32_t slot_count) : slots_(slot_count) {}

    /// Gives each request a slot, near ones first; those for which there is none get the last that was given, which is
    /// the pose of someone nearer. A new pose replaces the one that nobody has wanted for the longest time. Reorders
    /// the requests. Allocates nothing.
    void assign(std::span<PoseRequest> requests);

  private:
    struct Slot {
        PoseKey key;
        bool is_filled = false;
        bool is_wanted = false;         // by a request of this frame
        std::uint64_t last_wanted = 0;  // frame
    };
    std::vector<Slot> slots_;
    std::uint64_t frame_ = 0;
};

}  // namespace ff::animation
