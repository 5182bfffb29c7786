#pragma once
// glTF animations to clips.

#include <vector>

#include "engine/core/result.h"
#include "engine/scene/animation.h"
#include "tools/cook/cook_context.h"
#include "tools/cook/gltf_accessor.h"

namespace ff::cook {

/// Reads every animation that moves a node of the scene; nameless ones are called "clip0", "clip1", .. by their place
/// in the file, and of equal names the later ones get " 2", " 3", ... Channels of morph weights are warned about.
/// @param joint_of_node  kNoJoint for nodes that are not of the scene
/// @param size_m         of the model, for kMaxTranslationError
/// Errors: times that are negative or do not ascend; other numbers of values than of times; rotations of length 0.
[[nodiscard]] Result<std::vector<scene::Clip>> read_clips(const GltfData& data,
                                                          const std::vector<std::uint32_t>& joint_of_node, float size_m,
                                                          CookContext& context);

}  // namespace ff::cook
