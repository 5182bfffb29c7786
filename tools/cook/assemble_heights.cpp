#include "tools/cook/assemble_heights.h"

#include "tools/cook/cook_bytes.h"

namespace ff::cook {
namespace {

// Bump when build_height_grid gives something else for the same scene.
constexpr const char* kStep = "height grid 1";

}  // namespace

void add_height_grid(std::uint32_t size, const std::string& geometry, std::span<const std::string> mesh_keys,
                     CookCache& cache, scene::SceneData& scene) {
    if (!cache.enabled()) return scene::build_height_grid(scene, size, scene.height_grid, scene.heights);
    std::string meshes;
    for (const std::string& key : mesh_keys) meshes += key;
    const CacheKey key = CacheKey(kStep).add_value(size).add(geometry).add(meshes);
    scene::HeightGrid& grid = scene.height_grid;
    if (const auto found = cache.find(key)) {
        ByteReader in(*found);
        in.value(grid.size);
        in.value(grid.low_x);
        in.value(grid.low_z);
        in.value(grid.square_m);
        in.value(grid.base_y);
        in.array(scene.heights);
        return;
    }
    scene::build_height_grid(scene, size, grid, scene.heights);
    ByteWriter out;
    out.value(grid.size);
    out.value(grid.low_x);
    out.value(grid.low_z);
    out.value(grid.square_m);
    out.value(grid.base_y);
    out.array(scene.heights);
    cache.store(key, out.bytes());
}

}  // namespace ff::cook
