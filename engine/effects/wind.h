#pragma once
// Wind in foliage: how fast, how far, and whom it reaches. The movement itself is math/leaf_sway.h.

#include "engine/math/leaf_sway.h"
#include "engine/scene/environment.h"
#include "engine/scene/static_scene.h"

namespace ff::effects {

/// A weaker wind than this, metres a second, moves no leaf.
inline constexpr float kLeastWindMS = 0.1f;

/// Whether some mesh of the scene, static or not, holds foliage (scene::kMaterialSways).
[[nodiscard]] bool has_foliage(const scene::StaticScene& scene);

/// Whether foliage that stands still is nearer to the eye than so many metres. A look at the cells around.
[[nodiscard]] bool is_foliage_within(const scene::StaticScene& scene, const WorldPos& eye, double within_m);

/// Calls visit(const DBox3&) with the bounds of each instance of foliage that stands nearer than so many metres.
template <class Visit>
void for_foliage_within(const scene::StaticScene& scene, const WorldPos& eye, double within_m, Visit&& visit) {
    for (const scene::Cell& cell : scene.cells) {
        if (!(distance_to(cell.bounds, eye) < within_m)) continue;
        for (const scene::Instance& instance : scene.instances.subspan(cell.first_instance, cell.instance_count))
            if ((scene.meshes[instance.mesh].material_flags & scene::kMaterialSways) != 0 &&
                distance_to(instance.bounds, eye) < within_m)
                visit(instance.bounds);
    }
}

/// The movement at a moment, about an eye, in world axes. A shift of a hundredth of a metre for each metre a second of
/// wind, up to 0.1 m; gusts of 30 m run with the wind at its speed, leaves swing about once a second.
/// @param within_m  farther away they stand still
/// @param time_s    the same time gives the same movement
[[nodiscard]] LeafSway make_leaf_sway(const WorldPos& eye, const scene::Weather& weather, double time_s,
                                      float within_m);

}  // namespace ff::effects
