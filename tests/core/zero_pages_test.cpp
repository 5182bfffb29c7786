#include "engine/core/zero_pages.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>

namespace ff {
namespace {

TEST(ZeroPages, NewVectorsAreZeroWhateverTheirSize) {
    for (const std::size_t count : {std::size_t(0), std::size_t(1), std::size_t(1000), std::size_t(1) << 18,
                                    (std::size_t(1) << 19) + 7, std::size_t(5) << 20}) {
        // Twice: the second may get the memory of the first.
        for (int lap = 0; lap < 2; ++lap) {
            ZeroPageVector<std::uint32_t> values(count);
            EXPECT_EQ(std::size_t(std::count(values.begin(), values.end(), 0u)), count);
            std::fill(values.begin(), values.end(), 7u);
        }
    }
}

TEST(ZeroPages, GrowingKeepsWhatThereWas) {
    ZeroPageVector<std::uint16_t> values(3, std::uint16_t(9));
    values.resize(2'000'000);
    EXPECT_EQ(std::count(values.begin(), values.end(), 9), 3);
    EXPECT_EQ(std::count(values.begin(), values.end(), 0), 1'999'997);
    const ZeroPageVector<std::uint16_t> copy = values;
    EXPECT_EQ(copy, values);
}

}  // namespace
}  // namespace ff
