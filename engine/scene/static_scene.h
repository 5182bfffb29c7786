#pragma once
// The static world as the casters, the shading pass and the rasteriser read it: flat arrays, addressed by ids.
//
//   Instance --mesh--> Mesh --[first_triangle, +count)--> triangles --indices--> vertices
//                                                             `--triangle_materials--> Material --> Texture
//
// A cell's own geometry (terrain, buildings, models placed once) is one mesh whose only instance sits at the cell's
// origin unrotated; scattered models are meshes with many instances. So all geometry is float32 relative to an origin
// nearby, and only instances know where in the world they are (design.md section 3).
//
// A visible point is named by (instance, triangle), triangle counted within the mesh.

#include <cstdint>
#include <span>
#include <vector>

#include "engine/math/bounds.h"
#include "engine/math/types.h"
#include "engine/scene/bvh.h"
#include "engine/scene/environment.h"
#include "engine/scene/lamp.h"

namespace ff::scene {

/// What a vertex carries beside its position. 16 bytes, one cache line holds four.
struct VertexAttributes {
    std::int16_t normal_oct[2];  ///< octahedral, snorm16, mesh space; see encode_normal
    Vec2 uv;                     ///< after KHR_texture_transform
    std::uint32_t color;         ///< RGBA8, linear, r in the low byte; white where the mesh has none
};
static_assert(sizeof(VertexAttributes) == 16);

enum MaterialFlags : std::uint32_t {
    kMaterialAlphaMask = 1u << 0,    ///< a hit needs alpha >= alpha_cutoff
    kMaterialBlend = 1u << 1,        ///< coverage: near sorted, far by a hashed cutoff
    kMaterialUnlit = 1u << 2,        ///< KHR_materials_unlit
    kMaterialDoubleSided = 1u << 3,  ///< else back faces are still hit, but shaded with the flipped normal
    kMaterialSpecular = 1u << 4,     ///< rough or metallic enough that a highlight shows; else diffuse only
    kMaterialWater = 1u << 5,        ///< open water: waves, and mirrors what is around it
    kMaterialMirror = 1u << 6,       ///< smooth enough to mirror what is around it
    kMaterialSways = 1u << 7,        ///< foliage: wind moves its pictures (math/leaf_sway.h); masked ones only
};

inline constexpr std::uint32_t kNoTexture = 0xFFFFFFFFu;

struct Material {
    Vec4 base_color{1.0f};      ///< linear, times texture, times vertex colour
    Vec3 emissive{0.0f};        ///< linear, times texture
    float alpha_cutoff = 0.5f;  ///< of water, which is opaque: height of its waves in a breeze, metres
    float metallic = 0.0f;      ///< [0, 1]; water: 0
    float roughness = 1.0f;     ///< [0, 1]
    std::uint32_t base_color_texture = kNoTexture;
    std::uint32_t emissive_texture = kNoTexture;
    std::uint32_t metallic_roughness_texture = kNoTexture;
    std::uint32_t flags = 0;

    /// Water: slopes of its waves, as shares of those of waves a tenth of a metre high.
    [[nodiscard]] float wave_strength() const { return 10.0f * alpha_cutoff; }
};

/// Whether it shows what is around it.
[[nodiscard]] inline bool is_mirror(const Material& material) {
    return (material.flags & kMaterialSpecular) != 0 && (material.flags & (kMaterialWater | kMaterialMirror)) != 0;
}
/// Whether a cooker should make it kMaterialMirror: glass, polished metal.
[[nodiscard]] inline bool is_smooth(const Material& material) {
    constexpr float kRoughness = 0.2f;
    return (material.flags & kMaterialSpecular) != 0 && (material.flags & kMaterialBlend) == 0 &&
           material.metallic_roughness_texture == kNoTexture && material.roughness <= kRoughness;
}

enum class Wrap : std::uint8_t { repeat, clamp, mirror };

/// A texture and its mips, all in one texel array: RGBA8, colour sRGB-encoded, alpha linear; rows top to bottom as
/// glTF's v grows downwards. Level l is max(1, width >> l) x max(1, height >> l); the last level is 1 x 1.
struct Texture {
    std::uint32_t width = 0, height = 0;  ///< powers of two, [1, 8192]; the cooker resizes
    std::uint32_t level_count = 0;
    Wrap wrap_u = Wrap::repeat, wrap_v = Wrap::repeat;
    std::uint64_t first_texel = 0;  ///< of level 0 in StaticScene::texels; levels follow each other
};

struct Mesh {
    std::uint32_t first_vertex = 0, vertex_count = 0;
    std::uint32_t first_triangle = 0, triangle_count = 0;
    std::uint32_t first_node = 0, node_count = 0;  ///< its BVH, relative ids inside; see bvh.h
    std::uint32_t first_leaf = 0, leaf_count = 0;
    Box3 bounds;
    std::uint32_t material_flags = 0;  ///< union over its triangles
};

/// A mesh placed in the world.
struct Instance {
    WorldPos position{0.0};      ///< of the mesh's origin
    Mat3 world_from_mesh{1.0f};  ///< rotation, scale, mirror; never singular
    std::uint32_t mesh = 0;
    std::uint32_t cell = 0;
    DBox3 bounds;  ///< world
};

/// A square of the ground, the unit of culling and of the near field.
struct Cell {
    WorldPos origin{0.0};
    DBox3 bounds;                      ///< of all its instances, world
    std::uint32_t first_instance = 0;  ///< instances are sorted by cell
    std::uint32_t instance_count = 0;
    std::uint64_t triangle_count = 0;  ///< as drawn, instances counted each time
};

/// Height of the world above each square of a grid, and its max-mipmap, for horizon tracing (P0 section 6).
/// Level 0 is size x size squares; level l has size >> l; row-major along x, z growing with the row.
struct HeightGrid {
    std::uint32_t size = 0;       ///< squares per side, a power of two; 0: no grid
    double low_x = 0, low_z = 0;  ///< world position of the corner of square (0, 0)
    double square_m = 1.0;
    double base_y = 0;               ///< heights are relative to it
    std::span<const float> heights;  ///< max y of anything in the square, -inf where empty; all levels, level 0 first
};

/// Everything static, borrowed from whoever owns the arrays (SceneData or a loaded pack); read-only, any thread.
struct StaticScene {
    WorldPos origin{0.0};  ///< a point near the middle, whole metres; float scene-wide structures are relative to it
    DBox3 bounds;
    std::span<const Vec3> positions;
    std::span<const VertexAttributes> attributes;       ///< same length as positions
    std::span<const std::uint32_t> indices;             ///< 3 per triangle, relative to the mesh's first_vertex
    std::span<const std::uint16_t> triangle_materials;  ///< 1 per triangle
    std::span<const std::uint32_t> prelit_colors;       ///< 1 per triangle: mean base colour, RGBA8 linear (P1 4.6)
    std::span<const Mesh> meshes;
    /// The last so many meshes are poses (pose_room.h): what they hold changes between frames, no instance of
    /// `instances` is one, and their triangles are another mesh's.
    std::uint32_t posed_mesh_count = 0;
    std::span<const Instance> instances;
    std::span<const Cell> cells;
    std::span<const Material> materials;
    std::span<const Texture> textures;
    std::span<const std::uint32_t> texels;
    std::span<const BvhNode> mesh_nodes;  ///< of all meshes
    std::span<const BvhLeaf> mesh_leaves;
    std::span<const BvhNode> instance_nodes;  ///< one BVH over the instances, boxes relative to origin
    HeightGrid height_grid;
    Environment environment;
    std::span<const Lamp> lamps;
};

}  // namespace ff::scene
