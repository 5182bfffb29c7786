#pragma once
// The bodies, where they are, and which are near a box.

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "engine/physics/geometry.h"
#include "engine/physics/scene_walk.h"
#include "engine/physics/types.h"

struct btDbvtNode;

namespace ff::physics {

/// Where a body is: its centre of mass, and how it is turned.
struct Frame {
    DVec3 position{0.0};
    glm::quat rotation{1.0f, 0.0f, 0.0f, 0.0f};

    friend bool operator==(const Frame&, const Frame&) = default;
};

/// Everything that one body is. What is not derived is saved.
struct Body {
    BodyDesc desc;  ///< as given; pose and velocities are below
    std::uint32_t generation = 0;
    bool alive = false;
    Frame frame;
    Frame before;  ///< of the last step: what stands on it was carried by the difference
    Frame target;  ///< kinematic: of the next step
    bool has_target = false;
    Vec3 velocity{0.0f}, spin{0.0f};
    bool asleep = false;
    float still_s = 0.0f;  ///< for how long it has been too slow to matter

    // Derived.
    std::shared_ptr<const Geometry> geometry;
    DBox3 bounds;  ///< world
    btDbvtNode* leaf = nullptr;
    std::int32_t place = -1, active_at = -1;  ///< in the lists of the step that goes on

    [[nodiscard]] bool is_dynamic() const { return desc.motion == Motion::dynamic; }
};

[[nodiscard]] inline DMat3 matrix_of(const glm::quat& q) {
    return glm::mat3_cast(glm::dquat(double(q.w), double(q.x), double(q.y), double(q.z)));
}
[[nodiscard]] Frame frame_of(const Geometry& geometry, const Pose& pose);
[[nodiscard]] Pose pose_of(const Geometry& geometry, const Frame& frame);
[[nodiscard]] PlacedMesh placed(const Geometry& geometry, const Frame& frame);
/// Where a point of a body goes between two of its frames.
[[nodiscard]] DVec3 carried(const Frame& from, const Frame& to, const DVec3& point);

/// Bodies by slot, and a tree of their boxes. What a query finds depends on the boxes alone, and is in order of slots,
/// so that it does not matter how the tree came about.
class BodyStore {
  public:
    explicit BodyStore(const scene::StaticScene& scene);
    ~BodyStore();
    BodyStore(const BodyStore&) = delete;
    BodyStore& operator=(const BodyStore&) = delete;

    Result<std::shared_ptr<const Geometry>> geometry_of(const Shape& shape);
    /// Takes the slot that was freed last, else a new one; the body must have its geometry and frame.
    std::uint32_t add(Body body);
    void remove(std::uint32_t slot);
    /// After its frame or geometry changed.
    void update_bounds(std::uint32_t slot);

    [[nodiscard]] Body* find(BodyId id);
    [[nodiscard]] const Body* find(BodyId id) const { return const_cast<BodyStore*>(this)->find(id); }
    [[nodiscard]] BodyId id_of(std::uint32_t slot) const { return {slot, bodies_[slot].generation}; }
    [[nodiscard]] Body& operator[](std::uint32_t slot) { return bodies_[slot]; }
    [[nodiscard]] const Body& operator[](std::uint32_t slot) const { return bodies_[slot]; }
    [[nodiscard]] std::size_t slot_count() const { return bodies_.size(); }
    [[nodiscard]] std::span<const std::uint32_t> free_slots() const { return free_; }
    /// Replaces everything: bodies by slot, with geometry and frame, and the order in which slots are given out.
    void restore(std::vector<Body> bodies, std::vector<std::uint32_t> free_slots);

    /// Around all bodies, conservatively; empty without any.
    [[nodiscard]] DBox3 bounds() const;
    /// Slots of the bodies whose boxes meet the moving box, ascending; replaces what `out` holds.
    void find(const SweptBox& box, std::vector<std::uint32_t>& out) const;

  private:
    struct Tree;
    void find_under(const btDbvtNode& root, const SweptBox& box, std::vector<std::uint32_t>& out) const;

    const scene::StaticScene& scene_;
    std::vector<Body> bodies_;
    std::vector<std::uint32_t> free_;                        ///< last in, first out
    std::vector<std::weak_ptr<const Geometry>> geometries_;  ///< shared by bodies of equal shape
    std::unique_ptr<Tree> tree_;
};

}  // namespace ff::physics
