#pragma once
// A static world that owns its arrays: what the cooker assembles, a pack is loaded into, and tests build in a few
// lines.

#include <cstdint>
#include <span>
#include <vector>

#include "engine/scene/static_scene.h"

namespace ff::scene {

/// Triangles as they come from a source, mesh space.
struct MeshSource {
    std::vector<Vec3> positions;
    std::vector<VertexAttributes> attributes;       ///< same length
    std::vector<std::uint32_t> indices;             ///< 3 per triangle, all < positions.size()
    std::vector<std::uint16_t> triangle_materials;  ///< 1 per triangle, ids of SceneData::materials
};

/// A mesh ready to be cast: its BVH, with triangles and vertices put in the BVH's order (leaves hold consecutive
/// triangles).
struct PreparedMesh {
    MeshSource geometry;
    std::vector<BvhNode> nodes;  ///< node 0 is the root; empty for an empty mesh
    std::vector<BvhLeaf> leaves;
    Box3 bounds;
    std::uint32_t material_flags = 0;
};

/// Builds the BVH of a mesh (binned SAH, 16-wide) and reorders the mesh to it. Degenerate triangles are kept.
/// Deterministic: same input, same bytes.
[[nodiscard]] PreparedMesh prepare_mesh(MeshSource source, std::span<const Material> materials);

/// Unit normal to octahedral snorm16 and back (Cigolle et al., "A Survey of Efficient Representations for Independent
/// Unit Vectors", JCGT 2014). Error below 0.004 degrees.
void encode_normal(const Vec3& normal, std::int16_t out[2]);
[[nodiscard]] Vec3 decode_normal(const std::int16_t oct[2]);

/// The owner of a StaticScene's arrays. Fill it (materials, textures, meshes, instances in any order), then finish()
/// once.
class SceneData {
  public:
    std::vector<Vec3> positions;
    std::vector<VertexAttributes> attributes;
    std::vector<std::uint32_t> indices;
    std::vector<std::uint16_t> triangle_materials;
    std::vector<std::uint32_t> prelit_colors;
    std::vector<Mesh> meshes;
    std::vector<Instance> instances;
    std::vector<Cell> cells;
    std::vector<Material> materials;
    std::vector<Texture> textures;
    std::vector<std::uint32_t> texels;
    std::vector<BvhNode> mesh_nodes;
    std::vector<BvhLeaf> mesh_leaves;
    std::vector<BvhNode> instance_nodes;
    std::vector<float> heights;
    std::vector<std::uint16_t> sky_panorama;
    std::vector<Lamp> lamps;
    HeightGrid height_grid;   ///< its span is set by view()
    Environment environment;  ///< likewise
    WorldPos origin{0.0};
    DBox3 bounds;

    /// Appends a texture, making its mips (box filter in linear light; alpha kept in coverage for masked use).
    /// @param rgba  width * height texels, RGBA8 sRGB, top row first; width and height powers of two.
    std::uint32_t add_texture(std::span<const std::uint32_t> rgba, std::uint32_t width, std::uint32_t height,
                              Wrap wrap_u, Wrap wrap_v);
    std::uint32_t add_mesh(PreparedMesh mesh);
    /// Places a mesh; `cell` names a square of the ground that the caller chose, any number.
    std::uint32_t add_instance(std::uint32_t mesh, const WorldPos& position, const Mat3& world_from_mesh,
                               std::uint32_t cell);

    /// Sorts instances by cell (stable) and fills cells, bounds, origin, the instances' BVH, prelit colours and the
    /// height grid. Instance ids given out before are void.
    /// @param height_grid_size  squares per side, a power of two in [16, 4096]; 0: left to the caller
    void finish(std::uint32_t height_grid_size = 1024);

    /// Borrowed view; valid until the arrays change.
    [[nodiscard]] StaticScene view() const;
};

/// The BVH over the instances' boxes; leaves of one instance each: child = kBvhLeafBit | instance id. Boxes are
/// relative to `origin` and rounded outwards.
void build_instance_bvh(std::span<const Instance> instances, const WorldPos& origin, std::vector<BvhNode>& nodes);

/// Fills level 0 and all mips of a height grid that covers the scene's bounds: max y of any triangle over each square,
/// conservatively (a triangle counts in every square that its outline touches).
void build_height_grid(const SceneData& scene, std::uint32_t size, HeightGrid& grid, std::vector<float>& heights);

}  // namespace ff::scene
