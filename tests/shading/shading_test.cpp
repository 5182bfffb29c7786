// The shading pass against its scalar reference, and the promises that it makes to the frame.

#include <gtest/gtest.h>
#include <hwy/highway.h>

#include <cmath>
#include <functional>
#include <glm/geometric.hpp>
#include <limits>
#include <vector>

#include "engine/core/jobs.h"
#include "engine/shading/reflections.h"
#include "engine/shading/shade_reference.h"
#include "engine/shading/shading_model.h"
#include "tests/shading/shading_worlds.h"
#include "tests/support/wind.h"

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

/// Images of one shot with every vector width that this machine has.
std::vector<Image> images_of_all_targets(const std::function<Image()>& draw) {
    std::vector<Image> images;
    const std::int64_t supported = hwy::SupportedTargets();
    for (const std::int64_t target : {HWY_SSSE3, HWY_SSE4, HWY_AVX2, HWY_AVX3, HWY_AVX3_DL}) {
        if ((supported & target) == 0) continue;
        hwy::SetSupportedTargetsForTest(target);
        images.push_back(draw());
    }
    hwy::SetSupportedTargetsForTest(0);
    return images;
}

int largest_difference(const Image& a, const Image& b) {
    int largest = 0;
    for (int y = 0; y < a.height; ++y)
        for (int x = 0; x < a.width; ++x) {
            const std::size_t i = std::size_t(y) * std::size_t(a.stride) + std::size_t(x);
            for (int k = 0; k < 3; ++k)
                largest = std::max(largest, std::abs(channel(a.pixels[i], k) - channel(b.pixels[i], k)));
        }
    return largest;
}

// Tolerance: 2/255 a channel, but for one pixel in 10,000 (slivers seen edge on, where float barycentrics are coarse)
// and pixels within 0.01 of the border between two mip levels.
TEST(shading, the_fast_pass_equals_the_scalar_reference_in_random_worlds) {
    int compared = 0, large = 0;
    for (std::uint32_t seed = 0; seed < 12; ++seed) {
        scene::SceneData world = make_material_world(seed, seed % 2 == 0 ? WorldPos(0.0) : WorldPos(4e5, 100, -3e5));
        const scene::StaticScene scene = world.view();
        Random random(1000 + seed);
        for (int i = 0; i < 3; ++i) {
            const PinholeView view = random_view(random, scene.bounds);
            const VisibilityBuffer visibility = cast_view(scene, view);
            const Difference d = compare_with_reference(scene, view, visibility, shade_view(scene, view, visibility));
            EXPECT_LE(d.large, 20) << "seed " << seed << " view " << i << ", max " << d.max;
            compared += d.compared;
            large += d.large;
        }
    }
    EXPECT_GT(compared, 500000);
    EXPECT_LE(large, compared / 10000);
}

TEST(shading, an_atmosphere_is_shaded_as_the_reference_says) {
    int compared = 0, large = 0;
    scene::SkyTable table;
    for (const float height : {0.9f, 0.3f, 0.0f, -0.2f}) {
        scene::SceneData world = make_material_world(3);
        world.environment.to_sun = Vec3(std::sqrt(1.0f - height * height), height, 0.0f);
        world.environment.atmosphere.turbidity = 3.0f;
        world.environment.fog_density_per_m = height > 0.5f ? 0.02f : 0.0f;  // else the world is too small for haze
        shading::light_atmosphere(world.environment, table);
        const scene::StaticScene scene = world.view();
        Random random(3000 + std::uint32_t(10.0f * (height + 1.0f)));
        for (int i = 0; i < 3; ++i) {
            const PinholeView view = random_view(random, scene.bounds);
            const VisibilityBuffer visibility = cast_view(scene, view);
            for (const Image& image : images_of_all_targets([&] { return shade_view(scene, view, visibility); })) {
                const Difference d = compare_with_reference(scene, view, visibility, image);
                EXPECT_LE(d.large, 20) << "height " << height << " view " << i << ", max " << d.max;
                compared += d.compared;
                large += d.large;
            }
        }
    }
    EXPECT_GT(compared, 500000);
    EXPECT_LE(large, compared / 10000);
}

