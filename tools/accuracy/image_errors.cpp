#include "tools/accuracy/image_errors.h"

#include <algorithm>
#include <cmath>

#include "engine/core/check.h"
#include "engine/farfield/visibility_difference.h"

namespace ff::accuracy {
namespace {

void check_sizes(const shading::Image& a, const shading::Image& b) {
    FF_CHECK(a.width == b.width && a.height == b.height && a.width > 0 && a.height > 0,
             "images of {}x{} and {}x{} pixels", a.width, a.height, b.width, b.height);
}

/// Luma of Rec. 601, 0..255.
Plane luma_of(const shading::Image& image) {
    Plane luma;
    luma.resize(image.width, image.height);
    for (int y = 0; y < image.height; ++y) {
        const std::uint32_t* pixels = image.pixels.data() + std::size_t(y) * std::size_t(image.stride);
        for (int x = 0; x < image.width; ++x)
            luma.row(y)[x] = 0.299f * float(pixels[x] & 255u) + 0.587f * float(pixels[x] >> 8 & 255u) +
                             0.114f * float(pixels[x] >> 16 & 255u);
    }
    return luma;
}

Plane product(const Plane& a, const Plane& b) {
    Plane result = a;
    for (std::size_t i = 0; i < result.values.size(); ++i) result.values[i] *= b.values[i];
    return result;
}

}  // namespace

double structural_similarity(const shading::Image& a, const shading::Image& b) {
    check_sizes(a, b);
    constexpr double kC1 = 0.01 * 255 * 0.01 * 255, kC2 = 0.03 * 255 * 0.03 * 255;
    const std::vector<float> window = gaussian_taps(1.5, 5);
    const Plane luma_a = luma_of(a), luma_b = luma_of(b);
    Plane scratch, mean_a, mean_b, square_a, square_b, mixed;
    filter(luma_a, window, window, scratch, mean_a);
    filter(luma_b, window, window, scratch, mean_b);
    filter(product(luma_a, luma_a), window, window, scratch, square_a);
    filter(product(luma_b, luma_b), window, window, scratch, square_b);
    filter(product(luma_a, luma_b), window, window, scratch, mixed);
    double sum = 0.0;
    for (std::size_t i = 0; i < mean_a.values.size(); ++i) {
        const double ma = mean_a.values[i], mb = mean_b.values[i];
        const double va = square_a.values[i] - ma * ma, vb = square_b.values[i] - mb * mb;
        const double covariance = mixed.values[i] - ma * mb;
        sum += (2 * ma * mb + kC1) * (2 * covariance + kC2) / ((ma * ma + mb * mb + kC1) * (va + vb + kC2));
    }
    return sum / double(mean_a.values.size());
}

double flicker(const shading::Image& before, const shading::Image& test, const shading::Image& reference_before,
               const shading::Image& reference) {
    check_sizes(before, test);
    check_sizes(test, reference);
    check_sizes(reference_before, reference);
    std::uint64_t squares = 0;
    for (int y = 0; y < test.height; ++y) {
        const auto row = [&](const shading::Image& image) {
            return image.pixels.data() + std::size_t(y) * std::size_t(image.stride);
        };
        const std::uint32_t *t = row(test), *t0 = row(before), *r = row(reference), *r0 = row(reference_before);
        for (int x = 0; x < test.width; ++x)
            for (int shift = 0; shift < 24; shift += 8) {
                const auto level = [shift](std::uint32_t pixel) { return int(pixel >> shift & 255u); };
                const int change = (level(t[x]) - level(t0[x])) - (level(r[x]) - level(r0[x]));
                squares += std::uint64_t(change * change);
            }
    }
    return std::sqrt(double(squares) / (3.0 * double(test.width) * double(test.height)));
}

VisibilityError compare_visibility(const farfield::VisibilityBuffer& test, const farfield::VisibilityBuffer& exact) {
    FF_CHECK(test.width == exact.width && test.height == exact.height, "visibility of {}x{} and {}x{} pixels",
             test.width, test.height, exact.width, exact.height);
    std::uint64_t histogram[kFarPx + 1] = {};
    std::uint64_t wrong = 0;
    for (int y = 0; y < test.height; ++y)
        for (int x = 0; x < test.width; ++x) {
            const std::size_t here = test.index(x, y);
            const auto shows_it = [&](std::size_t there) {
                return exact.instance[there] == test.instance[here] &&
                       (test.instance[here] == farfield::kSkyInstance || exact.triangle[there] == test.triangle[here]);
            };
            if (!farfield::is_wrong_pixel(test, exact, here)) {
                ++histogram[0];
                continue;
            }
            ++wrong;
            // Rings of growing radius, by the larger coordinate.
            int found = kFarPx;
            for (int r = 1; r < kFarPx && found == kFarPx; ++r)
                for (int dy = -r; dy <= r && found == kFarPx; ++dy) {
                    const int step = std::abs(dy) == r ? 1 : 2 * r;
                    for (int dx = -r; dx <= r; dx += step) {
                        const int nx = x + dx, ny = y + dy;
                        if (nx < 0 || ny < 0 || nx >= test.width || ny >= test.height) continue;
                        if (shows_it(exact.index(nx, ny))) found = r;
                    }
                }
            ++histogram[found];
        }
    const auto pixels = std::uint64_t(test.width) * std::uint64_t(test.height);
    VisibilityError error{.wrong_primitives = double(wrong) / double(pixels)};
    const auto rank = std::uint64_t(std::ceil(0.99 * double(pixels)));
    std::uint64_t below = histogram[0];
    for (int r = 1; r <= kFarPx && below < rank; ++r) {
        below += histogram[r];
        error.displacement_px = r;
    }
    return error;
}

}  // namespace ff::accuracy
