#include "engine/animation/pose_slots.h"

#include <algorithm>

namespace ff::animation {

void PoseSlotTable::assign(std::span<PoseRequest> requests) {
    std::sort(requests.begin(), requests.end(), [](const PoseRequest& a, const PoseRequest& b) {
        return a.distance_m != b.distance_m ? a.distance_m < b.distance_m : a.owner < b.owner;
    });
    ++frame_;
    for (Slot& slot : slots_) slot.is_wanted = false;
    const auto want = [&](Slot& slot) {
        slot.is_wanted = true;
        slot.last_wanted = frame_;
    };
    const auto holding = [&](const PoseKey& key, bool wanted_only) {
        return std::ranges::find_if(slots_, [&](const Slot& slot) {
            return slot.is_filled && (slot.is_wanted || !wanted_only) && slot.key == key;
        });
    };
    // Poses at hand are kept first, as far as the nearest requests go that can all be served: what is far may not keep
    // a slot from what is near.
    const std::size_t first_served = std::min(requests.size(), slots_.size());
    for (const PoseRequest& request : requests.first(first_served))
        if (const auto slot = holding(request.key, false); slot != slots_.end()) want(*slot);
    std::uint32_t last_given = 0;
    for (PoseRequest& request : requests) {
        auto slot = holding(request.key, true);
        request.must_pose = request.is_borrowed = false;
        if (slot == slots_.end()) {
            slot = std::ranges::min_element(slots_, {}, &Slot::last_wanted);
            if (slot->is_wanted) {
                request.slot = last_given;
                request.is_borrowed = true;
                continue;
            }
            *slot = {.key = request.key, .is_filled = true};
            want(*slot);
            request.must_pose = true;
        }
        request.slot = last_given = std::uint32_t(slot - slots_.begin());
    }
}

}  // namespace ff::animation
