#include "engine/scene/animation.h"

#include <algorithm>

namespace ff::scene {

std::uint32_t find_clip(const AnimatedModel& model, std::string_view name) {
    const auto found = std::ranges::find(model.clips, name, &Clip::name);
    return found == model.clips.end() ? kNoClip : std::uint32_t(found - model.clips.begin());
}

std::uint32_t find_joint(const Skeleton& skeleton, std::string_view name) {
    const auto found = std::ranges::find(skeleton.names, name);
    return found == skeleton.names.end() ? kNoJoint : std::uint32_t(found - skeleton.names.begin());
}

}  // namespace ff::scene
