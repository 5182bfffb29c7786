#pragma once
// Small animated models in one line, for tests and benches. The same seed gives the same bytes.

#include <cstdint>

#include "engine/scene/world.h"
#include "tests/support/worlds.h"

namespace ff::test {

/// A track of random keys; times ascend from 0.
void append_random_track(Random& random, std::uint32_t joint, scene::TrackPath path, scene::Interpolation interpolation,
                         int keys, float duration_s, scene::Clip& clip);

/// A chain of joints 0.5 m apart upwards, the first at the model's origin; clip "bend" turns each to and fro.
struct WormSettings {
    int joints = 6;
    int rings = 24;  ///< of vertices, up the whole length
    int sides = 12;
    float duration_s = 2.0f;
};
/// A tube whose rings follow the two nearest joints of such a chain. The mesh goes into `scene`.
[[nodiscard]] scene::AnimatedModel make_worm(scene::SceneData& scene, const WormSettings& worm = {});
/// A box that slides 4 m along x in clip "roll", with two boxes as wheels on it that turn; no skin.
[[nodiscard]] scene::AnimatedModel make_box_cart(scene::SceneData& scene);

/// Ground of 200 m a side with `worms` worms and `carts` carts on a grid, each playing at a phase of its own, in
/// sunlight with shadows.
struct AnimatedWorldSettings {
    int worms = 5, carts = 3;
    double spacing_m = 6.0;
    WorldPos origin{0.0};
    WormSettings worm;
};
struct AnimatedSource {
    scene::SceneData scene;  ///< finished
    scene::WorldInfo info;
};
[[nodiscard]] AnimatedSource make_animated_source(const AnimatedWorldSettings& settings = {});
[[nodiscard]] std::unique_ptr<scene::World> make_animated_world(const AnimatedWorldSettings& settings = {});

}  // namespace ff::test
