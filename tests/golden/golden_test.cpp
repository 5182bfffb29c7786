#include <gtest/gtest.h>

#include "tests/gl/gl_fixture.h"
#include "tests/golden/golden_compare.h"
#include "tests/golden/golden_shots.h"
#include "tools/picture/picture_file.h"

namespace ff::test {
namespace {

using GoldenTest = GlTest;

TEST_F(GoldenTest, every_mode_draws_the_town_as_it_was) {
    auto studio = GoldenStudio::open();
    ASSERT_TRUE(studio) << studio.error().message;
    for (const GoldenShot& shot : golden_shots()) {
        const auto golden = read_golden(shot.name);
        ASSERT_TRUE(golden) << golden.error().message;
        const shading::Image image = (*studio)->draw(shot);
        const shading::ImageDifference difference = golden_difference(image, *golden);
        if (is_within_tolerance(difference)) continue;
        const auto folder = std::filesystem::path(testing::TempDir());
        const auto actual = folder / (shot.name + ".actual.png"), shown = folder / (shot.name + ".difference.png");
        EXPECT_TRUE(tool::write_image(actual, image));
        EXPECT_TRUE(tool::write_image(shown, difference_image(image, *golden)));
        ADD_FAILURE() << shot.name << ": " << difference.psnr_db << " dB, " << 100.0 * difference.wrong_pixels
                      << " % of pixels off by more than " << kGoldenLevels << " levels; see " << actual << " and "
                      << shown << ", and tests/golden/README.md";
    }
}

TEST_F(GoldenTest, a_sun_that_moves_by_5_degrees_is_out_of_tolerance_in_every_mode) {
    auto studio = GoldenStudio::open(radians_of(5.0));
    ASSERT_TRUE(studio) << studio.error().message;
    for (const GoldenShot& shot : golden_shots()) {
        const auto golden = read_golden(shot.name);
        ASSERT_TRUE(golden) << golden.error().message;
        const shading::ImageDifference difference = golden_difference((*studio)->draw(shot), *golden);
        EXPECT_FALSE(is_within_tolerance(difference))
            << shot.name << ": " << difference.psnr_db << " dB, " << 100.0 * difference.wrong_pixels << " %";
    }
}

}  // namespace
}  // namespace ff::test
