// FLIP against a plain one: two-dimensional kernels, in double, as the paper writes them.

#include "tools/accuracy/flip.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <functional>
#include <numbers>

#include "tests/accuracy/images.h"

namespace ff::accuracy {
namespace {

using Color = std::array<double, 3>;
using Kernel = std::vector<std::vector<double>>;

constexpr double kPi = std::numbers::pi;

Color to_linear(std::uint32_t pixel) {
    Color c;
    for (int i = 0; i < 3; ++i) {
        const double v = double(pixel >> 8 * i & 255u) / 255.0;
        c[std::size_t(i)] = v <= 0.04045 ? v / 12.92 : std::pow((v + 0.055) / 1.055, 2.4);
    }
    return c;
}

/// sRGB's matrix, exactly, from its primaries' and white point's XYZ (as FLIP's authors write it).
Color xyz_of(const Color& c) {
    const double r = c[0], g = c[1], b = c[2];
    return {10135552.0 / 24577794 * r + 8788810.0 / 24577794 * g + 4435075.0 / 24577794 * b,
            2613072.0 / 12288897 * r + 8788810.0 / 12288897 * g + 887015.0 / 12288897 * b,
            1425312.0 / 73733382 * r + 8788810.0 / 73733382 * g + 70074185.0 / 73733382 * b};
}

Color linear_of_xyz(const Color& x) {
    // Solved by Cramer's rule from xyz_of.
    const Color m[3] = {xyz_of({1, 0, 0}), xyz_of({0, 1, 0}), xyz_of({0, 0, 1})};
    const auto det = [](const Color& a, const Color& b, const Color& c) {
        return a[0] * (b[1] * c[2] - b[2] * c[1]) - b[0] * (a[1] * c[2] - a[2] * c[1]) +
               c[0] * (a[1] * b[2] - a[2] * b[1]);
    };
    const double d = det(m[0], m[1], m[2]);
    return {det(x, m[1], m[2]) / d, det(m[0], x, m[2]) / d, det(m[0], m[1], x) / d};
}

const Color kWhite = xyz_of({1, 1, 1});

Color lab_of(const Color& linear) {
    const Color xyz = xyz_of(linear);
    const auto f = [](double t) {
        const double delta = 6.0 / 29.0;
        return t > delta * delta * delta ? std::cbrt(t) : t / (3 * delta * delta) + 4.0 / 29.0;
    };
    const double x = f(xyz[0] / kWhite[0]), y = f(xyz[1] / kWhite[1]), z = f(xyz[2] / kWhite[2]);
    const double l = 116 * y - 16;
    return {l, 0.01 * l * 500 * (x - y), 0.01 * l * 200 * (y - z)};
}

double hyab(const Color& p, const Color& q) {
    return std::abs(p[0] - q[0]) + std::hypot(p[1] - q[1], p[2] - q[2]);
}

Kernel make_kernel(int radius, const std::function<double(double, double)>& f) {
    Kernel kernel;
    for (int y = -radius; y <= radius; ++y) {
        kernel.emplace_back();
        for (int x = -radius; x <= radius; ++x) kernel.back().push_back(f(x, y));
    }
    return kernel;
}

/// Positive taps to sum 1, negative ones to sum -1.
void balance(Kernel& kernel) {
    double positive = 0, negative = 0;
    for (auto& row : kernel)
        for (const double tap : row) (tap > 0 ? positive : negative) += tap;
    for (auto& row : kernel)
        for (double& tap : row) tap /= tap > 0 ? positive : negative < 0 ? -negative : 1;
}

double plain_flip(const shading::Image& reference, const shading::Image& test) {
    const int w = test.width, h = test.height;
    const double ppd = kPixelsPerDegree;
    const int radius = int(std::ceil(3 * std::sqrt(0.04 / (2 * kPi * kPi)) * ppd));
    const auto sensitivity = [&](double a1, double b1, double a2, double b2) {
        Kernel k = make_kernel(radius, [&](double x, double y) {
            const double r2 = (x * x + y * y) / (ppd * ppd);
            return a1 * std::sqrt(kPi / b1) * std::exp(-kPi * kPi * r2 / b1) +
                   a2 * std::sqrt(kPi / b2) * std::exp(-kPi * kPi * r2 / b2);
        });
        balance(k);
        return k;
    };
    const Kernel csf[3] = {sensitivity(1, 0.0047, 0, 1e-5), sensitivity(1, 0.0053, 0, 1e-5),
                           sensitivity(34.1, 0.04, 13.5, 0.025)};
    const double s = 0.5 * 0.082 * ppd;
    const int fr = int(std::ceil(3 * s));
    const auto gauss = [&](double x, double y) { return std::exp(-(x * x + y * y) / (2 * s * s)); };
    Kernel features[4] = {make_kernel(fr, [&](double x, double y) { return -x * gauss(x, y); }),
                          make_kernel(fr, [&](double x, double y) { return -y * gauss(x, y); }),
                          make_kernel(fr, [&](double x, double y) { return (x * x / (s * s) - 1) * gauss(x, y); }),
                          make_kernel(fr, [&](double x, double y) { return (y * y / (s * s) - 1) * gauss(x, y); })};
    for (Kernel& k : features) balance(k);

    const auto opponent = [&](const shading::Image& image, int x, int y) {
        x = std::clamp(x, 0, w - 1);
        y = std::clamp(y, 0, h - 1);
        const Color xyz = xyz_of(to_linear(image.pixels[std::size_t(y * image.stride + x)]));
        const double X = xyz[0] / kWhite[0], Y = xyz[1] / kWhite[1], Z = xyz[2] / kWhite[2];
        return Color{116 * Y - 16, 500 * (X - Y), 200 * (Y - Z)};
    };
    const auto convolve = [&](const shading::Image& image, const Kernel& kernel, int x, int y, std::size_t channel) {
        const int r = int(kernel.size()) / 2;
        double sum = 0;
        for (int j = -r; j <= r; ++j)
            for (int i = -r; i <= r; ++i) {
                const double v = opponent(image, x + i, y + j)[channel];
                sum += kernel[std::size_t(j + r)][std::size_t(i + r)] * v;
            }
        return sum;
    };
    const auto seen = [&](const shading::Image& image, int x, int y) {
        const Color o = {convolve(image, csf[0], x, y, 0), convolve(image, csf[1], x, y, 1),
                         convolve(image, csf[2], x, y, 2)};
        const double Y = (o[0] + 16) / 116;
        Color linear = linear_of_xyz({(Y + o[1] / 500) * kWhite[0], Y * kWhite[1], (Y - o[2] / 200) * kWhite[2]});
        for (double& v : linear) v = std::clamp(v, 0.0, 1.0);
        return lab_of(linear);
    };
    const double most = std::pow(hyab(lab_of({0, 1, 0}), lab_of({0, 0, 1})), 0.7);
    double total = 0;
    for (int y = 0; y < h; ++y)
        for (int x = 0; x < w; ++x) {
            double color = std::pow(hyab(seen(reference, x, y), seen(test, x, y)), 0.7);
            const double limit = 0.4 * most;
            color = color < limit ? 0.95 / limit * color : 0.95 + (color - limit) / (most - limit) * 0.05;
            double norms[2][2];
            for (int i = 0; i < 2; ++i) {
                const shading::Image& image = i == 0 ? reference : test;
                const auto f = [&](int k) { return convolve(image, features[k], x, y, 0) / 116; };
                norms[i][0] = std::hypot(f(0), f(1));
                norms[i][1] = std::hypot(f(2), f(3));
            }
            const double feature = std::sqrt(
                std::max(std::abs(norms[0][0] - norms[1][0]), std::abs(norms[0][1] - norms[1][1])) / std::sqrt(2.0));
            total += std::pow(color, 1 - feature);
        }
    return total / (w * h);
}

TEST(FlipTest, agrees_with_the_plain_one) {
    for (const std::uint32_t seed : {1u, 2u}) {
        const shading::Image a = test::random_image(30, 22, seed);
        shading::Image b = a;
        for (std::size_t i = 0; i < b.pixels.size(); i += 7) b.pixels[i] ^= 0x00284018u;
        Flip flip;
        EXPECT_NEAR(flip.compare(a, b), plain_flip(a, b), 2e-4) << "seed " << seed;
    }
}

TEST(FlipTest, equal_images_have_no_error_and_opposite_ones_nearly_all) {
    Flip flip;
    const shading::Image a = test::random_image(40, 30, 3);
    EXPECT_EQ(flip.compare(a, a), 0.0);
    const double most = flip.compare(test::plain_image(40, 30, 0xFF000000u), test::plain_image(40, 30, 0xFFFFFFFFu));
    EXPECT_GT(most, 0.9);
    EXPECT_LE(most, 1.0);
}

TEST(FlipTest, its_map_shows_where) {
    const shading::Image a = test::plain_image(80, 60, 0xFF808080u);
    shading::Image b = a;
    for (int y = 20; y < 24; ++y)
        for (int x = 60; x < 64; ++x) b.pixels[std::size_t(y * b.stride + x)] = 0xFFFFFFFFu;
    Flip flip;
    EXPECT_GT(flip.compare(a, b), 0.0);
    EXPECT_GT(flip.map().row(22)[62], 0.1f);
    EXPECT_EQ(flip.map().row(22)[10], 0.0f);
}

}  // namespace
}  // namespace ff::accuracy
