#pragma once
// Small worlds in one line, for tests and benches. The same seed gives the same bytes. Every world is finished and has
// material 0 (grey, opaque); what stands on the ground stands at y = 0 near the world's origin unless moved.

#include <cstdint>
#include <random>

#include "engine/math/camera.h"
#include "engine/scene/scene_data.h"

namespace ff::test {

struct WorldSettings {
    std::uint32_t seed = 1;
    WorldPos origin{0.0};                  ///< everything is moved by this
    std::uint32_t height_grid_size = 256;  ///< squares a side
};

/// A grid of streets, 80 m apart, with boxes of 8 to 60 m between them; each building is a box of `subdivisions`^2
/// quads a side. A square block of `cells` x `cells` cells of 4 x 4 buildings.
struct CitySettings {
    int cells = 4;
    int subdivisions = 1;
};
[[nodiscard]] scene::SceneData make_city(const CitySettings& city = {}, const WorldSettings& world = {});

/// Hills of `relief_m` on a square of `size_m`, quads of `spacing_m`, in cells of 64 x 64 quads.
struct TerrainSettings {
    double size_m = 2000.0;
    double spacing_m = 20.0;
    double relief_m = 80.0;
};
[[nodiscard]] scene::SceneData make_terrain(const TerrainSettings& terrain = {}, const WorldSettings& world = {});
/// Height of that terrain, metres.
[[nodiscard]] double terrain_height(double x, double z, double relief_m);

/// Trees as instances of a few meshes (trunk, and crossed cards or small leaf triangles) on a flat ground: turned,
/// scaled, some of them mirrored.
struct ForestSettings {
    int trees = 400;
    double size_m = 200.0;
    bool masked = true;  ///< leaf cards with an alpha mask; else single opaque leaves
    int leaves = 400;    ///< per tree
};
[[nodiscard]] scene::SceneData make_forest(const ForestSettings& forest = {}, const WorldSettings& world = {});

/// Triangles anywhere in a cube of `size_m`, with edges up to `edge_m`, as `meshes` meshes with two instances each:
/// slivers, zero-area and duplicate ones among them.
struct SoupSettings {
    int triangles = 200;
    int meshes = 3;
    double size_m = 20.0;
    double edge_m = 4.0;
    bool masked = false;  ///< every second triangle
};
[[nodiscard]] scene::SceneData make_triangle_soup(const SoupSettings& soup = {}, const WorldSettings& world = {});

/// One triangle, one instance at the world's origin.
[[nodiscard]] scene::SceneData make_single_triangle(const Vec3& a, const Vec3& b, const Vec3& c,
                                                    const WorldSettings& world = {});

/// A closed sphere of `rings` x 2 `rings` quads, bumpy by `bump` of its radius: no ray from inside may leave it.
[[nodiscard]] scene::SceneData make_closed_sphere(double radius_m, int rings, double bump = 0.0,
                                                  const WorldSettings& world = {});

/// A world without anything.
[[nodiscard]] scene::SceneData make_empty_world();

// Parts, to put together other worlds.

/// Grey, opaque.
[[nodiscard]] scene::Material plain_material();
/// A leaf texture with a transparent surround, `size` texels a side, and its masked material; returns its id.
std::uint32_t add_leaf_material(scene::SceneData& scene, std::uint32_t size = 64);
/// An axis-aligned box with outward faces of n x n quads, appended to a mesh.
void append_box(scene::MeshSource& mesh, const Vec3& low, const Vec3& high, int n, std::uint16_t material);
void append_triangle(scene::MeshSource& mesh, const Vec3& a, const Vec3& b, const Vec3& c, std::uint16_t material);
/// A quad as two triangles, uv (0, 0) at a to (1, 1) at c.
void append_quad(scene::MeshSource& mesh, const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d,
                 std::uint16_t material);
/// Yaw, then scale; a negative scale in x mirrors.
[[nodiscard]] Mat3 turned_and_scaled(double yaw, const Vec3& scale);

/// Uniform numbers that are the same with every standard library.
class Random {
  public:
    explicit Random(std::uint32_t seed) : engine_(seed) {}
    [[nodiscard]] double unit() { return double(engine_()) / 4294967296.0; }  ///< [0, 1)
    [[nodiscard]] double in(double low, double high) { return low + (high - low) * unit(); }
    [[nodiscard]] std::uint32_t below(std::uint32_t n) { return std::uint32_t(unit() * double(n)); }
    [[nodiscard]] Vec3 in_box(const Vec3& low, const Vec3& high) {
        const double x = unit(), y = unit(), z = unit();
        return low + (high - low) * Vec3(float(x), float(y), float(z));
    }

  private:
    std::mt19937 engine_;
};

/// Anywhere in the box, looking anywhere, field of view 30 to 110 degrees.
[[nodiscard]] Camera random_camera(Random& random, const DBox3& box);

}  // namespace ff::test
