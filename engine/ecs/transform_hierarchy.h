#pragma once
// Things that hang on other things: local transforms, parents, and where that puts them in the world.

#include <cstdint>
#include <glm/gtc/quaternion.hpp>
#include <span>
#include <vector>

#include "engine/core/result.h"
#include "engine/ecs/registry.h"
#include "engine/math/types.h"

namespace ff::ecs {

/// Relative to the parent, or to the world where there is none: scale, then rotate, then move.
struct LocalTransform {
    DVec3 position{0.0};                         ///< metres
    glm::quat rotation{1.0f, 0.0f, 0.0f, 0.0f};  ///< unit
    Vec3 scale{1.0f};
};

/// Set it through TransformHierarchy::set_parent, which refuses cycles.
struct Parent {
    Entity entity;
};

/// Written by TransformHierarchy::update: p_world = position + linear * p_local.
struct WorldTransform {
    WorldPos position{0.0};
    Mat3 linear{1.0f};  ///< rotation and scale; shears where a turned child hangs on an unevenly scaled parent
};

/// Computes the world transforms of all entities that have a LocalTransform and a WorldTransform. A parent that is not
/// alive, or has no transforms, counts as none.
/// Steady state: while no entity, component or parent comes or goes, an update allocates nothing and only multiplies.
class TransformHierarchy {
  public:
    /// Hangs `child` on `parent`, or on nothing where `parent` is null. The local transform stays as it is.
    /// Errors (usage): either is not alive; the parent is the child or hangs on it.
    Status set_parent(Registry& registry, Entity child, Entity parent);

    /// Brings every world transform up to date: parents before children, depth by depth, each depth in parallel.
    void update(Registry& registry);

    /// Destroys an entity and all that hang on it, however deep. @return how many.
    std::size_t destroy_subtree(Registry& registry, Entity root);

    /// Depth of the deepest entity of the last update; roots are 0; -1 where there was none.
    [[nodiscard]] int deepest() const { return int(depth_begin_.size()) - 2; }

  private:
    struct Link {
        const LocalTransform* local;
        WorldTransform* world;
        const WorldTransform* parent;  ///< null: a root
    };
    void rebuild(Registry& registry);

    std::uint64_t version_ = 0;  ///< of the structure that links_ was built from
    bool parents_changed_ = true;
    std::vector<Link> links_;                 ///< by depth, then by storage order
    std::vector<std::uint32_t> depth_begin_;  ///< first link of each depth, and the end
    std::vector<Entity> entities_, parents_;  // scratch of rebuild
    std::vector<std::uint32_t> depth_of_;     // by entity index; kUnknown where not part
};

}  // namespace ff::ecs