/// Worlds in an atmosphere at several times of day, and in plain fog.
scene::SceneData make_airy_world(std::uint32_t seed, scene::SkyTable& table) {
    constexpr float kHeights[] = {0.9f, 0.3f, 0.02f, -0.2f};
    scene::SceneData world = make_material_world(seed);
    if (seed % 5 == 4) {
        world.environment.fog_density_per_m = 0.002f;
        return world;
    }
    const float height = kHeights[seed % 5];
    world.environment.to_sun = Vec3(std::sqrt(1.0f - height * height), height, 0.0f);
    world.environment.atmosphere.turbidity = seed % 2 == 0 ? 2.0f : 8.0f;
    world.environment.fog_density_per_m = 0.0005f;
    shading::light_atmosphere(world.environment, table);
    return world;
}

TEST(shading, air_is_left_out_only_where_it_does_not_show) {
    scene::SkyTable table;
    for (std::uint32_t seed = 0; seed < 4; ++seed) {
        scene::SceneData world = make_airy_world(seed, table);
        const scene::StaticScene scene = world.view();
        Random random(8000 + seed);
        const PinholeView view = random_view(random, scene.bounds);
        const VisibilityBuffer visibility = cast_view(scene, view);
        const Image exact = shade_view(scene, view, visibility);
        // A level of rounding beside what is allowed.
        for (const auto& [error, levels] : {std::pair{1.0f / 512.0f, 1}, {1.0f / 64.0f, 5}, {1.0f / 16.0f, 17}}) {
            const ShadeSettings settings{.air_error = error};
            for (const Image& image :
                 images_of_all_targets([&] { return shade_view(scene, view, visibility, settings); })) {
                // Vector widths differ by a level near mip levels' borders, with air or without.
                EXPECT_LE(largest_difference(image, exact), levels + 1) << "seed " << seed << " error " << error;
                const Difference d = compare_with_reference(scene, view, visibility, image, settings);
                EXPECT_LE(d.large, 20) << "seed " << seed << ", max " << d.max;
            }
            EXPECT_LE(largest_difference(shade_view(scene, view, visibility, settings), exact), levels)
                << "seed " << seed << " error " << error;
        }
        EXPECT_EQ(shade_view(scene, view, visibility, {.air_error = 0.0f}).pixels, exact.pixels);
    }
}

TEST(shading, no_encoding_is_steeper_over_the_root_of_light_than_its_bound) {
    for (const bool by_film : {false, true}) {
        double steepest = 0.0;
        constexpr int kSteps = 4000;
        const auto encoded = [&](double root) { return shading::encode_color(DVec3(root * root), by_film).x; };
        for (int i = 0; i < kSteps; ++i)
            steepest = std::max(steepest, kSteps * (encoded((i + 1.0) / kSteps) - encoded(double(i) / kSteps)));
        EXPECT_LE(steepest, double(shading::kEncodeSlope)) << by_film;
        EXPECT_GT(steepest, 0.9 * double(shading::kEncodeSlope)) << by_film;
    }
}

TEST(shading, what_stands_near_is_shaded_as_without_air_and_what_is_far_as_always) {
    scene::SkyTable table;
    for (const bool is_fog : {false, true}) {
        // Gray walls before the eye, straight ahead: at 20 m and at 2 km.
        for (const float distance_m : {20.0f, 2000.0f}) {
            const float side = 4.0f * distance_m;
            scene::SceneData world =
                make_single_triangle({-side, -side, -distance_m}, {side, -side, -distance_m}, {0, side, -distance_m});
            world.environment.fog_density_per_m = is_fog ? 1e-3f : 0.0f;
            if (!is_fog) {
                world.environment.to_sun = glm::normalize(Vec3(0.3f, 0.6f, 0.7f));
                world.environment.atmosphere.turbidity = 8.0f;
                shading::light_atmosphere(world.environment, table);
            }
            const PinholeView view = make_view({.vertical_fov = 0.5}, 48, 32);
            const VisibilityBuffer visibility = cast_view(world.view(), view);
            const Image exact = shade_view(world.view(), view, visibility);
            const Image image = shade_view(world.view(), view, visibility, {.air_error = 1.0f / 32.0f});
            ASSERT_EQ(visibility.instance[0], 0u);
            // The same light in air that takes and adds nothing.
            world.environment.fog_density_per_m = 0.0f;
            if (!is_fog) {
                table.rayleigh_per_m = table.mie_per_m = Vec3(0.0f);
            }
            const Image clear = shade_view(world.view(), view, visibility);
            if (distance_m < 100.0f) {
                EXPECT_EQ(image.pixels, clear.pixels) << is_fog;
                EXPECT_NE(exact.pixels, clear.pixels) << is_fog;
            } else {
                EXPECT_EQ(image.pixels, exact.pixels) << is_fog;
                EXPECT_GT(largest_difference(exact, clear), 20) << is_fog;
            }
        }
    }
}

