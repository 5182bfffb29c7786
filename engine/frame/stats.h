#pragma once
// What a frame did: work, exact and repeatable, and time. Overlay, bench and stats.json read this and nothing else.

#include <array>
#include <cstdint>
#include <string_view>

#include "engine/effects/effect.h"
#include "engine/farfield/reproject.h"
#include "engine/frame/span_log.h"

namespace ff::frame {

/// The passes in the order in which they run; the one list of their names.
enum class Pass : std::uint8_t {
    plan,
    near_field,
    opacity,
    horizon,
    panorama,
    reproject,
    verify,
    cast,
    sun,
    reflect,
    shade,
    store,
    blend,
    fall,
    upscale,
    present
};
inline constexpr std::size_t kPassCount = 16;
inline constexpr std::array<std::string_view, kPassCount> kPassNames{
    "plan", "near",    "opacity", "horizon", "panorama", "reproject", "verify",  "cast",
    "sun",  "reflect", "shade",   "store",   "blend",    "fall",      "upscale", "present"};

/// Pixels by how they came to be (P0 Figure 11); they add up to the image as it was drawn.
struct PixelCounts {
    std::uint64_t near_field = 0;  ///< covered by rasterised triangles
    std::uint64_t sky = 0;         ///< above the traced horizon
    std::uint64_t panorama = 0;    ///< a still-good texel of the panoramic cache
    std::uint64_t verified = 0;    ///< a primitive known beforehand, confirmed by one intersection
    std::uint64_t cast_hit = 0;    ///< a ray, or a beam's pixel, that met something
    std::uint64_t cast_miss = 0;   ///< one that did not
    std::uint64_t dynamic = 0;     ///< of all: a moving instance stands before it
    std::uint64_t stale = 0;       ///< of `panorama`: worse than wanted, kept because the ray budget was spent
};

struct FrameStats {
    bool refused = false;  ///< nothing was drawn: camera, settings or instances held numbers that are none
    double frame_ms = 0.0;
    double untimed_ms = 0.0;  ///< not part of frame_ms: what mode irsa spends to know its primitives
    std::array<double, kPassCount> pass_ms{};
    PixelCounts pixels;
    effects::Decisions effects;  ///< the plan's
    std::array<effects::Work, effects::kEffectCount> effect_work{};
    farfield::ReprojectCounts causes;  ///< mode reproject: all zero where nothing was reprojected
    std::uint64_t rays = 0;
    std::uint64_t nodes_visited = 0;
    std::uint64_t triangles_tested = 0;
    std::uint64_t horizon_azimuths = 0;  ///< traced anew
    std::uint64_t near_triangles = 0;    ///< sent to OpenGL
    std::uint64_t near_draws = 0;
    std::uint64_t shaded_pixels = 0;
    std::uint64_t sun_rays = 0;        ///< cast towards the sun
    std::uint64_t sun_reused = 0;      ///< pixels whose light the last frame knew
    std::uint64_t layers = 0;          ///< transparent layers shaded and blended
    std::uint64_t opacity_missed = 0;  ///< near pixels that the opacity buffer did not know of
    double near_m = 0.0;               ///< near distance of this frame
    std::uint64_t ray_budget = UINT64_MAX;
    double resolution = 1.0;       ///< pixels drawn by pixels shown, along a side; below 1 where time was short
    float parallax_p99_px = 0.0f;  ///< predicted, of reused panorama texels
    float parallax_max_px = 0.0f;
    SpanLog log;  ///< when all this was done

    /// Time that went into finding what each pixel sees, and into colouring it (P3 7.2 tells them apart).
    [[nodiscard]] double visibility_ms() const {
        return ms(Pass::near_field) + ms(Pass::opacity) + ms(Pass::horizon) + ms(Pass::panorama) + ms(Pass::reproject) +
               ms(Pass::verify) + ms(Pass::cast);
    }
    [[nodiscard]] double shading_ms() const {
        return ms(Pass::sun) + ms(Pass::reflect) + ms(Pass::shade) + ms(Pass::store) + ms(Pass::blend) +
               ms(Pass::fall) + ms(Pass::upscale) + ms(Pass::present);
    }

    [[nodiscard]] effects::Work& work(effects::EffectId id) { return effect_work[std::size_t(id)]; }
    [[nodiscard]] const effects::Work& work(effects::EffectId id) const { return effect_work[std::size_t(id)]; }
    [[nodiscard]] double& ms(Pass pass) { return pass_ms[std::size_t(pass)]; }
    [[nodiscard]] double ms(Pass pass) const { return pass_ms[std::size_t(pass)]; }
};

}  // namespace ff::frame
