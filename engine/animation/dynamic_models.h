#pragma once
// Animated models, frame by frame: which of them may be seen, in which pose, and as which instances they are drawn.

#include <memory>
#include <span>
#include <vector>

#include "engine/animation/animator.h"
#include "engine/math/camera.h"
#include "engine/scene/world.h"

namespace ff::animation {

/// A model in the world at the time of a frame.
struct ModelState {
    WorldPos position{0.0};
    Mat3 world_from_model{1.0f};  ///< never singular
    Animator animator;
};

struct PoseSettings {
    /// A pose may be as old as this moves nothing of it, pixels: distant models are posed less often, and those of one
    /// clip share poses. 0: every pose is of its own time. Concerns models that play a single clip.
    float max_shift_px = 0.25f;
};

/// What a frame did; exact and repeatable.
struct PoseStats {
    std::uint32_t models = 0;    ///< given
    std::uint32_t sampled = 0;   ///< near enough to the view, or to a shadow in it, for their pose to be found
    std::uint32_t skins = 0;     ///< skinned meshes drawn
    std::uint32_t posed = 0;     ///< of them: vertices computed
    std::uint32_t borrowed = 0;  ///< of them: drawn in a nearer model's pose, for there were more than pose_count()
    std::uint64_t vertices = 0;  ///< computed
};

/// Poses the models of one world. Rigid parts cost a transform; a skin's vertices are computed once a frame, and only
/// where it, or its shadow, may be seen and no pose at hand will do. Everything that draws then finds them as meshes
/// of the scene (scene/pose_room.h), so all draw the same.
/// Threads: one, between frames; works on all of the jobs' workers. Results do not depend on their number, nor on
/// earlier frames but for which poses are borrowed. Steady frames allocate nothing.
class DynamicModels {
  public:
    /// Writes the world's pose room from now on; only one may. The world must outlive this.
    explicit DynamicModels(scene::World& world);
    ~DynamicModels();
    DynamicModels(const DynamicModels&) = delete;
    DynamicModels& operator=(const DynamicModels&) = delete;

    /// A layer's mask: the joint of that name and all that hangs on it; kNoMask where the model has no such joint.
    std::uint32_t add_mask(std::uint32_t model, std::string_view joint);

    /// Poses what the view may show, or the shadow of which it may.
    /// @return for Renderer::draw: instances in the order of `models`, each model's parts, then its skins; good until
    ///         the next call
    std::span<const scene::Instance> pose(std::span<const ModelState> models, const PinholeView& view,
                                          const PoseSettings& settings = {});

    [[nodiscard]] const PoseStats& stats() const;

  private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

/// The models that a world starts with, at time 0.
[[nodiscard]] std::vector<ModelState> initial_models(const scene::AnimationSet& set);

/// Puts models made by initial_models to a time since the start: what a walk shows.
void set_time(const scene::AnimationSet& set, double time_s, std::span<ModelState> models);

/// All entities that have an Animator and an ecs::WorldTransform, in the registry's order.
void gather_models(ecs::Registry& registry, std::vector<ModelState>& out);

}  // namespace ff::animation