TEST(shading, whoever_asks_for_a_pixel_decides_alike_about_its_air) {
    scene::SkyTable table;
    scene::SceneData world = make_airy_world(6, table);
    const scene::StaticScene scene = world.view();
    Random random(8100);
    const PinholeView view = random_view(random, scene.bounds);
    const VisibilityBuffer visibility = cast_view(scene, view);
    const ShadeSettings settings{.air_error = 1.0f / 32.0f};
    const Image whole = shade_view(scene, view, visibility, settings);
    Image parts;
    parts.resize(kWidth, kHeight);
    for (const std::uint16_t pattern : {std::uint16_t(0x1111), std::uint16_t(0xEEEE)}) {
        auto tiles = all_tiles(kWidth, kHeight);
        for (auto& tile : tiles)
            for (std::uint16_t& row : tile.rows) row = std::uint16_t(row & pattern);
        shading::shade_tiles(scene, {}, view, visibility, tiles, settings, parts);
    }
    EXPECT_EQ(largest_difference(whole, parts), 0);
}

TEST(shading, lamps_rain_and_snow_are_shaded_as_the_reference_says) {
    int compared = 0, large = 0, changed = 0;
    for (std::uint32_t seed = 0; seed < 6; ++seed) {
        scene::SceneData world = make_material_world(seed);
        world.environment.fog_density_per_m = 0.0f;
        const scene::StaticScene scene = world.view();
        Random random(4000 + seed);
        const PinholeView view = random_view(random, scene.bounds);
        const VisibilityBuffer visibility = cast_view(scene, view);
        std::vector<shading::LampLight> lamps;
        for (int i = 0; i < (seed % 3 == 0 ? 0 : 12); ++i)
            lamps.push_back({.position = random.in_box(Vec3(scene.bounds.low - view.position),
                                                       Vec3(scene.bounds.high - view.position)),
                             .radius_m = float(random.in(1.0, 12.0)),
                             .strength = random.in_box(Vec3(0.0f), Vec3(6.0f))});
        const ShadeSettings settings{.lamps = lamps,
                                     .wet = seed % 2 == 0 ? float(random.unit()) : 0.0f,
                                     .snow_cover = seed % 3 == 1 ? 0.0f : float(random.unit())};
        const Image dry = shade_view(scene, view, visibility);
        for (const Image& image :
             images_of_all_targets([&] { return shade_view(scene, view, visibility, settings); })) {
            changed += largest_difference(image, dry) > 5;
            const Difference d = compare_with_reference(scene, view, visibility, image, settings);
            EXPECT_LE(d.large, 40) << "seed " << seed << ", max " << d.max;
            compared += d.compared;
            large += d.large;
        }
    }
    EXPECT_GE(changed, 4) << "some views see nothing that faces up";
    EXPECT_GT(compared, 300000);
    EXPECT_LE(large, compared / 5000);
}

TEST(shading, leaves_in_the_wind_are_shaded_as_the_reference_says) {
    int compared = 0, large = 0, moved = 0;
    for (std::uint32_t seed = 0; seed < 4; ++seed) {
        scene::SceneData world = make_material_world(seed);
        for (scene::Material& material : world.materials) material.flags |= scene::kMaterialSways;
        const scene::StaticScene scene = world.view();
        Random random(7000 + seed);
        PinholeView view = random_view(random, scene.bounds);
        const VisibilityBuffer visibility = cast_view(scene, view);
        const Image still = shade_view(scene, view, visibility);
        view.sway = test::storm(float(seed));
        for (const Image& image : images_of_all_targets([&] { return shade_view(scene, view, visibility); })) {
            const Difference d = compare_with_reference(scene, view, visibility, image);
            EXPECT_LE(d.large, 60) << "seed " << seed << ", max " << d.max;
            compared += d.compared;
            large += d.large;
            moved += largest_difference(image, still) > 8;
        }
    }
    EXPECT_GT(compared, 200000);
    EXPECT_LE(large, compared / 2000);
    EXPECT_GT(moved, 4) << "else nothing moved";
}

