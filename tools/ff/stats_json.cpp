#include "tools/ff/stats_json.h"

#include <cmath>
#include <nlohmann/json.hpp>

#include "engine/effects/registry.h"

namespace ff::tool {

nlohmann::json to_json(const frame::FrameStats& stats) {
    nlohmann::json passes;
    for (std::size_t p = 0; p < frame::kPassCount; ++p) passes[std::string(frame::kPassNames[p])] = stats.pass_ms[p];
    nlohmann::json effects;
    for (const effects::Effect& effect : effects::registry())
        effects[std::string(effect.name)] = effects::kStateNames[std::size_t(stats.effects[effect.id].state)];
    return {{"frame_ms", stats.frame_ms},
            {"effects", effects},
            {"pass_ms", passes},
            {"pixels",
             {{"near", stats.pixels.near_field},
              {"sky", stats.pixels.sky},
              {"panorama", stats.pixels.panorama},
              {"cast_hit", stats.pixels.cast_hit},
              {"cast_miss", stats.pixels.cast_miss},
              {"stale", stats.pixels.stale}}},
            {"resolution", stats.resolution},
            {"rays", stats.rays},
            {"near_triangles", stats.near_triangles},
            {"shaded_pixels", stats.shaded_pixels},
            {"layers", stats.layers},
            {"sun_rays", stats.sun_rays},
            {"sun_reused", stats.sun_reused},
            {"near_m", std::isfinite(stats.near_m) ? nlohmann::json(stats.near_m) : nlohmann::json(nullptr)},
            {"panorama_parallax_px", {{"p99", stats.parallax_p99_px}, {"max", stats.parallax_max_px}}}};
}

}  // namespace ff::tool
