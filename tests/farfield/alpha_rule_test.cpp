// The rule of farfield/alpha_test.h over distance: what a masked texture covers must not change with it.

#include <gtest/gtest.h>

#include <array>

#include "engine/farfield/alpha_test.h"
#include "engine/scene/texture_mips.h"
#include "tests/support/worlds.h"

namespace ff::farfield {
namespace {

/// A texture of leaves: discs of a twelfth of its side at random places, about `coverage` of it.
scene::Texture append_leaves(std::uint32_t size, double coverage, std::vector<std::uint32_t>& texels) {
    std::vector<std::uint32_t> rgba(std::size_t(size) * size, 0x00408040u);
    test::Random random(5);
    const auto goal = std::size_t(coverage * double(rgba.size()));
    for (std::size_t covered = 0; covered < goal;) {
        const double cx = random.in(0.0, size), cy = random.in(0.0, size), radius = size / 12.0;
        for (std::uint32_t y = 0; y < size; ++y)
            for (std::uint32_t x = 0; x < size; ++x) {
                std::uint32_t& texel = rgba[std::size_t(y) * size + x];
                if ((x - cx) * (x - cx) + (y - cy) * (y - cy) > radius * radius || texel >> 24 != 0) continue;
                texel |= 0xFF000000u;
                ++covered;
            }
    }
    return scene::append_mip_chain(rgba, size, size, texels);
}

TEST(AlphaRule, masked_leaves_cover_as_much_at_any_distance) {
    for (const double coverage : {0.2, 0.35, 0.6}) {
        std::vector<std::uint32_t> texels;
        const scene::Texture texture = append_leaves(128, coverage, texels);
        AlphaSurface surface;
        surface.uv[0] = {0, 0};
        surface.uv[1] = {1, 0};
        surface.uv[2] = {0, 1};
        surface.cutoff = 0.5f;
        surface.texels_per_m = 128.0f;
        surface.texture = &texture;
        surface.last_level = last_alpha_level(texture);
        surface.texels = texels.data();
        surface.is_see_through = true;
        for (const float footprint_m : {0.0f, 0.03f, 0.1f, 0.3f, 1.0f, 10.0f, 1e4f}) {
            test::Random random(7);
            int opaque = 0;
            constexpr int kPoints = 20000;
            for (int i = 0; i < kPoints; ++i)
                opaque += is_opaque_at(surface, float(random.in(0.0, 1.0)), float(random.in(0.0, 1.0)), footprint_m);
            EXPECT_NEAR(double(opaque) / kPoints, coverage, 0.04)
                << "coverage " << coverage << " seen with " << footprint_m << " m under a pixel";
        }
    }
}

TEST(AlphaRule, the_last_level_has_64_texels_or_is_the_first) {
    const auto last = [](std::uint32_t width, std::uint32_t height) {
        scene::Texture texture;
        texture.width = width;
        texture.height = height;
        return last_alpha_level(texture);
    };
    EXPECT_EQ(last(8, 8), 0u);
    EXPECT_EQ(last(16, 16), 1u);
    EXPECT_EQ(last(512, 512), 6u);
    EXPECT_EQ(last(1, 1), 0u);
    EXPECT_EQ(last(4, 2), 0u);
    EXPECT_EQ(last(256, 4), 2u);
    EXPECT_EQ(last(8192, 8192), 10u);
}

}  // namespace
}  // namespace ff::farfield
