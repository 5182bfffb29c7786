#pragma once
// Ideal ray shooting (P3 7.3, IRSA), a tile at a time: the pixels' primitives are known to be among a few, so nothing
// is searched. Exact for whatever the few cover; what covers a pixel but is not among them is missed.
//
//   PrimitiveSet      which primitives, each once        for some tiles, one after the other
//   fetch_triangles   their corners, from main memory    for all those tiles at once, so that waits overlap
//   cast_known_tile   what each pixel sees of them       tile by tile

#include <array>
#include <cstdint>
#include <span>

#include "engine/farfield/beam_caster.h"

namespace ff::farfield {

/// Without initial values, as is KnownTriangle: arrays of them are scratch.
struct PrimitiveId {
    std::uint32_t instance;
    std::uint32_t triangle;
    friend bool operator==(const PrimitiveId&, const PrimitiveId&) = default;
};

/// A set of primitives for one tile, in the order in which they came, in memory of the caller's.
class PrimitiveSet {
  public:
    static constexpr std::size_t kCapacity = 1024;

    /// Begins an empty set, which goes to `room`: at least kCapacity entries.
    void start(std::span<PrimitiveId> room);
    /// Sky is not entered. Beyond kCapacity nothing is.
    /// @return whether it is new to the set
    bool add(std::uint32_t instance, std::uint32_t triangle) {
        if (instance == kSkyInstance) return false;
        const PrimitiveId id{instance, triangle};
        const std::uint32_t hash = (instance * 0x9E3779B1u) ^ (triangle * 0x85EBCA77u);
        std::size_t slot = hash >> 21;
        for (; slots_[slot] != 0; slot = (slot + 1) % slots_.size())
            if (ids_[slots_[slot] - 1u] == id) return false;
        if (count_ == kCapacity) return false;
        slot_of_[count_] = std::uint16_t(slot);
        ids_[count_++] = id;
        slots_[slot] = std::uint16_t(count_);
        return true;
    }
    [[nodiscard]] std::span<const PrimitiveId> ids() const { return ids_.first(count_); }

  private:
    std::span<PrimitiveId> ids_;
    std::size_t count_ = 0;
    std::array<std::uint16_t, 2 * kCapacity> slots_{};  ///< index + 1 into ids_, 0: free
    std::array<std::uint16_t, kCapacity> slot_of_;      ///< of each id
};

/// What an intersection needs of a primitive.
struct KnownTriangle {
    PrimitiveId id;
    Vec3 corners[3];  ///< mesh space
    bool is_see_through;
};

/// Looks primitives up. Those of many tiles at once take little longer than one: the memory answers them side by side.
/// @param ids  of static instances
/// @param out  [ids.size()]
void fetch_triangles(const scene::StaticScene& scene, std::span<const PrimitiveId> ids, std::span<KnownTriangle> out);

/// Finds the nearest of `candidates` at each pixel of a request and writes it there; see-through texels are respected.
/// @param candidates  of static instances, each at most once
/// @param missed      the request's pixels that none of them covers: left as they were
void cast_known_tile(const scene::StaticScene& scene, const beam::BeamView& view, const TileRequest& request,
                     std::span<const KnownTriangle> candidates, VisibilityBuffer& out, TileRequest& missed);

}  // namespace ff::farfield
