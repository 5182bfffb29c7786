#include "engine/animation/sample_clip.h"

#include <algorithm>
#include <cmath>

namespace ff::animation {
namespace {

using scene::Clip;
using scene::Interpolation;
using scene::Track;
using scene::TrackPath;

/// Between which keys a time lies, and how far along.
struct Place {
    std::uint32_t key = 0;  ///< and key + 1, where along > 0
    float along = 0.0f;     ///< [0, 1)
    float gap_s = 0.0f;     ///< between the two
};

Place find_place(const Clip& clip, const Track& track, float time_s) {
    const float* times = clip.times.data() + track.first_time;
    const std::uint32_t last = track.key_count - 1;
    if (track.even) {
        const float at = (time_s - times[0]) / times[1];
        if (!(at > 0.0f)) return {};
        if (at >= float(last)) return {.key = last};
        const auto key = std::min(std::uint32_t(at), last - 1);
        return {.key = key, .along = at - float(key), .gap_s = times[1]};
    }
    const float* after = std::upper_bound(times, times + track.key_count, time_s);
    if (after == times) return {};
    const auto key = std::uint32_t(after - times) - 1;
    if (key == last) return {.key = last};
    const float gap_s = times[key + 1] - times[key];
    return {.key = key, .along = (time_s - times[key]) / gap_s, .gap_s = gap_s};
}

Vec4 load(const float* values, int components) {
    return {values[0], values[1], values[2], components == 4 ? values[3] : 0.0f};
}

/// Hermite spline of key k's value and out-tangent, and the next key's in-tangent and value.
Vec4 cubic(const float* key, int components, const Place& place) {
    const Vec4 v0 = load(key + components, components);
    if (place.along <= 0.0f) return v0;
    const Vec4 out0 = load(key + 2 * components, components) * place.gap_s;
    const Vec4 in1 = load(key + 3 * components, components) * place.gap_s;
    const Vec4 v1 = load(key + 4 * components, components);
    const float t = place.along, t2 = t * t, t3 = t2 * t;
    return (2 * t3 - 3 * t2 + 1) * v0 + (t3 - 2 * t2 + t) * out0 + (3 * t2 - 2 * t3) * v1 + (t3 - t2) * in1;
}

/// Along the great circle; straight where the angle is so small that the difference is below rounding.
Vec4 spherical(const Vec4& a, Vec4 b, float t) {
    float cosine = a.x * b.x + a.y * b.y + a.z * b.z + a.w * b.w;
    if (cosine < 0.0f) {
        cosine = -cosine;
        b = -b;
    }
    if (cosine > 0.9995f) return a + t * (b - a);
    const float angle = std::acos(cosine), per_sine = 1.0f / std::sin(angle);
    return (std::sin((1.0f - t) * angle) * per_sine) * a + (std::sin(t * angle) * per_sine) * b;
}

Quat unit_quaternion(const Vec4& v) {
    const float squared = v.x * v.x + v.y * v.y + v.z * v.z + v.w * v.w;
    if (!(squared > 1e-12f)) return {1.0f, 0.0f, 0.0f, 0.0f};
    const float s = 1.0f / std::sqrt(squared);
    return {v.w * s, v.x * s, v.y * s, v.z * s};
}

Vec4 value_at(const Clip& clip, const Track& track, float time_s) {
    const auto components = int(scene::components_of(track.path));
    const Place place = find_place(clip, track, time_s);
    const int stride = track.interpolation == Interpolation::cubic ? 3 * components : components;
    const float* key = clip.values.data() + track.first_value + std::size_t(place.key) * std::size_t(stride);
    if (track.interpolation == Interpolation::cubic) return cubic(key, components, place);
    const Vec4 before = load(key, components);
    if (track.interpolation == Interpolation::step || place.along <= 0.0f) return before;
    const Vec4 after = load(key + components, components);
    if (track.path == TrackPath::rotation) return spherical(before, after, place.along);
    return before + place.along * (after - before);
}

}  // namespace

float clip_time(const Clip& clip, double time_s, PlayMode mode) {
    const double duration = clip.duration_s;
    if (!(duration > 0.0) || !std::isfinite(time_s)) return 0.0f;
    double at = time_s;
    if (mode == PlayMode::loop) {
        at = time_s - duration * std::floor(time_s / duration);
    } else if (mode == PlayMode::ping_pong) {
        at = time_s - 2.0 * duration * std::floor(time_s / (2.0 * duration));
        if (at > duration) at = 2.0 * duration - at;
    }
    return float(std::clamp(at, 0.0, duration));
}

void sample_clip(const Clip& clip, float time_s, Pose& pose) {
    for (const Track& track : clip.tracks) {
        const Vec4 value = value_at(clip, track, time_s);
        switch (track.path) {
            case TrackPath::translation:
                pose.translations[track.joint] = Vec3(value);
                break;
            case TrackPath::rotation:
                pose.rotations[track.joint] = unit_quaternion(value);
                break;
            case TrackPath::scale:
                pose.scales[track.joint] = Vec3(value);
                break;
        }
    }
}

}  // namespace ff::animation
