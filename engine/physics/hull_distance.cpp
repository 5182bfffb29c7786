#include "engine/physics/hull_distance.h"

#include <algorithm>
#include <glm/geometric.hpp>
#include <limits>

namespace ff::physics {

std::optional<HullNearest> nearest_on_hull(const Segment& s, double reach, const Geometry& geometry) {
    // By the face planes first: one that parts the two by more than the reach ends it.
    double best = -std::numeric_limits<double>::infinity();
    std::size_t best_face = 0;
    for (std::size_t f = 0; f < geometry.faces.size(); ++f) {
        const DVec3 &normal = geometry.normals[f], &corner = geometry.faces[f].a;
        const double apart = std::min(glm::dot(normal, s.a - corner), glm::dot(normal, s.b - corner));
        if (apart > reach) return {};
        if (apart > best) best = apart, best_face = f;
    }
    if (best > 0.0) {
        Nearest found{std::numeric_limits<double>::infinity(), {}, {}};
        for (const Triangle& face : geometry.faces)
            if (const Nearest n = nearest(s, face); n.distance < found.distance) found = n;
        if (found.distance > reach) return {};
        if (found.distance > 1e-12)
            return HullNearest{found.distance, (found.on_segment - found.on_other) / found.distance, found.on_segment,
                               found.on_other};
    }
    // No face parts the two: the segment is within, or crosses an edge, and leaves by the nearest plane.
    HullNearest out;
    out.distance = best;
    out.normal = geometry.normals[best_face];
    out.on_segment = glm::dot(out.normal, s.a - s.b) < 0.0 ? s.a : s.b;
    out.on_hull = out.on_segment - out.normal * best;
    return out;
}

}  // namespace ff::physics
