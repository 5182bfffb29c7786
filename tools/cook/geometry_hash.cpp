#include "tools/cook/geometry_hash.h"

#include "engine/core/jobs.h"
#include "tools/cook/cook_cache.h"

namespace ff::cook {
namespace {

void hash_meshes(WorldSource& world) {
    parallel_for(world.meshes.size(), [&](std::size_t m) {
        SourceMesh& mesh = world.meshes[m];
        if (!mesh.content_hash.empty()) return;
        mesh.content_hash = CacheKey("mesh")
                                .add_array(mesh.geometry.positions)
                                .add_array(mesh.geometry.attributes)
                                .add_array(mesh.geometry.indices)
                                .add_array(mesh.geometry.triangle_materials)
                                .hex();
    });
}

}  // namespace

std::string hash_geometry(WorldSource& world) {
    hash_meshes(world);
    std::string meshes;
    for (const SourceMesh& mesh : world.meshes) meshes += mesh.content_hash;
    struct Place {
        DVec3 position;
        Mat3 world_from_mesh;
        std::uint32_t mesh;
    };
    static_assert(sizeof(Place) == 64);  // no padding
    std::vector<Place> places;
    std::vector<PlacementKind> kinds;
    places.reserve(world.placements.size());
    kinds.reserve(world.placements.size());
    for (const Placement& placement : world.placements) {
        places.push_back({placement.position, placement.world_from_mesh, placement.mesh});
        kinds.push_back(placement.kind);
    }
    return CacheKey("geometry").add(meshes).add_array(places).add_array(kinds).hex();
}

}  // namespace ff::cook
