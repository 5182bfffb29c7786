#pragma once
// Transparent layers over a shaded image: found (farfield/layer_finder.h), sorted per pixel, shaded by the model that
// all surfaces share, and blended from back to front.

#include <cstdint>
#include <span>

#include "engine/farfield/layer_finder.h"
#include "engine/farfield/sun_rays.h"
#include "engine/shading/shading_pass.h"

namespace ff::shading {

/// Where layers are shaded before they are blended; kept from frame to frame. Its memory is taken where it is touched.
struct LayerScratch {
    farfield::VisibilityBuffer visibility;
    Image image;
    ZeroPageVector<std::uint8_t> sun_seen;  ///< as ShadeSettings::sun_seen

    /// Lays it out for a view. Allocates only where it grows.
    void fit(const farfield::VisibilityBuffer& view);
};

/// What blend_layers() did; exact and repeatable.
struct LayerCounts {
    std::uint64_t shaded = 0;
    std::uint64_t sun_rays = 0;
};

/// Blends the layers of the tiles' pixels over `out`. Straight alpha: base colour factor x vertex colour x texture,
/// filtered as colours are. Blended as encoded, 8 bits a channel, as OpenGL does in the rasteriser's mode. What lies
/// behind layers that together let less than 1/512 through is left out. Parallel over tiles.
/// @param view     blend_within_m says how far layers reach
/// @param visible  what each pixel sees behind its layers; depths suffice
/// @param sun      casts the layers' sun shadows, after begin_tiles(); null: they all see the sun
LayerCounts blend_layers(const farfield::LayerScene& scene, const PinholeView& view,
                         const farfield::VisibilityBuffer& visible, std::span<const farfield::TileRequest> tiles,
                         const ShadeSettings& settings, const farfield::SunRays* sun, LayerScratch& scratch,
                         Image& out);

}  // namespace ff::shading
