#pragma once
// A small town between hills, with everything that a picture may go wrong in: for golden images and the seam.

#include "engine/scene/scene_data.h"

namespace ff::test {

/// A street of textured houses, trees with masked leaves as instances, lamps that glow, a pond that mirrors the sky,
/// fog; hills to 2 km. About 25,000 triangles, drawn 300,000. The street runs along z through the origin, ground at y =
/// 0 up to 250 m from it.
struct TownSettings {
    bool glass = false;  ///< blended panes before some of the houses
};
[[nodiscard]] scene::SceneData make_small_town(const TownSettings& settings = {});

/// Height of that town's ground, metres.
[[nodiscard]] double small_town_ground(double x, double z);

}  // namespace ff::test
