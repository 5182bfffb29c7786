#include "engine/replay/state_hash.h"

#include <gtest/gtest.h>

#include <random>
#include <vector>

namespace ff::replay {
namespace {

StateDigest digest_of(const std::vector<double>& values) {
    StateHash hash;
    for (std::size_t i = 0; i < values.size(); ++i) {
        hash.entity({std::uint32_t(i), 1});
        hash.add(values[i]);
    }
    return hash.digest();
}

TEST(StateHashTest, names_the_entity_that_differs) {
    std::mt19937 random(5);
    int named = 0;
    constexpr int kTrials = 2000;
    for (int trial = 0; trial < kTrials; ++trial) {
        std::vector<double> values(900);
        for (double& value : values) value = std::uniform_real_distribution(-1e3, 1e3)(random);
        const StateDigest before = digest_of(values);
        const std::size_t changed = random() % values.size();
        values[changed] = std::nextafter(values[changed], 1e9);
        const StateDigest after = digest_of(values);
        ASSERT_NE(before.all, after.all);
        const auto found = differing_entity(before, after);
        if (!found) continue;  // both lanes' bytes may agree by chance
        EXPECT_EQ(*found, changed);
        ++named;
    }
    EXPECT_GT(named, kTrials * 97 / 100);
}

TEST(StateHashTest, knows_when_no_single_entity_explains_it) {
    std::vector<double> values(50, 1.0);
    const StateDigest before = digest_of(values);
    EXPECT_EQ(differing_entity(before, before), std::nullopt);
    values[3] = values[40] = 2.0;
    EXPECT_EQ(differing_entity(before, digest_of(values)), std::nullopt);
}

TEST(StateHashTest, order_zeros_signs_and_types_count) {
    const auto of = [](auto... values) {
        StateHash hash;
        (hash.add(values), ...);
        return hash.digest().all;
    };
    EXPECT_NE(of(1, 2), of(2, 1));
    EXPECT_NE(of(0.0), of(-0.0));
    EXPECT_NE(of(0), of(0, 0));
    EXPECT_NE(of(1.0f), of(1.0));
    EXPECT_EQ(of(1.5, 7), of(1.5, 7));
}

TEST(StateHashTest, a_digest_begins_the_next_one_anew) {
    StateHash hash;
    hash.entity({1, 1});
    hash.add(3);
    const StateDigest first = hash.digest();
    hash.entity({1, 1});
    hash.add(3);
    EXPECT_EQ(hash.digest(), first);
}

}  // namespace
}  // namespace ff::replay
