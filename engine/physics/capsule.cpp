#include "engine/physics/capsule.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

namespace ff::physics {
namespace {

double squared(const DVec3& v) {
    return glm::dot(v, v);
}

/// Where a segment goes through a triangle's inside. Parallel ones do not: their nearest points lie on borders.
std::optional<DVec3> crossing(const Segment& s, const Triangle& t) {
    // Moeller, Trumbore, "Fast, Minimum Storage Ray/Triangle Intersection", JGT 1997
    const DVec3 along = s.b - s.a, ab = t.b - t.a, ac = t.c - t.a;
    const DVec3 p = glm::cross(along, ac);
    const double det = glm::dot(ab, p);
    if (det == 0.0) return {};
    const DVec3 from = s.a - t.a;
    const double u = glm::dot(from, p) / det;
    if (!(u >= 0.0 && u <= 1.0)) return {};
    const DVec3 q = glm::cross(from, ab);
    const double v = glm::dot(along, q) / det;
    if (!(v >= 0.0 && u + v <= 1.0)) return {};
    const double at = glm::dot(ac, q) / det;
    if (!(at >= 0.0 && at <= 1.0)) return {};
    return s.a + along * at;
}

/// The direction in which a capsule leaves what it crosses: against its motion.
DVec3 way_out(const DVec3& normal, const DVec3& along) {
    if (squared(normal) > 0.5) return glm::dot(normal, along) <= 0.0 ? normal : -normal;
    const double length = glm::length(along);
    return length > 0.0 ? -along / length : DVec3(0.0, 1.0, 0.0);
}

template <class Other, class WayOut>
std::optional<Touch> advance(const Segment& capsule, double radius, const DVec3& along, const Other& other,
                             double limit, bool leave_crossed, WayOut&& out_of) {
    constexpr int kSteps = 48;
    // Motion along a surface is not motion into it, whatever rounding says: 0.1 mm a kilometre.
    const double parallel = 1e-7 * glm::length(along);
    double time = 0.0;
    Touch at;
    for (int step = 0; step < kSteps; ++step) {
        const DVec3 moved = along * time;
        const Nearest found = nearest(Segment{capsule.a + moved, capsule.b + moved}, other);
        const double gap = found.distance - radius;
        if (leave_crossed && step == 0 && found.distance <= 1e-12) return {};
        at = {time, found.distance > 1e-12 ? (found.on_segment - found.on_other) / found.distance : out_of(),
              found.on_other};
        const double closing = -glm::dot(at.normal, along);
        // The plane between the nearest points parts the two for as long as nobody comes nearer to it.
        if (!(closing > parallel)) return {};
        if (gap <= kTouchGap) return at;
        time += (gap - 0.5 * kTouchGap) / closing;
        if (!(time <= limit)) return {};
    }
    return at;
}

}  // namespace

DVec3 nearest_on_segment(const Segment& s, const DVec3& p) {
    const DVec3 along = s.b - s.a;
    const double length2 = squared(along);
    if (!(length2 > 0.0)) return s.a;
    const double at = glm::dot(p - s.a, along) / length2;
    if (at <= 0.0) return s.a;
    return at >= 1.0 ? s.b : s.a + along * at;
}

DVec3 nearest_on_triangle(const Triangle& t, const DVec3& p) {
    // Ericson 5.1.5, by the Voronoi regions of corners and edges.
    const DVec3 ab = t.b - t.a, ac = t.c - t.a, ap = p - t.a;
    const double d1 = glm::dot(ab, ap), d2 = glm::dot(ac, ap);
    if (d1 <= 0.0 && d2 <= 0.0) return t.a;
    const DVec3 bp = p - t.b;
    const double d3 = glm::dot(ab, bp), d4 = glm::dot(ac, bp);
    if (d3 >= 0.0 && d4 <= d3) return t.b;
    const double vc = d1 * d4 - d3 * d2;
    if (vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 && d1 - d3 > 0.0) return t.a + ab * (d1 / (d1 - d3));
    const DVec3 cp = p - t.c;
    const double d5 = glm::dot(ab, cp), d6 = glm::dot(ac, cp);
    if (d6 >= 0.0 && d5 <= d6) return t.c;
    const double vb = d5 * d2 - d1 * d6;
    if (vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 && d2 - d6 > 0.0) return t.a + ac * (d2 / (d2 - d6));
    const double va = d3 * d6 - d5 * d4;
    const double e1 = d4 - d3, e2 = d5 - d6;
    if (va <= 0.0 && e1 >= 0.0 && e2 >= 0.0 && e1 + e2 > 0.0) return t.b + (t.c - t.b) * (e1 / (e1 + e2));
    const double sum = va + vb + vc;
    if (!(sum > 0.0)) {  // no area: the nearest of its edges
        DVec3 best = nearest_on_segment({t.a, t.b}, p);
        for (const DVec3& q : {nearest_on_segment({t.b, t.c}, p), nearest_on_segment({t.c, t.a}, p)})
            if (squared(q - p) < squared(best - p)) best = q;
        return best;
    }
    return t.a + ab * (vb / sum) + ac * (vc / sum);
}

Nearest nearest(const Segment& s, const Segment& o) {
    // Ericson 5.1.9
    const DVec3 d1 = s.b - s.a, d2 = o.b - o.a, r = s.a - o.a;
    const double a = squared(d1), e = squared(d2), f = glm::dot(d2, r);
    double at = 0.0, bt = 0.0;
    if (a > 0.0 && e > 0.0) {
        const double c = glm::dot(d1, r), b = glm::dot(d1, d2);
        const double denominator = a * e - b * b;
        if (denominator > 1e-12 * a * e) at = std::clamp((b * f - c * e) / denominator, 0.0, 1.0);
        bt = (b * at + f) / e;
        if (bt < 0.0) {
            bt = 0.0;
            at = std::clamp(-c / a, 0.0, 1.0);
        } else if (bt > 1.0) {
            bt = 1.0;
            at = std::clamp((b - c) / a, 0.0, 1.0);
        }
    } else if (a > 0.0) {
        at = std::clamp(-glm::dot(d1, r) / a, 0.0, 1.0);
    } else if (e > 0.0) {
        bt = std::clamp(f / e, 0.0, 1.0);
    }
    Nearest out;
    out.on_segment = s.a + d1 * at;
    out.on_other = o.a + d2 * bt;
    out.distance = glm::length(out.on_segment - out.on_other);
    return out;
}

Nearest nearest(const Segment& s, const Triangle& t) {
    if (const std::optional<DVec3> through = crossing(s, t)) return {0.0, *through, *through};
    Nearest best;
    best.on_segment = s.a;
    best.on_other = nearest_on_triangle(t, s.a);
    best.distance = glm::length(best.on_segment - best.on_other);
    if (squared(s.b - s.a) > 0.0) {
        const DVec3 q = nearest_on_triangle(t, s.b);
        if (const double d = glm::length(q - s.b); d < best.distance) best = {d, s.b, q};
        for (const Segment& edge : {Segment{t.a, t.b}, Segment{t.b, t.c}, Segment{t.c, t.a}})
            if (const Nearest n = nearest(s, edge); n.distance < best.distance) best = n;
    }
    return best;
}

DVec3 normal_of(const Triangle& t) {
    const DVec3 n = glm::cross(t.b - t.a, t.c - t.a);
    const double length = glm::length(n);
    return length > 0.0 ? n / length : DVec3(0.0);
}

std::optional<Touch> touch(const Segment& capsule, double radius, const DVec3& along, const Triangle& triangle,
                           double limit, bool leave_crossed) {
    return advance(capsule, radius, along, triangle, limit, leave_crossed,
                   [&] { return way_out(normal_of(triangle), along); });
}

std::optional<Touch> touch(const Segment& capsule, double radius, const DVec3& along, const Segment& other,
                           double limit, bool leave_crossed) {
    return advance(capsule, radius, along, other, limit, leave_crossed, [&] { return way_out(DVec3(0.0), along); });
}

}  // namespace ff::physics
