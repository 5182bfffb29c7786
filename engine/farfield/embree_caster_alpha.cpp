#include "engine/farfield/embree_caster_alpha.h"

#include <glm/geometric.hpp>

#include "engine/farfield/alpha_test.h"

namespace ff::farfield::embree {

void filter_see_through(const RTCFilterFunctionNArguments* arguments) {
    const auto& scene = *static_cast<const scene::StaticScene*>(arguments->geometryUserPtr);
    const CastContext& cast = *reinterpret_cast<const CastContext*>(arguments->context);
    const unsigned count = arguments->N;
    // The lanes of a packet mostly hit the same triangle: it is looked up once.
    std::uint32_t last_instance = RTC_INVALID_GEOMETRY_ID, last_triangle = 0;
    AlphaSurface surface;
    for (unsigned lane = 0; lane < count; ++lane) {
        if (arguments->valid[lane] == 0) continue;
        const std::uint32_t placed = RTCHitN_instID(arguments->hit, count, lane, 0);
        const std::uint32_t instance =
            placed == RTC_INVALID_GEOMETRY_ID ? RTCHitN_geomID(arguments->hit, count, lane) : placed;
        const std::uint32_t triangle = RTCHitN_primID(arguments->hit, count, lane);
        if (instance != last_instance || triangle != last_triangle) {
            surface = make_alpha_surface(scene, scene.instances[instance], instance, triangle);
            last_instance = instance;
            last_triangle = triangle;
        }
        const float depth = RTCRayN_tfar(arguments->ray, count, lane);
        const float footprint_m = cast.pixel_angle * depth;
        const bool may_be_layer = cast.blend_within_m > 0.0f && surface.is_blended;
        const bool may_sway = cast.sway != nullptr && surface.sway_uv_per_m > 0.0f;
        bool in_layer = false;
        SwayPlace place;
        if (may_be_layer || may_sway) {
            // Instanced geometry gets the ray in its own space.
            Vec3 direction(RTCRayN_dir_x(arguments->ray, count, lane), RTCRayN_dir_y(arguments->ray, count, lane),
                           RTCRayN_dir_z(arguments->ray, count, lane));
            if (placed != RTC_INVALID_GEOMETRY_ID) direction = scene.instances[instance].world_from_mesh * direction;
            if (may_be_layer) in_layer = is_in_layer(surface, depth * glm::length(direction), cast.blend_within_m);
            if (may_sway) place = {cast.sway, depth * direction};
        }
        if (!is_opaque_at(surface, RTCHitN_u(arguments->hit, count, lane), RTCHitN_v(arguments->hit, count, lane),
                          footprint_m, in_layer, place))
            arguments->valid[lane] = 0;
    }
}

}  // namespace ff::farfield::embree
