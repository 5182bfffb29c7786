#pragma once
// What outlives a frame: the last visibility, the skyline, measured costs, and the controller's held choices. In
// nobody's static; copy-free; sized once per image size.

#include <array>
#include <memory>
#include <vector>

#include "engine/budget/cost_model.h"
#include "engine/budget/governor.h"
#include "engine/effects/daylight.h"
#include "engine/farfield/horizon.h"
#include "engine/farfield/opacity_buffer.h"
#include "engine/farfield/panorama.h"
#include "engine/farfield/pixel_mask.h"
#include "engine/farfield/ray_caster.h"
#include "engine/farfield/reproject.h"
#include "engine/farfield/visibility_buffer.h"
#include "engine/frame/moving_tiles.h"
#include "engine/frame/reflection_pass.h"
#include "engine/frame/settings.h"
#include "engine/frame/stats.h"
#include "engine/frame/sun_pass.h"
#include "engine/frame/view_lights.h"
#include "engine/math/camera.h"
#include "engine/shading/layer_pass.h"
#include "engine/shading/shading_pass.h"
#include "engine/shading/upscale.h"
#include "engine/visibility/culler.h"

namespace ff::frame {

/// Pixels of the last frame by how they came to be, for counts and debug views.
struct SourceMasks {
    farfield::PixelMask near_field, sky, panorama, cast, dynamic;
    farfield::PixelMask verified;  ///< of the panorama's: seen by the pixel's own ray, and to be shaded
};

/// What the panorama's texels were coloured by: another look makes them all wrong.
struct PanoramaLook {
    float blend_within_m = 0.0f;
    bool sun_shadows = false;
    float fog_density_per_m = 0.0f, lamps_within_m = 0.0f;
    float reflections_within_m = 0.0f;  ///< 0: mirrors show the sky alone
    float air_error = 0.0f, water_within_m = 0.0f;
    bool water_is_rough = false;
    scene::Atmosphere atmosphere;
    scene::Weather weather;

    friend bool operator==(const PanoramaLook&, const PanoramaLook&) = default;
};

/// The light on the panorama's texels. A sun that has moved a little leaves them in use while they are lit anew.
struct PanoramaLight {
    Vec3 oldest_sun{0.0f};   ///< that some texel may still be lit by
    Vec3 started_sun{0.0f};  ///< of this frame when the round began
    std::uint32_t next = 0;  ///< texel tile of the round
    bool is_round = false;   ///< one is under way
};

struct FrameHistory {
    budget::CostModel costs;
    budget::Governor governor;
    budget::Outlook outlook;  ///< drawn from the last frame's visibility
    effects::Daylight daylight;
    ViewLights lights;                          ///< scratch: of the view that is shaded
    std::unique_ptr<effects::Shelter> shelter;  ///< made when something falls
    farfield::HorizonMap horizon{{.frames_ahead = 2}};
    farfield::OpacityRaster opacity;
    visibility::VisibleSet visible;  ///< scratch: what the near field may see
    farfield::VisibilityBuffer visibility;
    std::unique_ptr<farfield::Panorama> panorama;    ///< made when a plan first asks for it
    shading::Image panorama_colors;                  ///< where its texels are shaded
    std::vector<farfield::TileMask> panorama_marks;  ///< per tile of texels that were: which show mirrors
    bool panorama_is_full = false;                   ///< it held all that the last frame saw, and the viewer stood
    PanoramaLook panorama_look;                      ///< of its texels
    PanoramaLight panorama_light;                    ///< likewise
    shading::LayerScratch layers;                    ///< scratch: transparent layers on their way into the image
    shading::Image reduced;                          ///< a frame that is drawn smaller than it is shown
    shading::Upscaler upscaler;
    std::unique_ptr<farfield::Reprojection> reprojection;  ///< made when a plan first asks for it
    std::unique_ptr<SunLight> sun;                         ///< likewise
    std::unique_ptr<ReflectionWork> reflections;           ///< likewise
    std::unique_ptr<ReflectionWork> panorama_reflections;  ///< likewise: of its texels
    SourceMasks sources;
    std::vector<farfield::TileRequest> wanted;     ///< scratch: what neither near field nor horizon answers
    std::vector<farfield::TileRequest> requests;   ///< scratch: what is to be cast
    farfield::PixelMask answered, left;            ///< scratch
    farfield::PixelMask coloured;                  ///< scratch: what needs no shading
    std::vector<farfield::TileRequest> to_shade;   ///< scratch: what no cached colour answers
    std::vector<farfield::TileRequest> to_store;   ///< scratch: what the panorama may remember
    std::vector<farfield::TileRequest> swaying;    ///< scratch: where leaves move, which no panorama answers
    MovingTiles swaying_tiles;                     ///< scratch: likewise
    double swaying_share = 0.0;                    ///< of the last frame's tiles, where a panorama was asked
    std::vector<farfield::MovingSphere> moving;    ///< scratch: balls round what moves
    farfield::MovingShadows moving_shadows;        ///< scratch: of that
    MovingTiles moving_tiles;                      ///< scratch: likewise, that a panorama is asked for
    std::vector<std::uint8_t> tiles_of_moving;     ///< scratch: by tile, whether either may show there
    farfield::PixelMask named;                     ///< scratch: pixels of which the panorama told what they see
    std::vector<farfield::MovingSphere> mirrored;  ///< scratch: those that mirrors may show
    std::vector<farfield::TileRequest> all_tiles;
    bool can_rasterise = false;  ///< there is OpenGL to draw a near field with
    bool has_frame = false;
    int rest_frames = 0;  ///< frames since the viewer last moved
    PinholeView last_view;
    Mode last_mode = Mode::hybrid;
    FrameStats last_stats;
    std::uint64_t frame_number = 0;

    /// Forgets everything but costs, which are the machine's, and what it can do; sizes all scratch for images of this
    /// size.
    void reset(int width, int height);
    /// Makes visibility and tiles those of an image of this size, at most that of the last reset.
    void fit(int width, int height);
};

}  // namespace ff::frame
