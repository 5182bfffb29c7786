// Clips against a plain reading of glTF's appendix C in double.

#include "engine/animation/sample_clip.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "tests/support/animated_worlds.h"

namespace ff::animation {
namespace {

using scene::Clip;
using scene::Interpolation;
using scene::Track;
using scene::TrackPath;

using Value = std::array<double, 4>;

double dot(const Value& a, const Value& b) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3];
}

Value normalized(Value v) {
    const double length = std::sqrt(dot(v, v));
    for (double& x : v) x /= length;
    return v;
}

/// The value of an uneven track.
Value reference(const Clip& clip, const Track& track, double time) {
    const int n = int(scene::components_of(track.path));
    const bool is_cubic = track.interpolation == Interpolation::cubic;
    const auto value = [&](std::uint32_t key, int part) {
        Value v{};
        for (int i = 0; i < n; ++i)
            v[std::size_t(i)] =
                double(clip.values[track.first_value + (key * (is_cubic ? 3 : 1) + unsigned(part)) * unsigned(n) +
                                   unsigned(i)]);
        return v;
    };
    const int middle = is_cubic ? 1 : 0;
    const float* times = clip.times.data() + track.first_time;
    const std::uint32_t last = track.key_count - 1;
    const bool is_rotation = track.path == TrackPath::rotation;
    const auto finished = [&](const Value& v) { return is_rotation ? normalized(v) : v; };
    if (time <= double(times[0])) return finished(value(0, middle));
    if (time >= double(times[last])) return finished(value(last, middle));
    std::uint32_t k = 0;
    while (double(times[k + 1]) <= time) ++k;
    const double gap = double(times[k + 1]) - double(times[k]), t = (time - double(times[k])) / gap;
    Value a = value(k, middle), b = value(k + 1, middle), out{};
    if (track.interpolation == Interpolation::step) return finished(a);
    if (is_cubic) {
        const Value m0 = value(k, 2), m1 = value(k + 1, 0);
        for (std::size_t i = 0; i < 4; ++i)
            out[i] = (2 * t * t * t - 3 * t * t + 1) * a[i] + gap * (t * t * t - 2 * t * t + t) * m0[i] +
                     (-2 * t * t * t + 3 * t * t) * b[i] + gap * (t * t * t - t * t) * m1[i];
        return finished(out);
    }
    if (!is_rotation) {
        for (std::size_t i = 0; i < 4; ++i) out[i] = a[i] + t * (b[i] - a[i]);
        return out;
    }
    const double sign = dot(a, b) < 0.0 ? -1.0 : 1.0;
    const double angle = std::acos(std::min(1.0, std::fabs(dot(a, b))));
    if (angle < 1e-9) return normalized(a);
    for (std::size_t i = 0; i < 4; ++i)
        out[i] = (std::sin((1 - t) * angle) * a[i] + sign * std::sin(t * angle) * b[i]) / std::sin(angle);
    return normalized(out);
}

Value sampled(const Clip& clip, const Track& track, float time, Pose& pose) {
    sample_clip(clip, time, pose);
    const auto& q = pose.rotations[track.joint];
    const Vec3 v = track.path == TrackPath::translation ? pose.translations[track.joint] : pose.scales[track.joint];
    if (track.path == TrackPath::rotation) return {double(q.x), double(q.y), double(q.z), double(q.w)};
    return {double(v.x), double(v.y), double(v.z), 0.0};
}

scene::Skeleton joints(std::uint32_t count) {
    scene::Skeleton skeleton;
    skeleton.names.resize(count);
    skeleton.parents.assign(count, scene::kNoJoint);
    skeleton.translations.assign(count, Vec3(0.0f));
    skeleton.rotations.assign(count, Quat(1, 0, 0, 0));
    skeleton.scales.assign(count, Vec3(1.0f));
    return skeleton;
}

TEST(SampleClip, random_clips_are_what_the_reference_in_double_says) {
    for (std::uint32_t seed = 0; seed < 200; ++seed) {
        SCOPED_TRACE(seed);
        test::Random random(seed);
        Clip clip{.name = "random"};
        constexpr TrackPath kPaths[] = {TrackPath::translation, TrackPath::rotation, TrackPath::scale};
        for (std::uint32_t joint = 0; joint < 3; ++joint)
            for (const TrackPath path : kPaths)
                test::append_random_track(random, joint, path, Interpolation(random.below(3)), 1 + int(random.below(9)),
                                          3.0f, clip);
        Pose pose;
        pose.set_rest(joints(3));
        for (int i = 0; i < 60; ++i) {
            const float time = float(random.in(-0.2, 3.3));
            for (const Track& track : clip.tracks) {
                const Value found = sampled(clip, track, time, pose), expected = reference(clip, track, double(time));
                double worst = 0.0;
                // A cubic rotation may pass near zero, where it has no direction to speak of.
                for (std::size_t c = 0; c < 4; ++c) worst = std::max(worst, std::fabs(found[c] - expected[c]));
                const bool is_cubic_rotation =
                    track.path == TrackPath::rotation && track.interpolation == Interpolation::cubic;
                EXPECT_LT(worst, is_cubic_rotation ? 2e-3 : 1e-4) << "joint " << track.joint << " at " << time;
            }
        }
    }
}

TEST(SampleClip, even_samples_are_what_the_same_keys_are) {
    test::Random random(7);
    Clip uneven{.name = "uneven", .duration_s = 2.0f}, even{.name = "even", .duration_s = 2.0f};
    for (int k = 0; k <= 8; ++k) {
        uneven.times.push_back(0.25f * float(k));
        for (int i = 0; i < 3; ++i) uneven.values.push_back(float(random.in(-5, 5)));
    }
    uneven.tracks = {{.key_count = 9}};
    even.values = uneven.values;
    even.times = {0.0f, 0.25f};
    even.tracks = {{.even = true, .key_count = 9}};
    Pose a, b;
    a.set_rest(joints(1));
    b.set_rest(joints(1));
    for (int i = -10; i < 300; ++i) {
        sample_clip(uneven, 0.01f * float(i), a);
        sample_clip(even, 0.01f * float(i), b);
        for (int c = 0; c < 3; ++c) EXPECT_NEAR(a.translations[0][c], b.translations[0][c], 1e-5f) << i;
    }
}

TEST(SampleClip, a_clip_loops_stays_or_turns_back) {
    const Clip clip{.name = "two seconds", .duration_s = 2.0f};
    EXPECT_FLOAT_EQ(clip_time(clip, 5.5, PlayMode::loop), 1.5f);
    EXPECT_FLOAT_EQ(clip_time(clip, -0.5, PlayMode::loop), 1.5f);
    EXPECT_FLOAT_EQ(clip_time(clip, 5.5, PlayMode::once), 2.0f);
    EXPECT_FLOAT_EQ(clip_time(clip, -1.0, PlayMode::once), 0.0f);
    EXPECT_FLOAT_EQ(clip_time(clip, 2.5, PlayMode::ping_pong), 1.5f);
    EXPECT_FLOAT_EQ(clip_time(clip, 4.5, PlayMode::ping_pong), 0.5f);
    EXPECT_FLOAT_EQ(clip_time(Clip{}, 4.5, PlayMode::loop), 0.0f);
    EXPECT_FLOAT_EQ(clip_time(clip, std::nan(""), PlayMode::loop), 0.0f);
}

}  // namespace
}  // namespace ff::animation
