#pragma once
// Shades each pixel once, whoever found it: from the visibility buffer to colour. The same model as
// shaders/shading.glsl, which the rasteriser uses; tests compare the two.

#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "engine/farfield/visibility_buffer.h"
#include "engine/math/camera.h"
#include "engine/scene/static_scene.h"
#include "engine/shading/lamp_light.h"
#include "engine/shading/waves.h"

namespace ff::shading {

/// An image on its way to the screen or a file: RGBA8, sRGB, r in the low byte, row 0 at the top.
struct Image {
    int width = 0, height = 0;
    int stride = 0;  ///< pixels a row, as VisibilityBuffer::stride
    ZeroPageVector<std::uint32_t> pixels;

    void resize(int new_width, int new_height);
};

struct Reflections;  // reflections.h

struct ShadeSettings {
    /// Beyond this depth a triangle has its one prelit mean colour (P1 4.6) instead of textures. Metres; +inf: never.
    float prelit_beyond_m = std::numeric_limits<float>::infinity();
    /// How much of the sun each pixel sees, as VisibilityBuffer::index: 0 none, 255 all. nullptr: all everywhere.
    const std::uint8_t* sun_seen = nullptr;
    /// Lit lamps, the nearest first. Prelit triangles know none; nor do walls between a lamp and a surface.
    std::span<const LampLight> lamps;
    const Waves* waves = nullptr;  ///< of open water; nullptr: it is still
    /// Water farther from the eye than this is as rough as waves make it, without any; from kWavesFade of it on they
    /// fade. Metres.
    float waves_within_m = std::numeric_limits<float>::infinity();
    const Reflections* reflections = nullptr;  ///< nullptr: mirrors show the sky alone
    /// How wet and how snowed over is what faces up, [0, 1]; prelit triangles stay as they are.
    float wet = 0.0f, snow_cover = 0.0f;
    /// Air is left out where it changes no channel by more than this, of 1 as pixels hold it. [0, 0.1]; 0: nowhere.
    float air_error = 0.0f;
    bool plain_srgb = false;  ///< also with an atmosphere, whose pictures are encoded by kFilm: a mirror's own image
};

/// Colours the pixels that the tiles ask for; all of them must be resolved or sky. Parallel over tiles.
/// @param dynamic  instances that the visibility buffer names by id instance_count + i; meshes of the scene.
/// @return pixels shaded.
std::uint64_t shade_tiles(const scene::StaticScene& scene, std::span<const scene::Instance> dynamic,
                          const PinholeView& view, const farfield::VisibilityBuffer& visibility,
                          std::span<const farfield::TileRequest> tiles, const ShadeSettings& settings, Image& out);

}  // namespace ff::shading
