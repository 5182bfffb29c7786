// The shading pass against its scalar reference, and the promises that it makes to the frame.

#include <gtest/gtest.h>
#include <hwy/targets.h>

#include <cmath>
#include <cstring>
#include <glm/geometric.hpp>
#include <limits>

#include "engine/core/jobs.h"
#include "engine/shading/shade_reference.h"
#include "engine/shading/shading_model.h"
#include "tests/shading/shading_worlds.h"

namespace ff::test {
namespace {

using farfield::VisibilityBuffer;
using shading::Image;
using shading::ShadeSettings;

constexpr int kWidth = 200, kHeight = 150;  // not whole tiles

int channel(std::uint32_t pixel, int k) {
    return int(pixel >> 8 * k & 255u);
}

struct Difference {
    int compared = 0;
    int large = 0;      ///< pixels over 2/255
    int at_border = 0;  ///< pixels left out: so near the border of two mip levels that either is right
    double max = 0.0;   ///< of 255, over the compared
};

/// A pixel's lod must be this far from a half for both to choose the same level.
constexpr double kLodMargin = 0.01;

Difference compare_with_reference(const scene::StaticScene& scene, const PinholeView& view,
                                  const VisibilityBuffer& visibility, const Image& image,
                                  const ShadeSettings& settings = {}, std::span<const scene::Instance> dynamic = {}) {
    Difference difference;
    for (int y = 0; y < view.height; ++y)
        for (int x = 0; x < view.width; ++x) {
            const std::size_t i = visibility.index(x, y);
            const double lod =
                shading::reference_lod(scene, dynamic, view, x, y, visibility.instance[i], visibility.triangle[i]);
            if (std::isfinite(lod) && std::abs(lod - std::floor(lod) - 0.5) < kLodMargin) {
                ++difference.at_border;
                continue;
            }
            const Vec3 expected = shading::shade_reference(scene, dynamic, view, x, y, visibility.instance[i],
                                                           visibility.triangle[i], visibility.depth[i], settings);
            double worst = 0.0;
            for (int k = 0; k < 3; ++k)
                worst = std::max(worst, std::abs(channel(image.pixels[i], k) - 255.0 * double(expected[k])));
            ++difference.compared;
            difference.large += worst > 2.0;
            difference.max = std::max(difference.max, worst);
        }
    return difference;
}

PinholeView random_view(Random& random, const DBox3& box) {
    return make_view(random_camera(random, box), kWidth, kHeight);
}

TEST(shading, the_fast_pass_equals_the_scalar_reference_in_random_worlds) {
    int compared = 0, large = 0;
    double max = 0.0;
    for (std::uint32_t seed = 0; seed < 12; ++seed) {
        SCOPED_TRACE(seed);
        scene::SceneData world = make_material_world(seed, seed % 2 == 0 ? WorldPos(0.0) : WorldPos(4e5, 100, -3e5));
        const scene::StaticScene scene = world.view();
        Random random(1000 + seed);
        for (int i = 0; i < 3; ++i) {
            const PinholeView view = random_view(random, scene.bounds);
            const VisibilityBuffer visibility = cast_view(scene, view);
            const Difference d = compare_with_reference(scene, view, visibility, shade_view(scene, view, visibility));
            compared += d.compared;
            large += d.large;
            max = std::max(max, d.max);
        }
    }
    RecordProperty("max_of_255", std::to_string(max));
    printf("compared %d large %d max %g\n", compared, large, max);
    EXPECT_GT(compared, 500000);
    EXPECT_LE(large, compared / 10000);  // slivers seen edge on
}

}  // namespace
}  // namespace ff::test
