#include "engine/scene/save_world.h"

#include <fmt/format.h>

#include <algorithm>
#include <vector>

#include "engine/core/jobs.h"
#include "engine/scene/animation_chunk.h"
#include "engine/scene/check_world.h"
#include "engine/scene/disk_records.h"
#include "engine/scene/leaf_blocks.h"

namespace ff::scene {
namespace {

Error broken_promise(const std::filesystem::path& path, const WorldProblem& problem) {
    return failure(
        fmt::format("{}: not written: {}[{}]: {}", path.string(), problem.array, problem.element, problem.what));
}

template <class T>
Status add_records(assets::PackWriter& pack, std::string_view name, const std::vector<T>& elements) {
    std::vector<decltype(to_disk(elements[0]))> records(elements.size());
    parallel_ranges(elements.size(), 4096, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) records[i] = to_disk(elements[i]);
    });
    return pack.add(name, std::span<const typename decltype(records)::value_type>(records));
}

template <class T>
Status add_array(assets::PackWriter& pack, std::string_view name, const std::vector<T>& elements) {
    return pack.add(name, std::span<const T>(elements));
}

template <class T, class Record>
std::vector<Record> records_of(const std::vector<T>& elements) {
    std::vector<Record> records(elements.size());
    std::transform(elements.begin(), elements.end(), records.begin(), [](const T& e) { return to_disk(e); });
    return records;
}

flatbuffers::DetachedBuffer world_table(const SceneData& scene, const WorldInfo& info) {
    flatbuffers::FlatBufferBuilder builder;
    std::vector<flatbuffers::Offset<disk::Walk>> walks;
    for (const Walk& walk : info.walks) {
        const auto name = builder.CreateString(walk.name);
        const auto frames = builder.CreateVectorOfStructs(records_of<WalkFrame, disk::WalkFrame>(walk.frames));
        walks.push_back(disk::CreateWalk(builder, name, walk.fov_deg, walk.rate_hz, frames));
    }
    std::vector<flatbuffers::Offset<disk::NamedPlace>> places;
    for (const NamedPlace& place : info.places) {
        const auto name = builder.CreateString(place.name);
        const disk::DVec3 position = to_disk(place.position);
        places.push_back(disk::CreateNamedPlace(builder, name, &position, place.yaw, place.first_instance,
                                                place.instance_count, place.first_animated, place.animated_count));
    }
    // A world without any is written as before there were any.
    const auto place_list = places.empty() ? 0 : builder.CreateVector(places);
    const auto name = builder.CreateString(info.name);
    const auto dynamic_instances =
        builder.CreateVectorOfStructs(records_of<DynamicInstance, disk::DynamicInstance>(info.dynamic_instances));
    const auto lamps = builder.CreateVectorOfStructs(records_of<Lamp, disk::Lamp>(scene.lamps));
    const auto walk_list = builder.CreateVector(walks);
    std::vector<flatbuffers::Offset<disk::SoundClip>> clips;
    for (const SoundClip& clip : info.sounds.clips) {
        const auto clip_name = builder.CreateString(clip.name);
        clips.push_back(disk::CreateSoundClip(builder, clip_name, clip.rate_hz, builder.CreateVector(clip.samples)));
    }
    const auto clip_list = clips.empty() ? 0 : builder.CreateVector(clips);
    const auto sources =
        clips.empty() ? 0
                      : builder.CreateVectorOfStructs(records_of<SoundSource, disk::SoundSource>(info.sounds.sources));
    const auto flocks =
        info.flocks.empty() ? 0 : builder.CreateVectorOfStructs(records_of<Flock, disk::Flock>(info.flocks));
    const auto loose_bodies =
        info.loose_bodies.empty()
            ? 0
            : builder.CreateVectorOfStructs(records_of<LooseBody, disk::LooseBody>(info.loose_bodies));
    const disk::DVec3 origin = to_disk(scene.origin);
    const disk::DBox3 bounds = to_disk(scene.bounds);
    const disk::HeightGrid grid = to_disk(scene.height_grid);
    const disk::Environment environment = to_disk(scene.environment);
    const disk::DVec3 spawn = to_disk(info.spawn_position);
    disk::FinishWorldBuffer(
        builder, disk::CreateWorld(builder, name, &origin, &bounds, &grid, &environment, &spawn, info.spawn_yaw,
                                   info.source_bytes, dynamic_instances, walk_list, scene.environment.sun_shadows,
                                   scene.environment.atmosphere.turbidity, scene.environment.atmosphere.brightness,
                                   scene.environment.weather.rain, scene.environment.weather.snow,
                                   scene.environment.weather.wind_m_s.x, scene.environment.weather.wind_m_s.y, lamps,
                                   place_list, clip_list, sources, flocks, loose_bodies));
    return builder.Release();
}

}  // namespace

Result<std::uint64_t> write_world(const std::filesystem::path& path, const SceneData& scene, const WorldInfo& info,
                                  assets::Compression compression) {
    const StaticScene view = scene.view();
    if (const auto problem = find_world_problem(view, info, view.mesh_leaves.size()))
        return broken_promise(path, *problem);
    std::vector<std::uint8_t> leaf_sizes(view.mesh_leaves.size());
    std::transform(view.mesh_leaves.begin(), view.mesh_leaves.end(), leaf_sizes.begin(),
                   [](const BvhLeaf& leaf) { return static_cast<std::uint8_t>(leaf.triangle_count); });
    if (const auto problem = compare_leaf_blocks(view, leaf_sizes)) return broken_promise(path, *problem);

    FF_ASSIGN(assets::PackWriter pack, assets::PackWriter::create(path, compression));
    const flatbuffers::DetachedBuffer table = world_table(scene, info);
    FF_TRY(pack.add("world", std::span<const std::uint8_t>(table.data(), table.size())));
    FF_TRY(add_records(pack, "meshes", scene.meshes));
    FF_TRY(add_records(pack, "instances", scene.instances));
    FF_TRY(add_records(pack, "cells", scene.cells));
    FF_TRY(add_records(pack, "materials", scene.materials));
    FF_TRY(add_records(pack, "textures", scene.textures));
    FF_TRY(add_array(pack, "positions", scene.positions));
    FF_TRY(add_array(pack, "attributes", scene.attributes));
    FF_TRY(add_array(pack, "indices", scene.indices));
    FF_TRY(add_array(pack, "triangle_materials", scene.triangle_materials));
    FF_TRY(add_array(pack, "prelit_colors", scene.prelit_colors));
    FF_TRY(add_array(pack, "texels", scene.texels));
    FF_TRY(add_array(pack, "mesh_nodes", scene.mesh_nodes));
    FF_TRY(add_array(pack, "mesh_leaves", leaf_sizes));
    FF_TRY(add_array(pack, "instance_nodes", scene.instance_nodes));
    FF_TRY(add_array(pack, "heights", scene.heights));
    FF_TRY(add_array(pack, "sky_panorama", scene.sky_panorama));
    if (!info.animation.models.empty()) FF_TRY(add_array(pack, "animation", animation_to_bytes(info.animation)));
    return pack.finish();
}

}  // namespace ff::scene
