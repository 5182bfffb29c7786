#pragma once
// Worlds with every kind of material, and pictures of them, for the tests of the shading model.

#include <vector>

#include "engine/farfield/ray_caster.h"
#include "engine/shading/shading_pass.h"
#include "tests/support/worlds.h"

namespace ff::test {

/// All tiles of an image, every pixel asked for.
[[nodiscard]] std::vector<farfield::TileRequest> all_tiles(int width, int height);

/// What every pixel of a view sees, by Embree.
[[nodiscard]] farfield::VisibilityBuffer cast_view(const scene::StaticScene& scene, const PinholeView& view);

/// A shaded image of the whole view.
[[nodiscard]] shading::Image shade_view(const scene::StaticScene& scene, const PinholeView& view,
                                        const farfield::VisibilityBuffer& visibility,
                                        const shading::ShadeSettings& settings = {},
                                        std::span<const scene::Instance> dynamic = {});

/// Random sky, sun and (for odd seeds) fog.
void randomize_environment(Random& random, scene::Environment& environment);
/// A smooth RGBA16F panorama without a seam.
void add_panorama(scene::SceneData& scene, std::uint32_t width, std::uint32_t height);

/// A texture whose neighbouring texels differ by a few of 255, so that only a wrong texel is a large difference.
std::uint32_t add_smooth_texture(scene::SceneData& scene, Random& random, std::uint32_t width, std::uint32_t height,
                                 scene::Wrap wrap_u, scene::Wrap wrap_v);

/// Blobs, boxes and loose triangles of all materials (textured, smooth, coloured by vertex, specular with and without a
/// map, emissive, unlit; all wraps; square, long and one-texel textures), some instances mirrored or squeezed.
[[nodiscard]] scene::SceneData make_material_world(std::uint32_t seed, const WorldPos& origin = WorldPos(0.0));

/// A pleasant place to look at: a textured house, a sphere, trees and hills.
[[nodiscard]] scene::SceneData make_postcard();

}  // namespace ff::test
