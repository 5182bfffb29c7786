#include <fmt/format.h>

#include <cstdio>
#include <nlohmann/json.hpp>

#include "engine/assets/pack_reader.h"
#include "engine/scene/load_world.h"
#include "tools/ff/session.h"

namespace ff::tool {

Status run_info(const InfoOptions& options) {
    FF_ASSIGN(const std::filesystem::path pack, pack_of(options.pack));
    FF_ASSIGN(const assets::PackReader reader, assets::PackReader::open(pack));
    FF_ASSIGN(const std::unique_ptr<scene::World> world, scene::load_world(reader));
    const scene::StaticScene& scene = world->scene();
    const scene::WorldStatistics& statistics = world->statistics();

    nlohmann::json chunks = nlohmann::json::array();
    for (const auto& chunk : reader.chunks())
        chunks.push_back({{"name", chunk.name},
                          {"elements", chunk.element_count},
                          {"raw_bytes", chunk.raw_bytes()},
                          {"stored_bytes", chunk.stored_bytes}});
    nlohmann::json walks = nlohmann::json::array();
    for (const scene::Walk& walk : world->info().walks)
        walks.push_back({{"name", walk.name},
                         {"frames", walk.frames.size()},
                         {"fov_deg", walk.fov_deg},
                         {"rate_hz", walk.rate_hz}});
    nlohmann::json animated = nlohmann::json::array();
    for (const scene::AnimatedModel& model : world->info().animation.models) {
        nlohmann::json clips = nlohmann::json::array();
        for (const scene::Clip& clip : model.clips)
            clips.push_back({{"name", clip.name}, {"seconds", clip.duration_s}});
        animated.push_back({{"name", model.name},
                            {"joints", model.skeleton.size()},
                            {"rigid_parts", model.parts.size()},
                            {"skins", model.skins.size()},
                            {"clips", clips}});
    }
    const auto vector = [](const DVec3& v) { return nlohmann::json{v.x, v.y, v.z}; };
    const nlohmann::json info{{"name", world->info().name},
                              {"pack_bytes", reader.file_bytes()},
                              {"memory_bytes", statistics.memory_bytes},
                              {"triangles", statistics.triangles},
                              {"instanced_triangles", statistics.instanced_triangles},
                              {"vertices", statistics.vertices},
                              {"meshes", scene.meshes.size() - scene.posed_mesh_count},
                              {"instances", scene.instances.size()},
                              {"dynamic_instances", world->info().dynamic_instances.size()},
                              {"animated_instances", world->info().animation.instances.size()},
                              {"animated_models", animated},
                              {"cells", scene.cells.size()},
                              {"materials", scene.materials.size()},
                              {"textures", scene.textures.size()},
                              {"texels", scene.texels.size()},
                              {"bounds_m", {vector(scene.bounds.low), vector(scene.bounds.high)}},
                              {"spawn_m", vector(world->info().spawn_position)},
                              {"walks", walks},
                              {"chunks", chunks}};
    if (options.json) {
        std::printf("%s\n", info.dump(2).c_str());
        return {};
    }

    std::string text = fmt::format(
        "{}: {:.1f} MB, {:.1f} MB in memory\n  {} triangles stored, {} as drawn; {} vertices\n"
        "  {} cells, {} meshes, {} instances ({} that move, {} animated), {} materials, {} textures\n"
        "  from ({:.0f}, {:.0f}, {:.0f}) to ({:.0f}, {:.0f}, {:.0f}) m\n  walks:",
        world->info().name, 1e-6 * double(reader.file_bytes()), 1e-6 * double(statistics.memory_bytes),
        statistics.triangles, statistics.instanced_triangles, statistics.vertices, scene.cells.size(),
        scene.meshes.size() - scene.posed_mesh_count, scene.instances.size(), world->info().dynamic_instances.size(),
        world->info().animation.instances.size(), scene.materials.size(), scene.textures.size(), scene.bounds.low.x,
        scene.bounds.low.y, scene.bounds.low.z, scene.bounds.high.x, scene.bounds.high.y, scene.bounds.high.z);
    for (const scene::Walk& walk : world->info().walks)
        text += fmt::format(" {} ({} frames)", walk.name, walk.frames.size());
    for (const scene::AnimatedModel& model : world->info().animation.models) {
        text += fmt::format("\n  animated {}:", model.name);
        for (const scene::Clip& clip : model.clips) text += fmt::format(" {} ({:.1f} s)", clip.name, clip.duration_s);
    }
    std::printf("%s\n", text.c_str());
    return {};
}

}  // namespace ff::tool
