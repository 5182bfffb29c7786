#include "tools/accuracy/image_errors.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "tests/accuracy/images.h"

namespace ff::accuracy {
namespace {

TEST(SsimTest, is_one_for_equal_images_and_less_for_all_others) {
    const shading::Image a = test::random_image(64, 48, 5);
    EXPECT_NEAR(structural_similarity(a, a), 1.0, 1e-9);
    EXPECT_LT(structural_similarity(a, test::random_image(64, 48, 6)), 0.9);
}

TEST(SsimTest, of_plain_images_is_the_luminance_term_alone) {
    const double a = 100, b = 150, c1 = 0.01 * 255 * 0.01 * 255;
    const double expected = (2 * a * b + c1) / (a * a + b * b + c1);
    EXPECT_NEAR(structural_similarity(test::plain_image(32, 32, 0xFF646464u), test::plain_image(32, 32, 0xFF969696u)),
                expected, 1e-4);
}

TEST(FlickerTest, counts_only_changes_that_the_reference_does_not_make) {
    const shading::Image dark = test::plain_image(32, 16, 0xFF101010u), light = test::plain_image(32, 16, 0xFF1A1A1Au);
    EXPECT_EQ(flicker(dark, light, dark, light), 0.0);
    EXPECT_DOUBLE_EQ(flicker(dark, light, dark, dark), 10.0);
    // An error that stays is none that flickers.
    EXPECT_EQ(flicker(light, light, dark, dark), 0.0);
}

farfield::VisibilityBuffer visibility(int width, int height) {
    farfield::VisibilityBuffer buffer;
    buffer.resize(width, height);
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            buffer.instance[buffer.index(x, y)] = 0;
            buffer.triangle[buffer.index(x, y)] = std::uint32_t(x / 4);
            buffer.depth[buffer.index(x, y)] = 10.0f + float(x / 4);
        }
    return buffer;
}

TEST(VisibilityErrorTest, measures_by_how_many_pixels_things_are_off) {
    const farfield::VisibilityBuffer exact = visibility(64, 32);
    EXPECT_EQ(compare_visibility(exact, exact).wrong_primitives, 0.0);
    EXPECT_EQ(compare_visibility(exact, exact).displacement_px, 0.0);
    for (const int shift : {1, 2, 3}) {
        farfield::VisibilityBuffer moved = exact;
        for (int y = 0; y < 32; ++y)
            for (int x = 0; x < 64; ++x) {
                const std::size_t from = exact.index(std::min(x + shift, 63), y), to = exact.index(x, y);
                moved.triangle[to] = exact.triangle[from];
                moved.depth[to] = exact.depth[from];
            }
        const VisibilityError error = compare_visibility(moved, exact);
        EXPECT_NEAR(error.wrong_primitives, 15.0 * shift / 64.0, 1e-9);
        EXPECT_EQ(error.displacement_px, shift);
    }
}

TEST(VisibilityErrorTest, coincident_surfaces_are_not_wrong_and_what_is_nowhere_is_far_off) {
    const farfield::VisibilityBuffer exact = visibility(64, 32);
    farfield::VisibilityBuffer other = exact;
    for (std::uint32_t& t : other.triangle) t += 1000;  // at the same depths
    EXPECT_EQ(compare_visibility(other, exact).wrong_primitives, 0.0);
    for (float& d : other.depth) d *= 1.01f;
    EXPECT_EQ(compare_visibility(other, exact).wrong_primitives, 1.0);
    EXPECT_EQ(compare_visibility(other, exact).displacement_px, kFarPx);
}

TEST(VisibilityErrorTest, sky_is_sky) {
    farfield::VisibilityBuffer a = visibility(16, 16), b = a;
    for (farfield::VisibilityBuffer* buffer : {&a, &b})
        for (std::size_t i = 0; i < buffer->depth.size(); ++i) {
            buffer->instance[i] = farfield::kSkyInstance;
            buffer->depth[i] = std::numeric_limits<float>::infinity();
        }
    b.triangle[3] = 77;
    EXPECT_EQ(compare_visibility(a, b).wrong_primitives, 0.0);
}

}  // namespace
}  // namespace ff::accuracy
