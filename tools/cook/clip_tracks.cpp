#include "tools/cook/clip_tracks.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <optional>

#include "engine/animation/sample_clip.h"

namespace ff::cook {
namespace {

using scene::Clip;
using scene::Interpolation;
using scene::Track;
using scene::TrackPath;

/// A clip of one track of joint 0, to be asked for its values.
struct Lone {
    Clip clip;
    animation::Pose pose;

    explicit Lone(const SourceTrack& source, bool even, std::vector<float> times, std::vector<float> values) {
        const std::uint32_t per_key =
            scene::components_of(source.path) * (source.interpolation == Interpolation::cubic && !even ? 3 : 1);
        clip.tracks = {{.joint = 0,
                        .path = source.path,
                        .interpolation = even ? Interpolation::linear : source.interpolation,
                        .even = even,
                        .key_count = std::uint32_t(values.size() / per_key)}};
        clip.times = std::move(times);
        clip.values = std::move(values);
        pose.translations = {Vec3(0.0f)};
        pose.rotations = {scene::Quat(1.0f, 0.0f, 0.0f, 0.0f)};
        pose.scales = {Vec3(1.0f)};
    }

    Vec4 at(float time_s) {
        animation::sample_clip(clip, time_s, pose);
        const scene::Quat& q = pose.rotations[0];
        switch (clip.tracks[0].path) {
            case TrackPath::translation:
                return Vec4(pose.translations[0], 0.0f);
            case TrackPath::rotation:
                return {q.x, q.y, q.z, q.w};
            case TrackPath::scale:
                return Vec4(pose.scales[0], 0.0f);
        }
        return {};
    }
};

float difference(TrackPath path, const Vec4& a, const Vec4& b) {
    const DVec3 d(DVec3(a) - DVec3(b));
    if (path != TrackPath::rotation) return float(std::sqrt(d.x * d.x + d.y * d.y + d.z * d.z));
    // Of quaternions near each other half the angle is about their distance; q and -q are one rotation.
    const double w = double(a.w) - b.w, same = d.x * d.x + d.y * d.y + d.z * d.z + w * w;
    const DVec3 s(DVec3(a) + DVec3(b));
    const double v = double(a.w) + b.w, other = s.x * s.x + s.y * s.y + s.z * s.z + v * v;
    return float(2.0 * std::sqrt(std::min(same, other)));
}

void append(const Lone& lone, std::uint32_t joint, Clip& clip) {
    Track track = lone.clip.tracks[0];
    track.joint = joint;
    track.first_time = std::uint32_t(clip.times.size());
    track.first_value = std::uint32_t(clip.values.size());
    clip.times.insert(clip.times.end(), lone.clip.times.begin(), lone.clip.times.end());
    clip.values.insert(clip.values.end(), lone.clip.values.begin(), lone.clip.values.end());
    clip.tracks.push_back(track);
}

bool is_constant(const SourceTrack& source, Lone& exact, float allowed) {
    const Vec4 first = exact.at(source.times.front());
    if (source.interpolation == Interpolation::cubic) return false;  // tangents may lead away between equal keys
    return std::all_of(source.times.begin(), source.times.end(),
                       [&](float time) { return difference(source.path, exact.at(time), first) <= 0.5f * allowed; });
}

/// Samples `steps` + 1 values, where they are close enough everywhere that it is looked: eight times between samples,
/// and at every key.
std::optional<Lone> sampled(const SourceTrack& source, Lone& exact, int steps, float allowed) {
    const float start = source.times.front(), length = source.times.back() - start;
    const float step = length / float(steps);
    if (!(step > 0.0f)) return std::nullopt;
    std::vector<float> values;
    Vec4 before(0.0f);
    for (int i = 0; i <= steps; ++i) {
        Vec4 value = exact.at(i == steps ? source.times.back() : start + float(i) * step);
        if (source.path == TrackPath::rotation && i > 0 && glm::dot(value, before) < 0.0f) value = -value;
        before = value;
        const float numbers[] = {value.x, value.y, value.z, value.w};
        values.insert(values.end(), numbers, numbers + scene::components_of(source.path));
    }
    Lone out(source, true, {start, step}, std::move(values));
    const auto errs = [&](float time) { return difference(source.path, exact.at(time), out.at(time)) > allowed; };
    for (int i = 0; i < 8 * steps; ++i)
        if (errs(start + (float(i) + 0.5f) * step / 8.0f)) return std::nullopt;
    if (std::any_of(source.times.begin(), source.times.end(), errs)) return std::nullopt;
    return out;
}

}  // namespace

void add_track(SourceTrack source, float max_translation_error_m, Clip& clip) {
    const float allowed = source.path == TrackPath::rotation ? kMaxRotationError
                          : source.path == TrackPath::scale  ? kMaxScaleError
                                                             : max_translation_error_m;
    clip.duration_s = std::max(clip.duration_s, source.times.back());
    Lone exact(source, false, source.times, source.values);
    if (is_constant(source, exact, allowed)) {
        const Vec4 value = exact.at(source.times.front());
        const float numbers[] = {value.x, value.y, value.z, value.w};
        SourceTrack one = source;
        one.interpolation = Interpolation::step;
        append(Lone(one, false, {0.0f}, {numbers, numbers + scene::components_of(source.path)}), source.joint, clip);
        return;
    }
    std::optional<Lone> best;
    if (source.interpolation != Interpolation::step) {
        const float length = source.times.back() - source.times.front();
        for (const float rate_hz : {15.0f, 30.0f, 60.0f}) {
            const double steps = std::ceil(double(length) * double(rate_hz));
            const double numbers = (steps + 1.0) * scene::components_of(source.path) + 2.0;
            if (numbers >= double(source.times.size() + source.values.size())) break;
            best = sampled(source, exact, int(steps), allowed);
            if (best) break;
        }
    }
    append(best ? *best : exact, source.joint, clip);
}

}  // namespace ff::cook