TEST(shading, waves_are_shaded_as_the_reference_says) {
    int compared = 0, large = 0;
    scene::SkyTable table;
    for (std::uint32_t seed = 0; seed < 4; ++seed) {
        scene::SceneData world = make_material_world(seed);
        for (scene::Material& material : world.materials) {
            material.flags |= scene::kMaterialSpecular | scene::kMaterialWater;
            material.metallic_roughness_texture = scene::kNoTexture;
            material.roughness = 0.2f;
        }
        if (seed % 2 == 0) {
            world.environment.atmosphere.turbidity = 2.0f;
            shading::light_atmosphere(world.environment, table);
        }
        const scene::StaticScene scene = world.view();
        Random random(5000 + seed);
        const PinholeView view = random_view(random, scene.bounds);
        const VisibilityBuffer visibility = cast_view(scene, view);
        const shading::Waves waves = shading::make_waves(view.position, {.wind_m_s = {3.0f, 1.0f}}, 12.0 * seed);
        const ShadeSettings settings{.waves = &waves, .waves_within_m = seed < 2 ? 1e9f : 15.0f};
        for (const Image& image :
             images_of_all_targets([&] { return shade_view(scene, view, visibility, settings); })) {
            const Difference d = compare_with_reference(scene, view, visibility, image, settings);
            EXPECT_LE(d.large, 60) << "seed " << seed << ", max " << d.max;
            compared += d.compared;
            large += d.large;
        }
    }
    EXPECT_GT(compared, 200000);
    EXPECT_LE(large, compared / 2000);
}

TEST(shading, far_water_has_no_waves_but_is_as_rough_as_they_make_it) {
    scene::SceneData world = make_single_triangle({-900, -2, 100}, {900, -2, 100}, {0, -2, -900});
    world.materials[0].flags |= scene::kMaterialSpecular | scene::kMaterialWater;
    world.materials[0].roughness = 0.1f;
    world.materials[0].alpha_cutoff = 1.0f;  // its waves
    const PinholeView view = make_view({.pitch = -0.3}, kWidth, kHeight);
    const VisibilityBuffer visibility = cast_view(world.view(), view);
    const auto shade = [&](double time_s, float within_m) {
        const shading::Waves waves = shading::make_waves(view.position, {.wind_m_s = {6.0f, 1.0f}}, time_s);
        return shade_view(world.view(), view, visibility, {.waves = &waves, .waves_within_m = within_m});
    };
    const auto is_beyond = [&](std::size_t i, int x, int y, float within_m) {
        return visibility.depth[i] * glm::length(view.direction(x, y)) > within_m;
    };
    const Image now = shade(0.0, 20.0f), later = shade(1.7, 20.0f), everywhere = shade(0.0, 1e9f);
    const Image nowhere = shade(0.0, 0.0f), still = shade_view(world.view(), view, visibility);
    int far = 0, moved_near = 0, rough = 0;
    for (int y = 0; y < kHeight; ++y)
        for (int x = 0; x < kWidth; ++x) {
            const std::size_t i = visibility.index(x, y);
            if (visibility.instance[i] == farfield::kSkyInstance) continue;
            if (is_beyond(i, x, y, 20.01f)) {
                ++far;
                ASSERT_EQ(now.pixels[i], later.pixels[i]) << x << ' ' << y;
                ASSERT_EQ(now.pixels[i], nowhere.pixels[i]) << x << ' ' << y;
                rough += now.pixels[i] != still.pixels[i];
            } else {
                moved_near += now.pixels[i] != later.pixels[i];
            }
        }
    EXPECT_GT(far, 2000);
    EXPECT_GT(rough, far / 2);
    EXPECT_GT(moved_near, 500);
    EXPECT_GT(largest_difference(everywhere, now), 5);
}

