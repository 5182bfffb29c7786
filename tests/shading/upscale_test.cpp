#include "engine/shading/upscale.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace ff::shading {
namespace {

std::uint32_t& pixel(Image& image, int x, int y) {
    return image.pixels[std::size_t(y) * std::size_t(image.stride) + std::size_t(x)];
}

Image make_noise(int width, int height) {
    std::mt19937 random(3);
    Image image;
    image.resize(width, height);
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) pixel(image, x, y) = std::uint32_t(random()) | 0xFF000000u;
    return image;
}

/// Bilinear in double, centres aligned, borders repeated.
double reference(Image& from, double x, double y, int shift) {
    const auto at = [&](int column, int row) {
        column = std::clamp(column, 0, from.width - 1);
        row = std::clamp(row, 0, from.height - 1);
        return double(pixel(from, column, row) >> shift & 255u);
    };
    const double fx = std::floor(x), fy = std::floor(y), wx = x - fx, wy = y - fy;
    const int c = int(fx), r = int(fy);
    return (at(c, r) * (1 - wx) + at(c + 1, r) * wx) * (1 - wy) +
           (at(c, r + 1) * (1 - wx) + at(c + 1, r + 1) * wx) * wy;
}

TEST(Upscale, is_bilinear_within_rounding_for_any_two_sizes) {
    const int sizes[][4] = {{5, 7, 16, 31}, {1, 1, 20, 3}, {1, 9, 33, 10}, {40, 30, 57, 43}, {12, 12, 12, 12}};
    Upscaler upscaler;
    for (const auto& [from_width, from_height, width, height] : sizes) {
        Image from = make_noise(from_width, from_height), to;
        to.resize(width, height);
        upscaler.run(from, to);
        for (int y = 0; y < height; ++y)
            for (int x = 0; x < width; ++x)
                for (int shift = 0; shift < 32; shift += 8) {
                    const double sx = (x + 0.5) * from_width / width - 0.5, sy = (y + 0.5) * from_height / height - 0.5;
                    // Weights are rounded to 1/256 along both sides, values twice.
                    EXPECT_NEAR(double(pixel(to, x, y) >> shift & 255u), reference(from, sx, sy, shift), 2.2)
                        << from_width << "x" << from_height << " to " << width << "x" << height << " at " << x << ", "
                        << y;
                }
    }
}

TEST(Upscale, to_the_same_size_copies) {
    const Image from = make_noise(37, 21);
    Image to;
    to.resize(37, 21);
    Upscaler().run(from, to);
    EXPECT_EQ(to.pixels, from.pixels);
}

}  // namespace
}  // namespace ff::shading
