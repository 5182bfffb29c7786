#include "engine/animation/animator.h"

#include <algorithm>

namespace ff::animation {

bool play(const scene::AnimatedModel& model, Animator& animator, std::string_view clip, const PlaySettings& settings) {
    const std::uint32_t id = scene::find_clip(model, clip);
    if (id == scene::kNoClip) return false;
    animator.before = animator.now;
    animator.now = {.clip = id, .speed = settings.speed, .mode = settings.mode};
    animator.fade_s = animator.fade_left_s = std::max(settings.fade_s, 0.0f);
    return true;
}

float fade_weight(const Animator& animator) {
    if (!(animator.fade_left_s > 0.0f) || !(animator.fade_s > 0.0f)) return 1.0f;
    return std::clamp(1.0f - animator.fade_left_s / animator.fade_s, 0.0f, 1.0f);
}

void advance(Animator& animator, double dt_s) {
    for (ClipPlay* play : {&animator.now, &animator.before, &animator.layer})
        play->time_s += dt_s * double(play->speed);
    animator.fade_left_s = std::max(0.0f, animator.fade_left_s - float(dt_s));
}

void advance_animators(ecs::Registry& registry, double dt_s) {
    registry.each_chunk_parallel<Animator>([&](std::span<const ecs::Entity>, std::span<Animator> animators) {
        for (Animator& animator : animators) advance(animator, dt_s);
    });
}

void advance_animators(ecs::SystemContext& context, double dt_s) {
    context.each_chunk_parallel<Animator>([&](std::span<const ecs::Entity>, std::span<Animator> animators) {
        for (Animator& animator : animators) advance(animator, dt_s);
    });
}

ecs::Access advance_access() {
    return ecs::Access().write<Animator>();
}

}  // namespace ff::animation