TEST(shading, reflections_are_looked_up_as_the_reference_says) {
    int compared = 0, large = 0, shown = 0;
    for (std::uint32_t seed = 0; seed < 4; ++seed) {
        scene::SceneData world = make_material_world(seed);
        for (std::size_t i = 0; i < world.materials.size(); ++i) {
            scene::Material& material = world.materials[i];
            material.flags |= scene::kMaterialSpecular | (i % 2 ? scene::kMaterialWater : scene::kMaterialMirror);
            material.metallic_roughness_texture = scene::kNoTexture;
            material.roughness = 0.1f;
            material.metallic = 0.0f;
            material.alpha_cutoff = 0.05f;
        }
        const scene::StaticScene scene = world.view();
        Random random(7000 + seed);
        const PinholeView view = random_view(random, scene.bounds);
        const VisibilityBuffer visibility = cast_view(scene, view);
        const int step = 1 << seed % 3;
        Image mirrored;
        mirrored.resize((kWidth + step - 1) / step, (kHeight + step - 1) / step);
        std::vector<float> depth(mirrored.pixels.size());
        for (int y = 0; y < mirrored.height; ++y)
            for (int x = 0; x < mirrored.width; ++x) {
                // Smooth, with holes and sky: what a lookup a thousandth of a pixel beside finds is the same.
                const std::size_t at = std::size_t(y) * std::size_t(mirrored.stride) + std::size_t(x);
                const std::uint32_t alpha = x % 16 < 10   ? shading::kReflectsSurface
                                            : x % 16 < 14 ? shading::kReflectsSky
                                                          : shading::kReflectsUnknown;
                mirrored.pixels[at] =
                    alpha << 24 | std::uint32_t(100 + x / 4) << 16 | std::uint32_t(60 + y / 4) << 8 | 90u;
                depth[at] = alpha == shading::kReflectsSurface ? 40.0f : std::numeric_limits<float>::infinity();
            }
        const shading::Reflections reflections{
            .image = mirrored, .depth = depth.data(), .step = step, .within_m = 30.0f};
        const shading::Waves waves = shading::make_waves(view.position, {}, 3.0 * seed);
        const ShadeSettings settings{.waves = seed < 2 ? &waves : nullptr, .reflections = &reflections};
        for (const Image& image :
             images_of_all_targets([&] { return shade_view(scene, view, visibility, settings); })) {
            const Difference d = compare_with_reference(scene, view, visibility, image, settings);
            EXPECT_LE(d.large, 150) << "seed " << seed << ", max " << d.max;
            compared += d.compared;
            large += d.large;
        }
        shown = std::max(shown, largest_difference(shade_view(scene, view, visibility, settings),
                                                   shade_view(scene, view, visibility)));
    }
    EXPECT_GT(shown, 20);
    EXPECT_GT(compared, 200000);
    EXPECT_LE(large, compared / 500);
}

TEST(shading, any_share_of_the_sun_is_shaded_as_the_reference_says) {
    int compared = 0, large = 0;
    for (std::uint32_t seed = 0; seed < 6; ++seed) {
        scene::SceneData world = make_material_world(seed);
        const scene::StaticScene scene = world.view();
        Random random(2000 + seed);
        const PinholeView view = random_view(random, scene.bounds);
        const VisibilityBuffer visibility = cast_view(scene, view);
        std::vector<std::uint8_t> seen(visibility.instance.size());
        for (std::uint8_t& share : seen)  // mostly all or nothing, as rays say
            share = std::uint8_t(random.below(3) == 0 ? random.below(256) : 255 * random.below(2));
        for (const float beyond : {std::numeric_limits<float>::infinity(), 10.0f}) {
            const ShadeSettings settings{.prelit_beyond_m = beyond, .sun_seen = seen.data()};
            const Difference d = compare_with_reference(scene, view, visibility,
                                                        shade_view(scene, view, visibility, settings), settings);
            compared += d.compared;
            large += d.large;
        }
        // Who sees all of it is shaded as if nobody had asked.
        std::fill(seen.begin(), seen.end(), std::uint8_t(255));
        EXPECT_LE(largest_difference(shade_view(scene, view, visibility),
                                     shade_view(scene, view, visibility, {.sun_seen = seen.data()})),
                  1);
    }
    EXPECT_GT(compared, 300000);
    EXPECT_LE(large, compared / 10000);
}

