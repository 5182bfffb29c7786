#pragma once
// Ideal ray shooting (P3 7.3, IRSA), a tile at a time: the pixels' primitives are known to be among a few, so nothing
// is searched. Exact for whatever the few cover; what covers a pixel but is not among them is missed.

#include <array>
#include <cstdint>
#include <span>

#include "engine/farfield/beam_caster.h"

namespace ff::farfield {

struct PrimitiveId {
    std::uint32_t instance = kSkyInstance;
    std::uint32_t triangle = 0;
    friend bool operator==(const PrimitiveId&, const PrimitiveId&) = default;
};

/// A set of primitives for one tile, in the order in which they came.
class PrimitiveSet {
  public:
    static constexpr std::size_t kCapacity = 1024;

    void clear();
    /// Sky is not entered. Beyond kCapacity nothing is.
    void add(std::uint32_t instance, std::uint32_t triangle);
    [[nodiscard]] std::span<const PrimitiveId> ids() const { return {ids_.data(), count_}; }

  private:
    std::array<PrimitiveId, kCapacity> ids_;
    std::array<std::uint16_t, 2 * kCapacity> slots_{};  ///< index + 1 into ids_, 0: free
    std::size_t count_ = 0;
};

/// Finds the nearest of `candidates` at each pixel of a request and writes it there; see-through texels are respected.
/// @param candidates  of static instances, each at most once
/// @param missed      the request's pixels that none of them covers: left as they were
void cast_known_tile(const scene::StaticScene& scene, const beam::BeamView& view, const TileRequest& request,
                     std::span<const PrimitiveId> candidates, VisibilityBuffer& out, TileRequest& missed);

}  // namespace ff::farfield
