#pragma once

#include <cstdint>
#include <functional>
#include <unordered_map>
#include <vector>

#include "engine/scene/scene_data.h"
#include "tools/cook/world_source.h"

namespace ff::cook {

/// Meshes of animated models, on their way through the assembly: preparing a mesh puts its vertices into another order
/// and makes equal ones one, so their weights are looked up again by where they lie (no two that lie in one place have
/// different ones, see gltf_animated).
class AnimationAssembly {
  public:
    /// Remembers what the meshes' vertices follow; the source may then let go of them.
    explicit AnimationAssembly(WorldSource& source);

    /// Ids of meshes that parts and skins need whole. Ascending.
    [[nodiscard]] const std::vector<std::uint32_t>& meshes() const { return meshes_; }

    /// The models as the pack has them. Parts and skins whose mesh has come out empty are left out.
    /// @param mesh_id  from the source's id to the scene's; kNone where there is none
    [[nodiscard]] scene::AnimationSet finish(const std::function<std::uint32_t(std::uint32_t)>& mesh_id,
                                             const scene::SceneData& scene);
    static constexpr std::uint32_t kNone = 0xFFFFFFFFu;

  private:
    scene::AnimationSet set_;
    std::vector<std::uint32_t> meshes_;
    std::vector<std::vector<Vec3>> positions_;  ///< [skin of all]: of the source's mesh
};

}  // namespace ff::cook
