#include "engine/shading/image_difference.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "engine/core/check.h"

namespace ff::shading {

ImageDifference compare_images(const Image& a, const Image& b, int tolerated_levels) {
    FF_CHECK(a.width == b.width && a.height == b.height, "images of {}x{} and {}x{} pixels", a.width, a.height, b.width,
             b.height);
    constexpr double kEqualDb = 99.0;
    std::uint64_t squares = 0, wrong = 0;
    for (int y = 0; y < a.height; ++y) {
        const std::uint32_t* row_a = a.pixels.data() + std::size_t(y) * std::size_t(a.stride);
        const std::uint32_t* row_b = b.pixels.data() + std::size_t(y) * std::size_t(b.stride);
        for (int x = 0; x < a.width; ++x) {
            int worst = 0;
            for (int shift = 0; shift < 24; shift += 8) {
                const int d = int((row_a[x] >> shift) & 255u) - int((row_b[x] >> shift) & 255u);
                squares += std::uint64_t(d * d);
                worst = std::max(worst, std::abs(d));
            }
            wrong += worst > tolerated_levels;
        }
    }
    const double pixels = double(a.width) * double(a.height);
    const double mean_square = double(squares) / (3.0 * pixels);
    return {.psnr_db = squares > 0 ? std::min(kEqualDb, 10.0 * std::log10(255.0 * 255.0 / mean_square)) : kEqualDb,
            .wrong_pixels = double(wrong) / pixels};
}

}  // namespace ff::shading
