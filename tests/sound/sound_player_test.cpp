// What OpenAL makes of sources, by its loopback device: samples instead of sound.

#include "engine/sound/sound_player.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "engine/sound/audibility.h"

namespace ff::sound {
namespace {

constexpr int kRateHz = 22050;

/// A world with a tone of a second, and one of a tenth of it.
scene::SoundSet tones() {
    scene::SoundSet set;
    for (const int length : {kRateHz, kRateHz / 10}) {
        scene::SoundClip clip{.name = "tone of " + std::to_string(length), .rate_hz = kRateHz, .samples = {}};
        for (int i = 0; i < length; ++i)
            clip.samples.push_back(std::int16_t(12000.0 * std::sin(2.0 * kPi * 440.0 * i / kRateHz)));
        set.clips.push_back(clip);
    }
    return set;
}

struct Loudness {
    double left = 0.0, right = 0.0;
    [[nodiscard]] double both() const { return std::hypot(left, right); }
};

/// Root mean square of the next tenth of a second; what a change fades over is passed by.
Loudness hear(SoundPlayer& player) {
    std::vector<std::int16_t> samples(2 * kRateHz / 10);
    player.render(samples);
    player.render(samples);
    Loudness out;
    for (std::size_t i = 0; i < samples.size(); i += 2) {
        out.left += double(samples[i]) * samples[i];
        out.right += double(samples[i + 1]) * samples[i + 1];
    }
    out.left = std::sqrt(2.0 * out.left / double(samples.size()));
    out.right = std::sqrt(2.0 * out.right / double(samples.size()));
    return out;
}

class SoundPlayerTest : public testing::Test {
  protected:
    void SetUp() override {
        auto opened = SoundPlayer::open_loopback(sounds, kRateHz);
        ASSERT_TRUE(opened) << opened.error().message;
        player.emplace(std::move(*opened));
    }
    Loudness hear_from(const WorldPos& place, const Camera& ear, float volume = 1.0f) {
        const Emitter emitter{.id = 1, .position = place, .source = {.clip = 0, .reference_m = 2.0f}};
        player->update(ear, {&emitter, 1}, {}, time_s += 1.0, volume);
        return hear(*player);
    }

    scene::SoundSet sounds = tones();
    std::optional<SoundPlayer> player;
    double time_s = 0.0;
};

TEST_F(SoundPlayerTest, a_source_at_the_right_is_louder_in_the_right_channel_and_turning_round_swaps_them) {
    // Far from the origin: places are told relative to the ear.
    const WorldPos ear(3.0e6, 50.0, -2.0e6), east = ear + DVec3(4.0, 0.0, 0.0);
    const Loudness north = hear_from(east, {.position = ear});
    EXPECT_GT(north.right, 1.5 * north.left);
    const Loudness south = hear_from(east, {.position = ear, .yaw = kPi});
    EXPECT_GT(south.left, 1.5 * south.right);
    const Loudness facing = hear_from(east, {.position = ear, .yaw = kPi / 2});
    EXPECT_NEAR(facing.left / facing.right, 1.0, 0.05);
}

TEST_F(SoundPlayerTest, loudness_falls_with_distance_and_follows_the_volume) {
    const auto at = [&](double metres, float volume) { return hear_from({0.0, 0.0, -metres}, {}, volume).both(); };
    const double near = at(2.0, 1.0f);
    EXPECT_GT(near, 1000.0);
    EXPECT_NEAR(at(1.0, 1.0f) / near, 1.0, 0.03) << "no louder than at the reference distance";
    EXPECT_NEAR(at(8.0, 1.0f) / near, 0.25, 0.02);
    EXPECT_NEAR(at(2.0, 0.5f) / near, 0.5, 0.03);
    EXPECT_EQ(player->voices(), 1u);
    EXPECT_LT(at(500.0, 1.0f), 1.0);
    EXPECT_EQ(player->voices(), 0u) << "what cannot be heard holds no voice";
}

TEST_F(SoundPlayerTest, an_event_is_heard_once) {
    const SoundEvent event{.at_s = 10.0, .position = {0, 0, -2}, .source = {.clip = 1}};
    const auto update = [&](double now) { player->update({}, {}, {&event, 1}, now, 1.0f); };
    update(9.5);
    EXPECT_EQ(player->voices(), 0u) << "not yet";
    update(10.2);
    EXPECT_EQ(player->voices(), 1u);
    std::vector<std::int16_t> samples(kRateHz);
    player->render(samples);
    EXPECT_GT(*std::max_element(samples.begin(), samples.end()), 3000);
    update(10.4);
    EXPECT_EQ(player->voices(), 0u) << "it has ended";
    update(9.0);
    EXPECT_EQ(player->voices(), 0u);
    update(9.4);
    EXPECT_EQ(player->voices(), 0u) << "a loaded game is earlier";
}

TEST_F(SoundPlayerTest, a_first_frame_plays_nothing_that_happened_before_it) {
    const SoundEvent event{.at_s = 10.0, .source = {.clip = 1}};
    player->update({}, {}, {&event, 1}, 10.5, 1.0f);
    EXPECT_EQ(player->voices(), 0u);
}

TEST_F(SoundPlayerTest, never_more_voices_than_there_are_and_events_go_before_them) {
    std::vector<Emitter> emitters;
    for (std::uint64_t i = 0; i < 50; ++i)
        emitters.push_back({.id = i, .position = {1.0 + 0.1 * double(i), 0.0, 0.0}, .source = {.clip = 0}});
    player->update({}, emitters, {}, 1.0, 1.0f);
    EXPECT_EQ(player->voices(), kMostVoices);
    const SoundEvent event{.at_s = 1.5, .position = {0, 0, -30}, .source = {.clip = 1}};
    player->update({}, emitters, {&event, 1}, 2.0, 1.0f);
    EXPECT_EQ(player->voices(), kMostVoices);
    player->silence();
    EXPECT_EQ(player->voices(), 0u);
    EXPECT_LT(hear(*player).both(), 1.0);
}

TEST_F(SoundPlayerTest, the_worlds_own_sources_are_heard_without_being_asked_for) {
    player.reset();
    sounds.sources.push_back({.position = {5.0, 0.0, 0.0}, .clip = 0, .reference_m = 5.0f, .gain = 1.0f});
    auto opened = SoundPlayer::open_loopback(sounds, kRateHz);
    ASSERT_TRUE(opened) << opened.error().message;
    opened->update({}, {}, {}, 1.0, 1.0f);
    EXPECT_EQ(opened->voices(), 1u);
    const Loudness heard = hear(*opened);
    EXPECT_GT(heard.right, 1000.0);
    EXPECT_GT(heard.right, 1.5 * heard.left);
}

}  // namespace
}  // namespace ff::sound