TEST(shading, beyond_the_prelit_distance_a_triangle_has_one_colour) {
    int compared = 0, large = 0;
    for (std::uint32_t seed = 0; seed < 4; ++seed) {
        scene::SceneData world = make_material_world(seed);
        const scene::StaticScene scene = world.view();
        Random random(seed);
        const PinholeView view = random_view(random, scene.bounds);
        const VisibilityBuffer visibility = cast_view(scene, view);
        for (const float beyond : {0.0f, 10.0f}) {
            const ShadeSettings settings{.prelit_beyond_m = beyond};
            const Difference d = compare_with_reference(scene, view, visibility,
                                                        shade_view(scene, view, visibility, settings), settings);
            compared += d.compared;
            large += d.large;
        }
    }
    EXPECT_LE(large, compared / 10000);

    scene::SceneData world = make_postcard();
    world.environment.fog_density_per_m = 0.0f;
    const scene::StaticScene scene = world.view();
    Camera camera;
    camera.position = {0.0, 30.0, 30.0};
    const PinholeView view = make_view(camera, kWidth, kHeight);
    const VisibilityBuffer visibility = cast_view(scene, view);
    const Image image = shade_view(scene, view, visibility, {.prelit_beyond_m = 0.0f});
    for (std::size_t i = 1; i < std::size_t(kWidth); ++i)
        for (int y = 0; y < kHeight; ++y) {
            const std::size_t at = visibility.index(int(i), y);
            if (visibility.instance[at] != farfield::kSkyInstance &&
                visibility.instance[at] == visibility.instance[at - 1] &&
                visibility.triangle[at] == visibility.triangle[at - 1]) {
                ASSERT_EQ(image.pixels[at], image.pixels[at - 1]);
            }
        }
}

TEST(shading, a_panorama_stands_in_for_the_gradient) {
    scene::SceneData world = make_empty_world();
    add_panorama(world, 128, 64);
    const scene::StaticScene scene = world.view();
    Random random(3);
    for (int i = 0; i < 12; ++i) {
        Camera camera;
        camera.yaw = random.in(-4, 4);
        camera.pitch = i == 0 ? 0.5 * kPi : i == 1 ? -0.5 * kPi : random.in(-1.5, 1.5);
        const PinholeView view = make_view(camera, kWidth, kHeight);
        const VisibilityBuffer visibility = cast_view(scene, view);
        const Difference d = compare_with_reference(scene, view, visibility, shade_view(scene, view, visibility));
        EXPECT_EQ(d.large, 0) << "view " << i << ", max " << d.max;
        EXPECT_EQ(d.compared, kWidth * kHeight);
    }
}

TEST(shading, one_and_two_workers_give_the_same_bits) {
    scene::SceneData world = make_material_world(7);
    const scene::StaticScene scene = world.view();
    Random random(7);
    const PinholeView view = random_view(random, scene.bounds);
    const VisibilityBuffer visibility = cast_view(scene, view);
    ZeroPageVector<std::uint32_t> first;
    for (const int workers : {1, 2, 2}) {
        const WorkerLimit limit(workers);
        const Image image = shade_view(scene, view, visibility);
        if (first.empty()) first = image.pixels;
        EXPECT_EQ(image.pixels, first);
    }
}

TEST(shading, every_vector_width_draws_the_same_picture) {
    scene::SceneData postcard = make_postcard();
    const scene::StaticScene scene = postcard.view();
    Camera camera;
    camera.position = {0.0, 6.0, 20.0};
    const PinholeView view = make_view(camera, kWidth, kHeight);
    const VisibilityBuffer visibility = cast_view(scene, view);
    const std::vector<Image> images = images_of_all_targets([&] { return shade_view(scene, view, visibility); });
    ASSERT_FALSE(images.empty());
    for (const Image& image : images) {
        // Fused and separate multiply-adds round differently: at borders of mip levels the choice may differ.
        int different = 0;
        for (std::size_t i = 0; i < image.pixels.size(); ++i)
            for (int k = 0; k < 3; ++k)
                different += std::abs(channel(image.pixels[i], k) - channel(images[0].pixels[i], k)) > 1;
        EXPECT_LE(different, 60);
    }
}

