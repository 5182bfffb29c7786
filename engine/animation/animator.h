#pragma once
// What a model is playing: a component for game code, and what moves it on.

#include <string_view>

#include "engine/animation/pose.h"
#include "engine/animation/sample_clip.h"
#include "engine/ecs/registry.h"
#include "engine/ecs/schedule.h"

namespace ff::animation {

/// A clip that is being played.
struct ClipPlay {
    std::uint32_t clip = scene::kNoClip;  ///< of the model; kNoClip: the rest pose
    double time_s = 0.0;                  ///< since it began, at speed 1
    float speed = 1.0f;                   ///< may be negative
    PlayMode mode = PlayMode::loop;

    friend bool operator==(const ClipPlay&, const ClipPlay&) = default;
};

inline constexpr std::uint32_t kNoMask = 0xFFFFFFFFu;

/// Component: an animated model and what it plays. Where it stands is the entity's ecs::WorldTransform.
struct Animator {
    std::uint32_t model = 0;  ///< of AnimationSet::models
    ClipPlay now;
    ClipPlay before;                     ///< that `now` fades in over
    float fade_s = 0.0f;                 ///< length of the fade
    float fade_left_s = 0.0f;            ///< 0: `now` alone
    ClipPlay layer;                      ///< played over the others where its mask says so
    float layer_weight = 0.0f;           ///< [0, 1]; 0: no layer
    std::uint32_t layer_mask = kNoMask;  ///< of DynamicModels::add_mask; kNoMask: all joints

    friend bool operator==(const Animator&, const Animator&) = default;
};

struct PlaySettings {
    float fade_s = 0.2f;  ///< over what was played before; 0: at once. [0, inf)
    float speed = 1.0f;
    PlayMode mode = PlayMode::loop;
};

/// Starts a clip by its name. A fade that is under way is cut short: the new one begins from what it fades to.
/// @return false, and nothing happens, where the model has no such clip
bool play(const scene::AnimatedModel& model, Animator& animator, std::string_view clip,
          const PlaySettings& settings = {});

/// The weight of `now` against `before`, [0, 1].
[[nodiscard]] float fade_weight(const Animator& animator);

/// Moves the clips and the fade on by `dt_s` seconds.
void advance(Animator& animator, double dt_s);

/// The same for every Animator there is, in parallel.
void advance_animators(ecs::Registry& registry, double dt_s);
/// As a system of a Schedule; it declares advance_access().
void advance_animators(ecs::SystemContext& context, double dt_s);
[[nodiscard]] ecs::Access advance_access();

}  // namespace ff::animation
