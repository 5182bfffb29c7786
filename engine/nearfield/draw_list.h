#pragma once
// From visible instances to what OpenGL is told: transforms relative to the camera, and indirect draw commands sorted
// by material. Plain data, made without a GPU.

#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "engine/math/camera.h"
#include "engine/nearfield/mesh_layout.h"
#include "engine/scene/static_scene.h"

namespace ff::nearfield {

/// What is to be drawn, front to back where the caller knows (early depth tests then save shading).
struct DrawSet {
    std::span<const std::uint32_t> instances;  ///< ids; from StaticScene::instances.size() on, of `dynamic`
    std::span<const scene::Instance> dynamic;  ///< instances that move; meshes of the scene
    /// Nothing that is nearer to the viewer than this is missing from the set. What it holds of things farther away may
    /// have others before it that it does not hold.
    double complete_within_m = std::numeric_limits<double>::infinity();
    const scene::Environment* environment = nullptr;  ///< light and air; nullptr: the scene's
};

/// One instance as the vertex shader reads it: instanced attributes, 64 bytes.
struct InstanceRecord {
    float relative_from_mesh[3][4];    ///< rows of the affine transform to axes of the world, origin at the camera
    std::uint32_t instance = 0;        ///< id
    std::uint32_t first_triangle = 0;  ///< of the drawn range, within the mesh, GPU order
    std::uint32_t first_name = ~0u;    ///< in SceneLayout::reordered, of the mesh; ~0: its triangles are in scene order
    std::uint32_t padding = 0;
};
static_assert(sizeof(InstanceRecord) == 64);

/// As glMultiDrawElementsIndirect reads it.
struct DrawCommand {
    std::uint32_t index_count = 0;
    std::uint32_t instance_count = 0;
    std::uint32_t first_index = 0;
    std::int32_t base_vertex = 0;
    std::uint32_t base_instance = 0;
};
static_assert(sizeof(DrawCommand) == 20);

/// Commands that share a material, so one multi-draw.
struct DrawBatch {
    static constexpr std::uint32_t kAnyOpaque = ~0u;
    std::uint32_t material = kAnyOpaque;  ///< kAnyOpaque: positions are all that matters
    std::uint32_t first_command = 0, command_count = 0;
};

/// A run of blended triangles of one instance, drawn by itself, far ones first.
struct BlendedDraw {
    std::uint32_t record = 0;
    std::uint32_t group = 0;  ///< of SceneLayout::groups
    std::uint32_t mesh = 0;
    float distance_m = 0.0f;  ///< from the camera to the middle of the instance's box
};

struct DrawList {
    std::vector<InstanceRecord> records;
    std::vector<DrawCommand> commands;
    std::vector<DrawBatch> batches;    ///< opaque ones, then masked
    std::vector<BlendedDraw> blended;  ///< back to front
    std::uint64_t triangle_count = 0;  ///< of all commands and blended draws, instances counted each time

    // Scratch, kept so that steady frames allocate nothing.
    std::vector<std::uint32_t> mesh_order, mesh_first_record, mesh_count, material_commands, material_next;
};

/// The list that draws a shaded picture: every material by itself.
/// @param draw_order  materials in the order in which their batches should run (least state changes); all of them
void make_shaded_draw_list(const scene::StaticScene& scene, const SceneLayout& layout, const DrawSet& set,
                           const WorldPos& camera, std::span<const std::uint32_t> draw_order, DrawList& out);

/// The list that finds visibility: all opaque triangles of a mesh at once, the rest by material (alpha decides there).
void make_id_draw_list(const scene::StaticScene& scene, const SceneLayout& layout, const DrawSet& set,
                       const WorldPos& camera, DrawList& out);

}  // namespace ff::nearfield
