// What of all that sounds is heard.

#include "engine/sound/audibility.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace ff::sound {
namespace {

TEST(Audibility, a_source_is_half_as_loud_at_twice_the_distance_and_no_louder_nearby) {
    const SoundSource source{.reference_m = 4.0f, .gain = 0.8f};
    EXPECT_FLOAT_EQ(heard_gain(source, 0.0), 0.8f);
    EXPECT_FLOAT_EQ(heard_gain(source, 4.0), 0.8f);
    EXPECT_FLOAT_EQ(heard_gain(source, 8.0), 0.4f);
    EXPECT_FLOAT_EQ(heard_gain(source, 80.0), 0.04f);
    EXPECT_EQ(heard_gain(source, std::numeric_limits<double>::infinity()), 0.0f);
}

TEST(Audibility, only_what_is_loud_enough_holds_a_voice_and_the_loudest_come_first) {
    std::vector<Emitter> emitters;
    for (std::uint64_t i = 0; i < 40; ++i)
        emitters.push_back({.id = i, .position = {10.0 * double(40 - i), 0.0, 0.0}, .source = {.reference_m = 1.0f}});
    std::vector<std::uint32_t> chosen;
    choose_voices(emitters, {}, 100, chosen);
    // 1 m over 200 m is the least that is heard: those at 10, 20 ... 200 m.
    EXPECT_EQ(chosen.size(), 20u);
    choose_voices(emitters, {}, kMostVoices, chosen);
    ASSERT_EQ(chosen.size(), kMostVoices);
    for (std::uint32_t i = 0; i < chosen.size(); ++i) EXPECT_EQ(emitters[chosen[i]].id, 39u - i);
    choose_voices(emitters, {1e6, 0.0, 0.0}, kMostVoices, chosen);
    EXPECT_TRUE(chosen.empty());
}

TEST(Audibility, equal_sources_are_taken_by_their_ids_in_whatever_order_they_come) {
    std::vector<Emitter> emitters;
    for (const std::uint64_t id : {7u, 3u, 9u, 1u, 5u}) emitters.push_back({.id = id, .position = {1, 0, 0}});
    std::vector<std::uint32_t> chosen;
    choose_voices(emitters, {}, 3, chosen);
    ASSERT_EQ(chosen.size(), 3u);
    EXPECT_EQ(emitters[chosen[0]].id, 1u);
    EXPECT_EQ(emitters[chosen[1]].id, 3u);
    EXPECT_EQ(emitters[chosen[2]].id, 5u);
}

}  // namespace
}  // namespace ff::sound
