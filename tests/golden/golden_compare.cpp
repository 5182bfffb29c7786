#include "tests/golden/golden_compare.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "tests/golden/golden_shots.h"
#include "tools/picture/picture_file.h"

namespace ff::test {
namespace {

int channel(std::uint32_t pixel, int shift) {
    return int((pixel >> shift) & 255u);
}

std::uint32_t pixel_of(const shading::Image& image, int x, int y) {
    return image.pixels[std::size_t(y) * std::size_t(image.stride) + std::size_t(x)];
}

}  // namespace

shading::Image difference_image(const shading::Image& a, const shading::Image& b) {
    shading::Image out;
    out.resize(a.width, a.height);
    for (int y = 0; y < a.height; ++y)
        for (int x = 0; x < a.width; ++x) {
            std::uint32_t pixel = 0xFF000000u;
            for (int shift = 0; shift < 24; shift += 8) {
                const int d = std::abs(channel(pixel_of(a, x, y), shift) - channel(pixel_of(b, x, y), shift));
                pixel |= std::uint32_t(std::min(8 * d, 255)) << shift;
            }
            out.pixels[std::size_t(y) * std::size_t(out.stride) + std::size_t(x)] = pixel;
        }
    return out;
}

std::filesystem::path golden_path(const std::string& name) {
    return std::filesystem::path(FF_GOLDEN_DIR) / (name + ".png");
}

Result<shading::Image> read_golden(const std::string& name) {
    const auto path = golden_path(name);
    FF_ASSIGN(shading::Image image, tool::read_image(path));
    if (image.width != kGoldenWidth || image.height != kGoldenHeight)
        return bad_input(fmt::format("{}: {}x{} pixels; expected {}x{}", path.string(), image.width, image.height,
                                     kGoldenWidth, kGoldenHeight));
    return image;
}

}  // namespace ff::test