TEST(shading, only_the_pixels_asked_for_are_written) {
    scene::SceneData world = make_material_world(2);
    const scene::StaticScene scene = world.view();
    Random random(2);
    const PinholeView view = random_view(random, scene.bounds);
    const VisibilityBuffer visibility = cast_view(scene, view);
    const Image whole = shade_view(scene, view, visibility);
    std::vector<farfield::TileRequest> tiles = all_tiles(kWidth, kHeight);
    std::uint64_t asked = 0;
    for (farfield::TileRequest& tile : tiles)
        for (int j = 0; j < farfield::kTileSize; ++j) {
            tile.rows[j] = std::uint16_t(random.below(5) == 0 ? 0xFFFF : random.below(65536));
            for (int i = 0; i < farfield::kTileSize; ++i)
                asked += (tile.rows[j] >> i & 1) && tile.x + i < kWidth && tile.y + j < kHeight;
        }
    Image image;
    image.resize(kWidth, kHeight);
    const std::uint32_t untouched = 0x12345678u;
    std::fill(image.pixels.begin(), image.pixels.end(), untouched);
    EXPECT_EQ(shading::shade_tiles(scene, {}, view, visibility, tiles, {}, image), asked);
    for (const farfield::TileRequest& tile : tiles)
        for (int j = 0; j < farfield::kTileSize; ++j)
            for (int i = 0; i < farfield::kTileSize; ++i) {
                const std::size_t at = visibility.index(tile.x + i, tile.y + j);
                const bool inside = tile.x + i < kWidth && tile.y + j < kHeight;
                const bool asked_for = inside && (tile.rows[j] >> i & 1);
                ASSERT_EQ(image.pixels[at], asked_for ? whole.pixels[at] : untouched);
            }
}

TEST(shading, dynamic_instances_are_named_after_the_static_ones) {
    scene::SceneData world = make_material_world(5);
    const scene::StaticScene scene = world.view();
    Random random(5);
    const PinholeView view = random_view(random, scene.bounds);
    VisibilityBuffer visibility = cast_view(scene, view);
    const Image as_static = shade_view(scene, view, visibility);
    for (std::uint32_t& instance : visibility.instance)
        if (instance < scene.instances.size()) instance += std::uint32_t(scene.instances.size());
    const Image as_dynamic = shade_view(scene, view, visibility, {}, scene.instances);
    EXPECT_EQ(largest_difference(as_static, as_dynamic), 0);
}

TEST(shading, names_outside_the_scene_are_sky) {
    scene::SceneData world = make_material_world(5);
    const scene::StaticScene scene = world.view();
    const PinholeView view = make_view({}, kWidth, kHeight);
    VisibilityBuffer sky;
    sky.resize(kWidth, kHeight);
    std::fill(sky.instance.begin(), sky.instance.end(), farfield::kSkyInstance);
    VisibilityBuffer wrong = sky;
    for (std::size_t i = 0; i < wrong.instance.size(); ++i) {
        wrong.instance[i] = i % 3 == 0 ? farfield::kUnresolved : i % 3 == 1 ? 0u : 77777u;
        wrong.triangle[i] = 0xFFFFFFF0u;
    }
    EXPECT_EQ(largest_difference(shade_view(scene, view, sky), shade_view(scene, view, wrong)), 0);
}

TEST(shading, a_mirrored_instance_is_lit_like_the_mesh_it_mirrors) {
    // A ball mirrored in x under a sun in the y-z plane: the picture is its own mirror image.
    Image images[2];
    for (const int side : {0, 1}) {
        scene::SceneData world = make_closed_sphere(2.0, 24);
        world.environment.to_sun = glm::normalize(Vec3(0.0f, 0.6f, 0.8f));
        if (side == 1) world.instances[0].world_from_mesh[0] = Vec3(-1.0f, 0.0f, 0.0f);
        const scene::StaticScene scene = world.view();
        Camera camera;
        camera.position = {0.0, 0.0, 8.0};
        const PinholeView view = make_view(camera, 192, 144);
        images[side] = shade_view(scene, view, cast_view(scene, view));
    }
    int different = 0;
    for (int y = 0; y < 144; ++y)
        for (int x = 0; x < 192; ++x)
            for (int k = 0; k < 3; ++k)
                different += std::abs(channel(images[0].pixels[std::size_t(y * images[0].stride + x)], k) -
                                      channel(images[1].pixels[std::size_t(y * images[1].stride + 191 - x)], k)) > 3;
    EXPECT_LE(different, 200);  // the outline
}

