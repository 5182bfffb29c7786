#include "engine/farfield/embree_caster_alpha.h"

#include "engine/farfield/alpha_test.h"

namespace ff::farfield::embree {

void filter_see_through(const RTCFilterFunctionNArguments* arguments) {
    const auto& scene = *static_cast<const scene::StaticScene*>(arguments->geometryUserPtr);
    const float pixel_angle = reinterpret_cast<const CastContext*>(arguments->context)->pixel_angle;
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
        const float footprint_m = pixel_angle * RTCRayN_tfar(arguments->ray, count, lane);
        if (!is_opaque_at(surface, RTCHitN_u(arguments->hit, count, lane), RTCHitN_v(arguments->hit, count, lane),
                          footprint_m))
            arguments->valid[lane] = 0;
    }
}

}  // namespace ff::farfield::embree
