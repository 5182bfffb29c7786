#pragma once
// Shadow rays the plain way, one by one in double: what SunRays is tested against.

#include <cstdint>
#include <span>

#include "engine/farfield/ray_caster.h"
#include "engine/farfield/visibility_buffer.h"
#include "engine/math/camera.h"
#include "engine/scene/static_scene.h"

namespace ff::farfield {

/// A ray that starts above its own surface.
struct ShadowRay {
    WorldPos origin{0.0};
    DVec3 direction{0.0};
    std::uint32_t own_instance = kSkyInstance, own_triangle = 0;  ///< passed by
    float footprint_m = 0.0f;                                     ///< for the alpha test
};

/// Whether something opaque stands in the way.
/// @param first_id  name of the scene's first instance: 0, or the static scene's count for moving ones
[[nodiscard]] bool is_occluded_reference(const scene::StaticScene& scene, std::uint32_t first_id, const ShadowRay& ray);

/// What a pixel asks.
struct SunQuestion {
    enum class Kind : std::uint8_t { sky, turned_away, ray } kind = Kind::sky;
    ShadowRay ray;
};

/// The question of pixel (x, y).
[[nodiscard]] SunQuestion sun_question_reference(const scene::StaticScene& scene, const PinholeView& view,
                                                 const VisibilityBuffer& visibility,
                                                 std::span<const scene::Instance> dynamic, const Vec3& to_sun, int x,
                                                 int y);

}  // namespace ff::farfield