TEST(shading, fog_hides_what_is_far_in_the_colour_of_the_horizon) {
    scene::SceneData world = make_postcard();
    world.environment.fog_density_per_m = 10.0f;
    const scene::StaticScene scene = world.view();
    Camera camera;
    camera.position = {0.0, 20.0, 20.0};
    camera.pitch = -0.6;
    const PinholeView view = make_view(camera, kWidth, kHeight);
    const VisibilityBuffer visibility = cast_view(scene, view);
    const Image image = shade_view(scene, view, visibility);
    const std::uint32_t first = image.pixels[visibility.index(100, 140)];
    for (int x = 0; x < kWidth; ++x) EXPECT_EQ(image.pixels[visibility.index(x, 140)], first);
    EXPECT_NEAR(channel(first, 0), 255.0 * 0.8545, 2.0);  // sRGB of 0.70
}

TEST(shading, an_unlit_texel_comes_back_as_it_is) {
    for (const std::uint32_t value : {0u, 1u, 5u, 10u, 11u, 40u, 128u, 200u, 254u, 255u}) {
        scene::SceneData world = make_single_triangle(Vec3(-9, -9, -5), Vec3(9, -9, -5), Vec3(0, 9, -5));
        const std::vector<std::uint32_t> texel(1, value * 0x010101u | 0xFF000000u);
        world.materials[0].base_color = Vec4(1.0f);
        world.materials[0].flags = scene::kMaterialUnlit;
        world.materials[0].base_color_texture = world.add_texture(texel, 1, 1, scene::Wrap::repeat, scene::Wrap::clamp);
        const scene::StaticScene scene = world.view();
        const PinholeView view = make_view({}, 64, 48);
        const VisibilityBuffer visibility = cast_view(scene, view);
        const Image image = shade_view(scene, view, visibility);
        for (int k = 0; k < 3; ++k)
            EXPECT_NEAR(channel(image.pixels[visibility.index(32, 24)], k), int(value), 1) << value;
    }
}

TEST(shading, degenerate_and_grazing_triangles_have_a_colour) {
    // Nothing here may read outside the texture, and a pixel is always opaque.
    for (std::uint32_t seed = 0; seed < 6; ++seed) {
        scene::SceneData world = make_triangle_soup({.masked = true}, {.seed = seed});
        for (scene::VertexAttributes& vertex : world.attributes) vertex.uv *= seed % 2 == 0 ? 1.0f : 1e12f;
        const scene::StaticScene scene = world.view();
        Random random(seed);
        PinholeView view = random_view(random, scene.bounds);
        VisibilityBuffer visibility = cast_view(scene, view);
        // Any triangle may be named by any pixel: behind the viewer, edge on, without area, without a depth.
        for (std::size_t i = 0; i < visibility.instance.size(); ++i) {
            visibility.instance[i] = random.below(std::uint32_t(scene.instances.size()));
            visibility.triangle[i] =
                random.below(scene.meshes[scene.instances[visibility.instance[i]].mesh].triangle_count);
            if (i % 7 == 0) visibility.depth[i] = std::numeric_limits<float>::quiet_NaN();
        }
        if (seed == 4) view.position = scene.instances[0].position;  // inside the first triangle's corner
        for (const Image& image :
             images_of_all_targets([&] { return shade_view(scene, view, visibility, {.prelit_beyond_m = 5.0f}); }))
            for (int y = 0; y < kHeight; ++y)
                for (int x = 0; x < kWidth; ++x) ASSERT_EQ(image.pixels[visibility.index(x, y)] >> 24, 255u);
    }
}

TEST(shading, the_model_keeps_surfaces_that_face_away_from_the_sun_visible) {
    const shading::ShadingUniforms uniforms = shading::make_uniforms({}, make_view({}, 64, 48));
    for (double y = -1.0; y <= 1.0; y += 0.1) {
        const Vec4 light =
            uniforms.ambient_side + float(y) * uniforms.ambient_slope + float(y * y) * uniforms.ambient_curve;
        for (int k = 0; k < 3; ++k) EXPECT_GT(light[k], 0.1f);
    }
}

}  // namespace
}  // namespace ff::test
