#pragma once
// glTF 2.0 models (.gltf, .glb) to plain meshes, materials, textures and the places where they stand.

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "engine/core/result.h"
#include "engine/math/bounds.h"
#include "engine/math/types.h"
#include "tools/cook/cook_context.h"
#include "tools/cook/world_source.h"

namespace ff::cook {

/// One mesh of a model where the model's scene puts it (node hierarchy and instancing flattened).
struct ModelPart {
    std::uint32_t mesh = 0;       ///< WorldSource::meshes
    DVec3 position{0.0};          ///< model space
    DMat3 model_from_mesh{1.0};   ///< rotation, scale, mirror; never singular
    std::uint32_t use_count = 1;  ///< parts of this model that share the mesh
};

struct Model {
    std::string name;  ///< file name without its ending
    std::vector<ModelPart> parts;
    DBox3 bounds;                      ///< of all parts, model space; empty for an empty model
    std::uint64_t triangle_count = 0;  ///< as drawn: a mesh counts in every part
    /// WorldSource::animation.models: then it moves of itself, and has no parts.
    std::optional<std::uint32_t> animated;
};

enum class ModelKind : std::uint8_t {
    still,     ///< in its rest pose; skins as they are bound, with a warning
    animated,  ///< with skeleton, clips and skins, where it has any
};

/// Appends a model's textures, materials and meshes to `into` (no placements) and says where its parts stand.
///
/// Read: all primitive modes that make triangles, all component types, sparse and interleaved accessors, data and
/// relative URIs inside the model's folder, vertex colours, alpha modes; KHR_draco_mesh_compression,
/// KHR_mesh_quantization, KHR_texture_transform, KHR_materials_unlit, KHR_materials_emissive_strength,
/// KHR_materials_pbrSpecularGlossiness (its diffuse part), EXT_mesh_gpu_instancing, EXT_texture_webp,
/// EXT_meshopt_compression. Warned about and left out: points and lines, morph targets, skins and animations of still
/// models, and optional extensions that are not known.
/// Missing normals become flat ones; mirrored parts keep their winding in mesh space (model_from_mesh mirrors).
///
/// Errors: bad_input `FILE: PLACE: found; expected ...` for anything that breaks the format, requires an unknown
/// extension, or would read beyond its buffer; `into` is then unchanged.
/// Images are cached by their bytes; the rest reads about a million triangles a second. Threads: one import at a time
/// into one WorldSource; parallel inside.
[[nodiscard]] Result<Model> import_gltf(const std::filesystem::path& path, WorldSource& into, CookContext& context,
                                        ModelKind kind = ModelKind::still);

/// Places every part of a still model in the world: world_from_model * part. Kind `merge` for static things placed
/// once.
/// @param stands_clear  see Placement; set for what is scattered
void place_model(const Model& model, const DVec3& position, const DMat3& world_from_model, PlacementKind kind,
                 WorldSource& into, bool stands_clear = false);

}  // namespace ff::cook
