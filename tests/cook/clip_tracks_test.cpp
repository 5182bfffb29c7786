#include "tools/cook/clip_tracks.h"

#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>

#include "engine/animation/sample_clip.h"

namespace ff::cook {
namespace {

using scene::Interpolation;
using scene::TrackPath;

SourceTrack swing(int keys, float duration_s) {
    SourceTrack track{.path = TrackPath::rotation};
    for (int k = 0; k <= keys; ++k) {
        const float part = float(k) / float(keys), angle = 0.4f * std::sin(6.2831853f * part);
        track.times.push_back(duration_s * part);
        for (const float number : {0.0f, 0.0f, std::sin(0.5f * angle), std::cos(0.5f * angle)})
            track.values.push_back(number);
    }
    return track;
}

animation::Pose one_joint() {
    animation::Pose pose;
    pose.translations = {Vec3(0.0f)};
    pose.rotations = {scene::Quat(1, 0, 0, 0)};
    pose.scales = {Vec3(1.0f)};
    return pose;
}

TEST(ClipTracks, what_is_sampled_too_often_is_kept_as_fewer_samples_within_the_error) {
    const SourceTrack source = swing(2000, 2.0f);
    scene::Clip clip{.name = "swing"}, exact{.name = "exact", .duration_s = 2.0f};
    add_track(source, 0.01f, clip);
    EXPECT_TRUE(clip.tracks[0].even);
    EXPECT_LT(clip.values.size(), source.values.size() / 10);
    exact.tracks = {{.path = TrackPath::rotation, .key_count = 2001}};
    exact.times = source.times;
    exact.values = source.values;
    animation::Pose a = one_joint(), b = one_joint();
    for (int i = 0; i <= 1000; ++i) {
        animation::sample_clip(clip, 0.002f * float(i), a);
        animation::sample_clip(exact, 0.002f * float(i), b);
        const auto &p = a.rotations[0], &q = b.rotations[0];
        const float distance = std::hypot(std::hypot(p.x - q.x, p.y - q.y), std::hypot(p.z - q.z, p.w - q.w));
        EXPECT_LE(2.0f * distance, kMaxRotationError * 1.05f) << i;
    }
}

TEST(ClipTracks, few_keys_stay_as_they_are) {
    const SourceTrack source = swing(6, 2.0f);
    scene::Clip clip;
    add_track(source, 0.01f, clip);
    EXPECT_FALSE(clip.tracks[0].even);
    EXPECT_EQ(clip.values, source.values);
    EXPECT_EQ(clip.times, source.times);
}

TEST(ClipTracks, what_never_changes_is_one_key_and_steps_stay_steps) {
    scene::Clip clip;
    SourceTrack still{.path = TrackPath::translation};
    SourceTrack steps{.joint = 1, .path = TrackPath::translation, .interpolation = Interpolation::step};
    for (int k = 0; k < 200; ++k) {
        still.times.push_back(0.01f * float(k));
        still.values.insert(still.values.end(), {1.0f, 2.0f, 3.0f});
        steps.times.push_back(0.01f * float(k));
        steps.values.insert(steps.values.end(), {float(k % 2), 0.0f, 0.0f});
    }
    add_track(still, 0.01f, clip);
    add_track(steps, 0.01f, clip);
    EXPECT_EQ(clip.tracks[0].key_count, 1u);
    EXPECT_EQ(clip.tracks[1].key_count, 200u);
    EXPECT_EQ(clip.tracks[1].interpolation, Interpolation::step);
    EXPECT_FLOAT_EQ(clip.duration_s, 1.99f);
}

}  // namespace
}  // namespace ff::cook
