#pragma once

#include "engine/shading/shading_pass.h"
#include "tests/support/worlds.h"

namespace ff::test {

/// An image of random colours, with a plain part in which differences are seen best.
inline shading::Image random_image(int width, int height, std::uint32_t seed) {
    Random random(seed);
    shading::Image image;
    image.resize(width, height);
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x)
            image.pixels[std::size_t(y) * std::size_t(image.stride) + std::size_t(x)] =
                x < width / 2 ? 0xFF306090u : 0xFF000000u | random.below(1u << 24);
    return image;
}

inline shading::Image plain_image(int width, int height, std::uint32_t pixel) {
    shading::Image image;
    image.resize(width, height);
    for (std::uint32_t& p : image.pixels) p = pixel;
    return image;
}

}  // namespace ff::test
