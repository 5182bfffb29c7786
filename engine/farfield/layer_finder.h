#pragma once
// Transparent layers: the blended surfaces between the eye and what a pixel sees, nearer than
// PinholeView::blend_within_m. Found as beams find the opaque ones (beam_caster.h), a tile at a time through the same
// hierarchies, of which only the parts with blended triangles are entered; what the pixels see bounds the search, as
// does every layer that turns out to be opaque.

#include <cstdint>
#include <span>

#include "engine/farfield/beam_caster.h"
#include "engine/farfield/layer_index.h"

namespace ff::farfield {

/// One blended triangle before one pixel. Without initial values: arrays of them are scratch.
struct Layer {
    std::uint32_t instance, triangle;  ///< as in the VisibilityBuffer
    float depth;                       ///< as there
    float alpha;                       ///< coverage, [kAlphaStep, 1]; 1 where it is within kAlphaStep
    std::uint32_t pixel;               ///< row * kTileSize + column in the tile
};

/// What is searched.
struct LayerScene {
    const scene::StaticScene& scene;
    const LayerIndex& index;
    /// The scene with its moving instances, and a hierarchy over them, in place of the others; null: nothing moves.
    /// They are numbered from the scene's instance count on.
    const scene::StaticScene* dynamic = nullptr;
};

/// Room for the layers of one tile.
inline constexpr std::size_t kMaxTileLayers = 4096;

/// Finds the layers of the pixels of one request, in no particular order; a pixel on an edge between two triangles of a
/// mesh has a layer of one of them. Layers behind an opaque one may be missing.
/// @param visible  the view's; depths of what the pixels see
/// @param out      room for them
/// @return how many there are. More than out.size(): some of them, out.size(), were entered
[[nodiscard]] std::size_t find_layers(const LayerScene& scene, const beam::BeamView& view, const TileRequest& request,
                                      const VisibilityBuffer& visible, std::span<Layer> out);

}  // namespace ff::farfield
