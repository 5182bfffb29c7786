#pragma once
// The world that a game walks through: the static scene and what goes with it. Made by load_world, or from arrays in
// memory.

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "engine/assets/page_buffer.h"
#include "engine/scene/animation.h"
#include "engine/scene/pose_room.h"
#include "engine/scene/scene_data.h"
#include "engine/scene/sound.h"
#include "engine/scene/static_scene.h"
#include "engine/scene/walk.h"

namespace ff::scene {

/// A mesh of the static scene placed where it may move: what the game starts with. It moves as a whole; what moves of
/// itself is an AnimatedInstance.
struct DynamicInstance {
    std::uint32_t mesh = 0;
    WorldPos position{0.0};
    Mat3 world_from_mesh{1.0f};  ///< rotation, scale, mirror; never singular

    friend bool operator==(const DynamicInstance&, const DynamicInstance&) = default;
};

/// What moves as a whole: where the world has put it, and which of its moving instances it is made of.
struct MovingModel {
    WorldPos position{0.0};                                ///< metres
    double yaw = 0.0;                                      ///< radians, as Camera::yaw
    std::uint32_t first_instance = 0, instance_count = 0;  ///< of WorldInfo::dynamic_instances
    std::uint32_t first_animated = 0, animated_count = 0;  ///< of AnimationSet::instances

    friend bool operator==(const MovingModel&, const MovingModel&) = default;
};

/// A place that has a name, by which a game finds it: where a model stands, or nothing.
struct NamedPlace : MovingModel {
    std::string name;  ///< unique in a world

    friend bool operator==(const NamedPlace&, const NamedPlace&) = default;
};

/// Birds that fly together about a place, each a copy of the model that stands there.
struct Flock {
    MovingModel model;
    std::uint32_t birds = 0;  ///< [1, kMostBirds]
    float radius_m = 45.0f;   ///< how far they stray, about. [5, 1000]

    friend bool operator==(const Flock&, const Flock&) = default;
};
inline constexpr std::uint32_t kMostBirds = 256;

/// A rigid body that nobody holds.
struct LooseBody {
    MovingModel model;      ///< of one instance at least, none of them animated
    float mass_kg = 10.0f;  ///< [1e-3, 1e6]

    friend bool operator==(const LooseBody&, const LooseBody&) = default;
};

/// What a pack holds beside the static scene.
struct WorldInfo {
    std::string name;
    WorldPos spawn_position{0.0};  ///< of the feet
    double spawn_yaw = 0.0;        ///< radians, as Camera::yaw
    std::vector<DynamicInstance> dynamic_instances;
    std::vector<NamedPlace> places;
    std::vector<Flock> flocks;
    std::vector<LooseBody> loose_bodies;
    AnimationSet animation;
    SoundSet sounds;
    std::vector<Walk> walks;         ///< names are unique and not empty
    std::uint64_t source_bytes = 0;  ///< of the files that it was cooked from
};

struct WorldStatistics {
    std::uint64_t triangles = 0;            ///< stored
    std::uint64_t instanced_triangles = 0;  ///< as drawn: each instance counted, those that move too
    std::uint64_t vertices = 0;
    std::uint64_t memory_bytes = 0;  ///< of the static scene's arrays
    std::uint64_t pack_bytes = 0;    ///< of the file; 0 without one
    std::uint64_t pack_hash = 0;     ///< names the file's contents; 0 without one
};

/// Owns everything that its scene() borrows. Read-only, any thread; but for what pose_room() gives.
class World {
  public:
    /// A world from arrays in memory. The scene must be finished.
    World(SceneData data, WorldInfo info);
    World(const World&) = delete;
    World& operator=(const World&) = delete;

    [[nodiscard]] const StaticScene& scene() const { return scene_; }
    [[nodiscard]] const WorldInfo& info() const { return info_; }
    [[nodiscard]] const WorldStatistics& statistics() const { return statistics_; }
    /// The place of that name, or nullptr.
    [[nodiscard]] const NamedPlace* find_place(std::string_view name) const;
    /// Where skinned meshes are put into poses; between frames, by one owner (animation::DynamicModels).
    [[nodiscard]] const PoseRoom& pose_room() { return pose_room_; }
    /// The walk of that name, or nullptr.
    [[nodiscard]] const Walk* find_walk(std::string_view name) const;

  private:
    friend class WorldLoader;
    World() = default;
    void count();

    SceneData data_;              ///< empty where a pack was loaded
    assets::PageBuffer storage_;  ///< the arrays of a loaded pack
    std::vector<Lamp> lamps_;     ///< likewise
    StaticScene scene_;
    WorldInfo info_;
    PoseRoom pose_room_;
    WorldStatistics statistics_;
};

}  // namespace ff::scene
