#pragma once
// One mesh on its way into the pack: gathered from placements, vertices shared, hierarchy built or remembered.

#include <cstdint>
#include <functional>
#include <span>
#include <string>

#include "engine/scene/scene_data.h"
#include "tools/cook/cook_context.h"
#include "tools/cook/world_source.h"

namespace ff::cook {

/// Collects triangles whose vertices are not shared yet.
class MeshGatherer {
  public:
    /// @param origin  positions become relative to it
    explicit MeshGatherer(const DVec3& origin) : origin_(origin) {}

    /// Sets where the next triangles stand. Mirrored placements turn the winding round, so that it faces outwards.
    void place(const DVec3& position, const Mat3& world_from_mesh);
    /// Appends a triangle of `mesh`; false where it has no area (in float32, as it would be drawn).
    bool add(const scene::MeshSource& mesh, std::uint32_t triangle, std::uint16_t material);

    /// What was gathered, equal vertices made one (meshoptimizer). Empties the gatherer.
    [[nodiscard]] scene::MeshSource take();

  private:
    struct Vertex {
        Vec3 position;
        scene::VertexAttributes attributes;
    };
    static_assert(sizeof(Vertex) == 28);  // compared as bytes
    [[nodiscard]] Vertex placed(const Vec3& position, const scene::VertexAttributes& attributes) const;

    DVec3 origin_;
    DVec3 offset_{0.0};
    DMat3 linear_{1.0};
    DMat3 normal_matrix_{1.0};
    bool moves_only_ = true;  // normals stay as they are
    bool mirrors_ = false;
    std::vector<Vertex> vertices_;
    std::vector<std::uint16_t> materials_;
};

struct GatheredMesh {
    scene::MeshSource geometry;
    std::uint64_t dropped_triangles = 0;  ///< without area
};

struct CookedMesh {
    scene::PreparedMesh mesh;  ///< empty where nothing was left to draw
    std::uint64_t dropped_triangles = 0;
};

/// The hash of the materials' part in prepared meshes: their ids in the pack and their flags.
[[nodiscard]] std::string hash_materials(std::span<const std::uint16_t> material_ids,
                                         std::span<const scene::Material> materials);

/// The key of a prepared mesh.
/// @param materials, geometry  hashes of all that the gathered mesh depends on
[[nodiscard]] CacheKey prepared_mesh_key(const std::string& materials, const std::string& geometry);

/// scene::prepare_mesh of what `gather` gives, from the cache where the same was prepared before; then nothing is
/// gathered.
[[nodiscard]] CookedMesh prepare_mesh_cached(const CacheKey& key, const std::function<GatheredMesh()>& gather,
                                             std::span<const scene::Material> materials, CookCache& cache);

}  // namespace ff::cook
