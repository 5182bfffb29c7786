#include "tools/cook/cook.h"

#include <fmt/format.h>

#include <cctype>
#include <nlohmann/json.hpp>
#include <system_error>

#include "engine/core/jobs.h"
#include "engine/core/stopwatch.h"
#include "engine/scene/save_world.h"
#include "tools/cook/cook_copies.h"
#include "tools/cook/gltf_import.h"
#include "tools/cook/scene_toml.h"
#include "tools/cook/walks.h"

namespace ff::cook {
namespace {

// A bare model stands at its own coordinates. What it shows once becomes part of the cells; what it repeats stays an
// instance.
Result<WorldSource> load_model_as_world(const std::filesystem::path& path, int scale, CookContext& context) {
    WorldSource world;
    FF_ASSIGN(const Model model, import_gltf(path, world, context));
    world.name = model.name;
    for (const ModelPart& part : model.parts)
        world.placements.push_back({.mesh = part.mesh,
                                    .position = part.position,
                                    .world_from_mesh = Mat3(part.model_from_mesh),
                                    .kind = part.use_count > 1 ? PlacementKind::instance : PlacementKind::merge});
    if (model.triangle_count == 0)
        return bad_input(fmt::format("{}: no triangles in its scene; expected some to draw", path.string()));
    copy_static_content(world, model.bounds, scale);
    context.end_stage("read model");
    add_spawn_and_walks(world, false, context.cache());
    context.end_stage("walks");
    return world;
}

std::string lower_case_extension(const std::filesystem::path& path) {
    std::string extension = path.extension().string();
    for (char& c : extension) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    return extension;
}

void count_scene(const Assembly& assembly, CookReport& report) {
    const scene::SceneData& scene = assembly.scene;
    report.triangles_stored = scene.triangle_materials.size();
    for (const scene::Instance& instance : scene.instances)
        report.triangles_instanced += scene.meshes[instance.mesh].triangle_count;
    for (const scene::DynamicInstance& instance : assembly.info.dynamic_instances)
        report.triangles_instanced += scene.meshes[instance.mesh].triangle_count;
    report.triangles_dropped = assembly.dropped_triangles;
    report.coincident = assembly.coincident;
    report.vertices = scene.positions.size();
    report.textures = scene.textures.size();
    report.texels = scene.texels.size();
    report.materials = scene.materials.size();
    report.meshes = scene.meshes.size();
    report.instances = scene.instances.size();
    report.cells = scene.cells.size();
    report.dynamic_instances = assembly.info.dynamic_instances.size();
}

}  // namespace

Result<WorldSource> load_source(const std::filesystem::path& source, int scale, CookContext& context) {
    const std::string extension = lower_case_extension(source);
    if (extension == ".toml") return load_scene_toml(source, {.scale = scale}, context);
    if (extension == ".gltf" || extension == ".glb") return load_model_as_world(source, scale, context);
    return bad_input(fmt::format("{}: ending `{}`; expected .toml, .gltf or .glb", source.string(), extension));
}

Result<CookReport> cook(const std::filesystem::path& source, const std::filesystem::path& out,
                        const CookSettings& settings) {
    if (settings.scale < 1 || settings.scale > 1000)
        return usage_error(fmt::format("scale {}; expected 1 to 1000", settings.scale));
    // Said now rather than after minutes of work.
    std::error_code error;
    const std::filesystem::path folder = out.has_parent_path() ? out.parent_path() : std::filesystem::path(".");
    if (!std::filesystem::is_directory(folder, error))
        return failure(fmt::format("{}: no such folder; expected one for the pack", folder.string()));
    if (std::filesystem::equivalent(source, out, error))
        return usage_error(fmt::format("{}: source and pack at once; expected two files", out.string()));
    const WorkerLimit limit(settings.jobs);
    const Stopwatch whole;
    CookReport report;
    report.source = source.string();
    report.pack = out.string();
    CookCache cache(!settings.use_cache          ? std::filesystem::path()
                    : settings.cache_dir.empty() ? CookCache::default_directory()
                                                 : settings.cache_dir,
                    settings.cache_limit_bytes);
    CookContext context(cache);

    FF_ASSIGN(WorldSource world, load_source(source, settings.scale, context));
    world.bytes_in = context.bytes_in();
    report.bytes_in = world.bytes_in;
    for (const std::filesystem::path& input : context.inputs()) report.inputs.push_back(input.string());
    FF_ASSIGN(const Assembly assembly, assemble(std::move(world), {}, context));
    count_scene(assembly, report);
    FF_ASSIGN(report.bytes_out, scene::write_world(out, assembly.scene, assembly.info));
    context.end_stage("write pack");
    cache.trim();

    report.cache_hits = cache.hits();
    report.cache_misses = cache.misses();
    report.warnings = context.warnings();
    report.stages = context.stages();
    report.seconds = whole.seconds();
    return report;
}

double CookReport::megabytes_per_second() const {
    return seconds > 0 ? static_cast<double>(bytes_in + bytes_out) * 1e-6 / seconds : 0.0;
}

std::string CookReport::to_json() const {
    nlohmann::ordered_json json;
    json["source"] = source;
    json["pack"] = pack;
    json["triangles"] = triangles_stored;
    json["instanced_triangles"] = triangles_instanced;
    json["dropped_triangles"] = triangles_dropped;
    json["coincident"] = {{"dropped_triangles", coincident.dropped_triangles},
                          {"separated_triangles", coincident.separated_triangles},
                          {"dropped_placements", coincident.dropped_placements},
                          {"moved_placements", coincident.moved_placements}};
    json["vertices"] = vertices;
    json["textures"] = textures;
    json["texels"] = texels;
    json["materials"] = materials;
    json["meshes"] = meshes;
    json["instances"] = instances;
    json["dynamic_instances"] = dynamic_instances;
    json["cells"] = cells;
    json["bytes_in"] = bytes_in;
    json["inputs"] = inputs;
    json["bytes_out"] = bytes_out;
    json["seconds"] = seconds;
    json["mb_per_s"] = megabytes_per_second();
    json["stages_s"] = nlohmann::ordered_json::object();
    for (const CookStage& stage : stages) json["stages_s"][stage.name] = stage.seconds;
    json["cache"] = {{"hits", cache_hits}, {"misses", cache_misses}};
    json["warnings"] = warnings;
    return json.dump(2, ' ', false, nlohmann::json::error_handler_t::replace);
}

std::string CookReport::to_text() const {
    std::string text = fmt::format(
        "{}: {} triangles stored, {} as drawn ({} without area left out), {} vertices, {} textures, {} materials\n"
        "in one plane with others: {} triangles and {} placements dropped, {} and {} moved apart\n"
        "{} cells, {} meshes, {} instances, {} dynamic\n"
        "{:.1f} MB in, {:.1f} MB out, {:.2f} s, {:.1f} MB/s; cache: {} hits, {} misses\n",
        pack, triangles_stored, triangles_instanced, triangles_dropped, vertices, textures, materials,
        coincident.dropped_triangles, coincident.dropped_placements, coincident.separated_triangles,
        coincident.moved_placements, cells, meshes, instances, dynamic_instances, static_cast<double>(bytes_in) * 1e-6,
        static_cast<double>(bytes_out) * 1e-6, seconds, megabytes_per_second(), cache_hits, cache_misses);
    for (const CookStage& stage : stages) text += fmt::format("  {:<14} {:7.2f} s\n", stage.name, stage.seconds);
    return text;
}

}  // namespace ff::cook
