#pragma once

#include <atomic>
#include <cstdint>

#include "engine/farfield/ray_caster.h"

namespace ff::farfield {

/// Adds up the work of parallel tasks. Sums of integers: the same for any number of workers.
struct CastCostSum {
    std::atomic<std::uint64_t> rays{0}, nodes{0}, triangles{0};

    void add(const CastCost& cost) {
        rays.fetch_add(cost.rays, std::memory_order_relaxed);
        nodes.fetch_add(cost.nodes, std::memory_order_relaxed);
        triangles.fetch_add(cost.triangles, std::memory_order_relaxed);
    }
    [[nodiscard]] CastCost total() const { return {rays, nodes, triangles}; }
};

}  // namespace ff::farfield
