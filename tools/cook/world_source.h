#pragma once
// What the importers hand to the assembly: a world as plain arrays, before cells, BVHs and packs.

#include <cstdint>
#include <string>
#include <vector>

#include "engine/scene/animation.h"
#include "engine/scene/environment.h"
#include "engine/scene/scene_data.h"
#include "engine/scene/sound.h"

namespace ff::cook {

/// A decoded image, power-of-two sized. Two textures of the same bytes and wraps are one: `content_hash` tells.
struct SourceTexture {
    std::string name;  ///< for messages: file and place
    std::string content_hash;
    std::uint32_t width = 0, height = 0;
    std::vector<std::uint32_t> rgba;  ///< RGBA8 sRGB, top row first
    scene::Wrap wrap_u = scene::Wrap::repeat, wrap_v = scene::Wrap::repeat;
};

struct SourceMesh {
    std::string name;
    scene::MeshSource geometry;  ///< triangle_materials index WorldSource::materials
    std::string content_hash;    ///< of the geometry; empty until hash_meshes
};

enum class PlacementKind : std::uint8_t {
    merge,     ///< static and once: its triangles go into the cells they stand in
    instance,  ///< static and many: stays a mesh of its own
    dynamic,   ///< may move at run time
};

struct Placement {
    std::uint32_t mesh = 0;  ///< WorldSource::meshes
    DVec3 position{0.0};
    Mat3 world_from_mesh{1.0f};
    PlacementKind kind = PlacementKind::merge;
    bool stands_clear = false;  ///< known to share no plane with others: the coincident surfaces' step passes it by
};

/// Frames of a camera path (formats.md, Walkthroughs).
struct WalkFrame {
    DVec3 position{0.0};
    double yaw_deg = 0, pitch_deg = 0, roll_deg = 0;
};
struct SourceWalk {
    std::string name;
    double fov_deg = 60.0;
    double rate_hz = 30.0;
    std::vector<WalkFrame> frames;
};

/// A place with a name or a purpose, and the placements of the model that stands there.
struct SourcePlace {
    std::string name;  ///< empty: games do not find it
    DVec3 position{0.0};
    double yaw_deg = 0.0;
    std::size_t first_placement = 0, placement_count = 0;
    std::uint32_t first_animated = 0, animated_count = 0;  ///< of WorldSource::animation.instances
    std::uint32_t flock = 0;                               ///< birds; 0: the model is none of a flock
    float flock_radius_m = 0.0f;
    float mass_kg = 0.0f;  ///< 0: no rigid body
};

struct WorldSource {
    std::string name;
    std::vector<SourceTexture> textures;
    std::vector<scene::Material> materials;  ///< texture ids index `textures`
    std::vector<SourceMesh> meshes;
    std::vector<Placement> placements;
    scene::AnimationSet animation;  ///< parts and skins name `meshes`; skins have weights for their mesh's vertices
    scene::Environment environment;
    std::vector<scene::Lamp> lamps;
    std::vector<std::uint16_t> sky_panorama;  ///< see Environment::panorama
    DVec3 spawn_position{0.0};
    double spawn_yaw_deg = 0.0;
    scene::SoundSet sounds;
    std::vector<SourceWalk> walks;
    std::vector<SourcePlace> places;
    std::uint64_t bytes_in = 0;  ///< of all source files read
};

}  // namespace ff::cook
