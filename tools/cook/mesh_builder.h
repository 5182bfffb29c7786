#pragma once
// Collects the triangles of one static mesh while a generator writes them.

#include <array>
#include <cstdint>
#include <functional>
#include <string>
#include <utility>

#include "tools/cook/world_source.h"

namespace ff::cook {

/// Linear RGB in [0, 1] to the RGBA8 of VertexAttributes::color; alpha 1.
[[nodiscard]] std::uint32_t pack_color(const Vec3& linear);
inline constexpr std::uint32_t kWhite = 0xFFFFFFFFu;

/// Positions come in world coordinates (double) and are kept relative to the mesh's origin (float).
class MeshBuilder {
  public:
    MeshBuilder(std::string name, const WorldPos& origin);

    /// Bends what is added from now on with flat_triangle and flat_quad: world to world. Empty: straight.
    void set_warp(std::function<DVec3(const DVec3&)> warp) { warp_ = std::move(warp); }

    /// Adds a vertex; @return its index in this mesh.
    std::uint32_t vertex(const DVec3& world, const Vec3& unit_normal, const Vec2& uv, std::uint32_t color = kWhite);
    /// Counter-clockwise seen from outside.
    void triangle(std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t material);
    /// A flat triangle of its own vertices, with its geometric normal. Degenerate ones are left out.
    void flat_triangle(const std::array<DVec3, 3>& corners, const std::array<Vec2, 3>& uvs, std::uint32_t material,
                       std::uint32_t color = kWhite);
    /// A flat quad a, b, c, d, counter-clockwise seen from outside; normal from its diagonals.
    void flat_quad(const std::array<DVec3, 4>& corners, const std::array<Vec2, 4>& uvs, std::uint32_t material,
                   std::uint32_t color = kWhite);

    [[nodiscard]] std::size_t triangle_count() const { return geometry_.triangle_materials.size(); }
    [[nodiscard]] const WorldPos& origin() const { return origin_; }
    [[nodiscard]] SourceMesh take();

  private:
    std::string name_;
    WorldPos origin_;
    std::function<DVec3(const DVec3&)> warp_;
    scene::MeshSource geometry_;
};

/// Puts a finished mesh into the world where its origin is, to be merged into its cell. Empty meshes are left out.
void add_static_mesh(WorldSource& world, MeshBuilder&& builder);

}  // namespace ff::cook
