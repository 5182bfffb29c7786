#include "tools/cook/scene_toml.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <glm/matrix.hpp>
#include <map>
#include <memory>

#include "engine/core/log.h"
#include "engine/math/bounds.h"
#include "tools/cook/buildings_facade.h"
#include "tools/cook/cook_copies.h"
#include "tools/cook/foliage.h"
#include "tools/cook/gltf_import.h"
#include "tools/cook/ground_surface.h"
#include "tools/cook/image_load.h"
#include "tools/cook/mesh_builder.h"
#include "tools/cook/scatter.h"
#include "tools/cook/scene_toml_description.h"
#include "tools/cook/sky_image.h"
#include "tools/cook/terrain_cache.h"
#include "tools/cook/town_ground.h"
#include "tools/cook/walks.h"
#include "tools/cook/wave_file.h"

namespace ff::cook {
namespace {

/// Builds the world of one description, part by part, in the order in which they stand on each other.
class SceneBuilder {
  public:
    SceneBuilder(const SceneDescription& scene, int scale, CookContext& context)
        : scene_(scene), scale_(scale), context_(context), frame_(scene.frame) {}

    Result<WorldSource> build() {
        world_.name = scene_.name;
        world_.environment = scene_.environment;
        if (!scene_.sky_panorama.empty()) {
            FF_TRY(load_sky_panorama(scene_.sky_panorama, world_));
            context_.add_input(scene_.sky_panorama);
        }
        FF_TRY(add_ground());
        context_.end_stage("ground");
        // What says its height itself may be the ground that others stand on, wherever in the file it is written.
        FF_TRY(add_models([](const ModelDescription& m) { return m.position_m.size() == 3 && !m.dynamic; }));
        FF_TRY(add_all_buildings());
        context_.end_stage("buildings");
        FF_TRY(add_models([](const ModelDescription& m) { return m.position_m.size() == 2 && !m.dynamic; }));
        FF_TRY(add_models([](const ModelDescription& m) { return m.dynamic; }));
        add_places();
        ground_end_ = world_.placements.size();
        FF_TRY(add_scatters());
        FF_TRY(add_lamps());
        FF_TRY(add_sounds());
        if (scale_ > 1 && !scene_.town) copy_static_content(world_, static_bounds(), scale_);
        context_.end_stage("models");
        set_spawn();
        FF_TRY(add_walks());
        if (world_.placements.empty()) return bad_input("holds nothing to draw; expected terrain, buildings or models");
        add_spawn_and_walks(world_, scene_.spawn.has_value(), context_.cache());
        context_.end_stage("walks");
        return std::move(world_);
    }

  private:
    Result<std::uint32_t> texture(const std::filesystem::path& path) {
        const auto [place, is_new] = textures_.try_emplace(path.string(), std::uint32_t(world_.textures.size()));
        if (is_new) {
            FF_ASSIGN(SourceTexture loaded, load_texture(path, context_));
            world_.textures.push_back(std::move(loaded));
        }
        return place->second;
    }

    /// A rough material; without a texture where the path is empty.
    Result<std::uint32_t> material(const std::filesystem::path& path, const Vec3& color, float roughness = 1.0f) {
        scene::Material made;
        made.base_color = Vec4(color, 1.0f);
        made.roughness = roughness;
        if (roughness < 0.5f) made.flags |= scene::kMaterialSpecular;
        if (scene::is_smooth(made)) made.flags |= scene::kMaterialMirror;
        if (!path.empty()) {
            FF_ASSIGN(made.base_color_texture, texture(path));
        }
        world_.materials.push_back(made);
        return std::uint32_t(world_.materials.size() - 1);
    }

    Result<const Model*> model(const std::filesystem::path& path, ModelKind kind = ModelKind::still) {
        const auto [place, is_new] = models_.try_emplace({path.string(), kind});
        if (is_new) {
            FF_ASSIGN(place->second, import_gltf(path, world_, context_, kind));
        }
        return &place->second;
    }

    Status add_ground() {
        if (!scene_.terrain && !scene_.town) return {};
        HeightField field;
        const bool has_terrain = scene_.terrain.has_value();
        if (has_terrain && scene_.terrain->valley) {
            field = make_valley_cached(*scene_.terrain->valley, context_.cache());
        } else if (has_terrain) {
            FF_ASSIGN(field, read_height_file(scene_.terrain->heightmap, scene_.terrain->file, frame_));
            context_.add_input(scene_.terrain->heightmap);
        }
        std::vector<RectXZ> exact;
        if (scene_.town) {
            context_.end_stage("heights");
            FF_TRY(add_town([&](double x, double z) { return has_terrain ? field.sample(x, z) : 0.0; }));
            context_.end_stage("town");
            if (has_terrain) {
                shape_ground(field, *town_ground_, site_.blocks);
                exact = bounds_of(site_.blocks, 2 * std::max(field.spacing_x, field.spacing_z));
            }
        }
        if (!has_terrain) return {};
        const TerrainDescription& terrain = *scene_.terrain;
        if (terrain.water_m) waters_.push_back({.level_m = *terrain.water_m});
        waters_.insert(waters_.end(), scene_.waters.begin(), scene_.waters.end());
        for (const WaterDescription& water : waters_) dig_bed(water, field);
        const double spacing = std::min(field.spacing_x, field.spacing_z);
        const double max_error_m = terrain.max_error_m.value_or(std::max(0.1, spacing / 100));
        terrain_ =
            std::make_unique<Terrain>(make_terrain_cached(std::move(field), max_error_m, exact, context_.cache()));
        Terrain::Look look;
        const Vec3 plain = terrain.texture.empty() && !terrain.natural_colors ? Vec3(0.32f, 0.36f, 0.22f) : Vec3(1.0f);
        FF_ASSIGN(look.material, material(terrain.texture, plain));
        look.steep_material = look.material;
        if (!terrain.steep_texture.empty()) {
            FF_ASSIGN(look.steep_material, material(terrain.steep_texture, Vec3(1.0f)));
            look.steep_cos = std::cos(radians_of(terrain.steep_deg));
        }
        look.texture_size_m = terrain.texture_size_m;
        if (terrain.natural_colors) {
            for (const std::uint32_t id : {look.material, look.steep_material}) divide_out_mean(world_.materials[id]);
            look.color = [this, snow = terrain.snow_line_m](double x, double y, double z, const Vec3& normal) {
                return natural_color(x, y, z, normal, water_level_near(waters_, x, z), snow);
            };
        }
        terrain_->add_to(world_, look);
        add_waters();
        return {};
    }

    /// Leaves of a texture its pattern alone: its mean becomes white.
    void divide_out_mean(scene::Material& material) const {
        if (material.base_color_texture == scene::kNoTexture) return;
        const SourceTexture& texture = world_.textures[material.base_color_texture];
        double sum[3] = {0, 0, 0};
        for (const std::uint32_t texel : texture.rgba)
            for (int c = 0; c < 3; ++c) {
                const double v = double(texel >> (8 * c) & 255) / 255.0;
                sum[c] += v <= 0.04045 ? v / 12.92 : std::pow((v + 0.055) / 1.055, 2.4);
            }
        for (int c = 0; c < 3; ++c)
            material.base_color[c] = float(std::clamp(double(texture.rgba.size()) / std::max(sum[c], 1e-6), 1.0, 16.0));
    }

    /// The sheets of water, and what keeps scattered things out of those that have an outline.
    void add_waters() {
        for (const WaterDescription& water : waters_) {
            world_.materials.push_back(water_material(water));
            add_water_sheet(water, terrain_->field(), std::uint32_t(world_.materials.size() - 1), world_);
            if (water.outline.empty()) continue;
            Footprint outline;
            for (const DVec2& p : water.outline) outline.outer.emplace_back(p.x, -p.y);
            obstacles_.add(outline);
        }
    }

    Status add_town(const std::function<double(double, double)>& landscape) {
        const TownDescription& town = *scene_.town;
        city::CitySettings settings = town.settings;
        settings.scale = scale_;
        city::CityTextures textures;
        for (const auto& [path, id] :
             {std::pair{&town.asphalt, &textures.asphalt}, std::pair{&town.pavement, &textures.pavement},
              std::pair{&town.grass, &textures.grass}, std::pair{&town.gravel, &textures.gravel},
              std::pair{&town.roof_red, &textures.roof_red}, std::pair{&town.roof_dark, &textures.roof_dark}})
            if (!path->empty()) {
                FF_ASSIGN(*id, texture(*path));
            }
        town_ground_ =
            std::make_unique<TownGround>(settings.center_x, settings.center_z, city_flat_radius_m(settings), landscape);
        city::add_city(
            settings, textures, [this](double x, double z) { return town_ground_->height_at(x, z); }, world_, site_);
        for (const std::array<DVec2, 4>& block : site_.blocks) {
            Footprint outline;
            for (const DVec2& p : block) outline.outer.emplace_back(p.x, -p.y);
            obstacles_.add(outline);
        }

        // What stands in the town: one model of each kind, chosen by place.
        using Kind = city::CityProp::Kind;
        std::map<Kind, std::vector<Model>> models;
        const auto load = [&](Kind kind, const std::vector<std::filesystem::path>& paths) -> Status {
            for (const std::filesystem::path& path : paths) {
                if (path.empty()) continue;
                FF_ASSIGN(const Model* loaded, model(path));
                models[kind].push_back(*loaded);
            }
            return {};
        };
        FF_TRY(load(Kind::street_lamp, {town.lamp}));
        FF_TRY(load(Kind::bench, {town.bench}));
        FF_TRY(load(Kind::street_tree, town.street_trees));
        FF_TRY(load(Kind::park_tree, town.park_trees));
        FF_TRY(load(Kind::garden_tree, town.garden_trees));
        FF_TRY(load(Kind::bush, town.bushes));
        for (const Kind kind : {Kind::street_tree, Kind::park_tree, Kind::garden_tree, Kind::bush})
            for (const Model& plant : models[kind]) mark_foliage(plant, world_);
        for (const city::CityProp& prop : site_.props) {
            const std::vector<Model>& choice = models[prop.kind];
            if (choice.empty()) continue;
            const std::uint64_t place = hash_mix(settings.seed, std::uint64_t(std::llround(prop.position.x * 100)),
                                                 std::uint64_t(std::llround(prop.position.z * 100)));
            const bool grown = prop.kind != Kind::street_lamp && prop.kind != Kind::bench;
            place_model(choice[place % choice.size()], prop.position,
                        world_from_yaw(prop.yaw_deg, grown ? 0.75 + 0.4 * hash_unit(place, 1) : 1.0),
                        PlacementKind::instance, world_, true);
        }
        return {};
    }

    Status add_all_buildings() {
        for (const BuildingsDescription& buildings : scene_.buildings) {
            FF_ASSIGN(
                const std::vector<Footprint> footprints,
                read_footprints(buildings.footprints, buildings.properties, OutlineKind::buildings, frame_, context_));
            context_.add_input(buildings.footprints);
            BuildingLook look;
            look.roof = buildings.roof;
            look.detail = buildings.detail;
            look.facade_size_m = buildings.facade_size_m;
            look.level_height_m = buildings.properties.level_height_m;
            FF_ASSIGN(look.wall_material, material(buildings.facade, Vec3(buildings.facade.empty() ? 0.8f : 1.0f)));
            FF_ASSIGN(look.roof_material, material({}, Vec3(0.42f, 0.17f, 0.11f)));
            FF_ASSIGN(look.flat_roof_material, material({}, Vec3(0.34f, 0.33f, 0.32f)));
            FF_ASSIGN(look.glass_material, material({}, Vec3(0.10f, 0.13f, 0.16f), 0.15f));
            FF_ASSIGN(look.trim_material, material({}, Vec3(0.8f)));
            FF_ASSIGN(look.door_material, material({}, Vec3(0.22f, 0.12f, 0.07f)));
            const Ground ground = ground_now();
            add_buildings(
                footprints, look, [&](double x, double z) { return ground(x, z).value_or(0.0); }, world_);
            for (const Footprint& footprint : footprints) obstacles_.add(footprint);
        }
        return {};
    }

    void add_places() {
        for (const PlaceDescription& described : scene_.places) {
            const std::vector<double>& p = described.position_m;
            DVec3 position(p.front(), 0, p.back());
            position.y = p.size() == 3 ? p[1] : ground_now()(position.x, position.z).value_or(0.0);
            world_.places.push_back({.name = described.name, .position = position, .yaw_deg = described.yaw_deg});
        }
    }

    Status add_models(bool (*is_wanted)(const ModelDescription&)) {
        for (const ModelDescription& described : scene_.models) {
            if (!is_wanted(described)) continue;
            FF_ASSIGN(const Model* loaded,
                      model(described.file, described.dynamic ? ModelKind::animated : ModelKind::still));
            if (described.sways) mark_foliage(*loaded, world_);
            const std::vector<double>& p = described.position_m;
            DVec3 position(p.front(), 0, p.back());
            const std::optional<double> below = ground_now()(position.x, position.z);
            position.y = p.size() == 3 ? p[1] : below.value_or(0.0);
            if (described.flock > 0) position.y += described.flock_height_m;
            const long uses = std::count_if(scene_.models.begin(), scene_.models.end(),
                                            [&](const ModelDescription& m) { return m.file == described.file; });
            const DMat3 turn = world_from_yaw(described.yaw_deg, described.scale);
            const std::size_t first_placement = world_.placements.size();
            const auto first_animated = std::uint32_t(world_.animation.instances.size());
            if (loaded->animated) {
                FF_TRY(place_animated(described, *loaded->animated, position, Mat3(turn)));
            } else if (described.dynamic) {
                if (!described.animation.empty()) return unknown_animation(described, {});
                place_model(*loaded, position, turn, PlacementKind::dynamic, world_);
            } else {
                for (const ModelPart& part : loaded->parts)
                    world_.placements.push_back(
                        {.mesh = part.mesh,
                         .position = position + turn * part.position,
                         .world_from_mesh = Mat3(turn * part.model_from_mesh),
                         .kind = part.use_count > 1 || uses > 1 ? PlacementKind::instance : PlacementKind::merge});
            }
            if (described.mass_kg > 0 && loaded->animated)
                return bad_input(
                    fmt::format("{}: is animated; expected a rigid model beside mass_kg", described.file.string()));
            if (!described.name.empty() || described.flock > 0 || described.mass_kg > 0)
                world_.places.push_back(
                    {.name = described.name,
                     .position = position,
                     .yaw_deg = described.yaw_deg,
                     .first_placement = first_placement,
                     .placement_count = world_.placements.size() - first_placement,
                     .first_animated = first_animated,
                     .animated_count = std::uint32_t(world_.animation.instances.size()) - first_animated,
                     .flock = std::uint32_t(described.flock),
                     .flock_radius_m = float(described.flock_radius_m),
                     .mass_kg = float(described.mass_kg)});
            // A model that is the ground blocks nothing, nor does one that hangs in the air.
            constexpr double kClearM = 3.0;
            if (below && !loaded->bounds.is_empty() &&
                position.y + described.scale * loaded->bounds.low.y <= *below + kClearM) {
                Footprint outline;
                const DVec3 &low = loaded->bounds.low, &high = loaded->bounds.high;
                for (const DVec3& corner : {DVec3(low.x, 0, high.z), DVec3(high.x, 0, high.z), DVec3(high.x, 0, low.z),
                                            DVec3(low.x, 0, low.z)}) {
                    const DVec3 q = position + turn * corner;
                    outline.outer.emplace_back(q.x, -q.z);
                }
                obstacles_.add(outline);
            }
        }
        return {};
    }

    static Error unknown_animation(const ModelDescription& described, const std::vector<scene::Clip>& clips) {
        std::string names;
        for (const scene::Clip& clip : clips) names += (names.empty() ? "" : ", ") + clip.name;
        return bad_input(fmt::format("{}: no animation \"{}\"; expected {}", described.file.string(),
                                     described.animation, names.empty() ? "none, for it has none" : "one of " + names));
    }

    Status place_animated(const ModelDescription& described, std::uint32_t model, const DVec3& position,
                          const Mat3& world_from_model) {
        const scene::AnimatedModel& animated = world_.animation.models[model];
        scene::AnimatedInstance instance{.model = model,
                                         .position = position,
                                         .world_from_model = world_from_model,
                                         .clip = animated.clips.empty() ? scene::kNoClip : 0,
                                         .phase = described.animation_phase};
        if (!described.animation.empty()) {
            instance.clip = scene::find_clip(animated, described.animation);
            if (instance.clip == scene::kNoClip) return unknown_animation(described, animated.clips);
        }
        world_.animation.instances.push_back(instance);
        return {};
    }

    Status add_scatters() {
        if (scene_.scatters.empty()) return {};
        obstacles_.finish();
        const Ground ground = ground_now();
        for (const ScatterDescription& described : scene_.scatters) {
            std::vector<Model> models;
            for (const std::filesystem::path& path : described.files) {
                FF_ASSIGN(const Model* loaded, model(path));
                if (described.sways) mark_foliage(*loaded, world_);
                models.push_back(*loaded);
            }
            ScatterRule rule;
            rule.density_per_km2 = described.density_per_km2;
            rule.slope_max_deg = described.slope_max_deg;
            rule.clump_m = described.clump_m;
            rule.height_m = described.height_m;
            rule.scale = described.scale;
            rule.seed = described.seed;
            rule.weights = described.weights;
            if (described.polygons.empty()) {
                const std::vector<double>& a = described.area_m;
                rule.area = {a[0], a[1], a[2], a[3]};
            } else {
                FF_ASSIGN(rule.polygons, read_footprints(described.polygons, {}, OutlineKind::woods, frame_, context_));
                rule.area = {1e9, 1e9, -1e9, -1e9};
                double area_km2 = 0;
                for (const Footprint& polygon : rule.polygons) area_km2 += 1e-6 * signed_area(polygon.outer);
                if (area_km2 * rule.density_per_km2 > 4e6)
                    return bad_input(
                        fmt::format("{}: {:.0f} km2 with {:g} instances each; expected at most 4 million in all",
                                    described.polygons.string(), area_km2, rule.density_per_km2));
                for (const Footprint& polygon : rule.polygons)
                    for (const DVec2& p : polygon.outer) {
                        rule.area.x0 = std::min(rule.area.x0, p.x), rule.area.x1 = std::max(rule.area.x1, p.x);
                        rule.area.z0 = std::min(rule.area.z0, -p.y), rule.area.z1 = std::max(rule.area.z1, -p.y);
                    }
            }
            scatter(models, rule, ground, obstacles_, world_);
        }
        return {};
    }

    Status add_lamps() {
        for (const LampDescription& described : scene_.lamps) {
            const DVec3 offset(described.offset_m[0], described.offset_m[1], described.offset_m[2]);
            scene::Lamp lamp = described.lamp;
            if (described.model.empty()) {
                const std::vector<double>& p = described.position_m;
                lamp.position = DVec3(p.front(), 0, p.back()) + offset;
                lamp.position.y += p.size() == 3 ? p[1] : ground_now()(p.front(), p.back()).value_or(0.0);
                world_.lamps.push_back(lamp);
                continue;
            }
            FF_ASSIGN(const Model* loaded, model(described.model));
            if (loaded->parts.empty()) continue;
            // Where a model stands follows from where its first part does.
            const ModelPart& part = loaded->parts.front();
            const DMat3 mesh_from_model = glm::inverse(part.model_from_mesh);
            for (const Placement& placement : world_.placements) {
                if (placement.mesh != part.mesh) continue;
                const DMat3 world_from_model = DMat3(placement.world_from_mesh) * mesh_from_model;
                lamp.position = placement.position + world_from_model * (offset - part.position);
                world_.lamps.push_back(lamp);
            }
        }
        return {};
    }

    Status add_sounds() {
        for (const SoundDescription& described : scene_.sounds) {
            FF_ASSIGN(scene::SoundClip clip, read_sound(described.file, described.name));
            context_.add_input(described.file);
            const auto id = std::uint32_t(world_.sounds.clips.size());
            world_.sounds.clips.push_back(std::move(clip));
            for (const std::vector<double>& p : described.positions_m) {
                const double y = p.size() == 3 ? p[1] : ground_now()(p.front(), p.back()).value_or(0.0);
                world_.sounds.sources.push_back({.position = {p.front(), y, p.back()},
                                                 .clip = id,
                                                 .reference_m = described.reference_m,
                                                 .gain = described.gain});
            }
        }
        return {};
    }

    void set_spawn() {
        if (!scene_.spawn) return;  // chosen with the walks
        const auto& [x, z, yaw] = *scene_.spawn;
        world_.spawn_position = {x, scene_.spawn_y ? *scene_.spawn_y : ground_now()(x, z).value_or(0.0), z};
        world_.spawn_yaw_deg = yaw;
    }

    Status add_walks() {
        for (const WalkDescription& described : scene_.walks) {
            if (!described.file.empty()) {
                FF_ASSIGN(SourceWalk walk, read_walk_file(described.file, described.name));
                world_.walks.push_back(std::move(walk));
                continue;
            }
            world_.walks.push_back(walk_along(described));
        }
        return {};
    }

    /// One frame every 1/30 s along the line through the points, looking ahead.
    SourceWalk walk_along(const WalkDescription& described) {
        const Ground ground = ground_now();
        const auto point = [&](std::size_t i) {
            const std::vector<double>& p = described.points_m[i];
            return DVec3(p.front(), p.size() == 3 ? p[1] : 0.0, p.back());
        };
        SourceWalk walk{.name = described.name, .frames = {}};
        const double step = described.speed_m_s / walk.rate_hz;
        double left_over = 0;
        for (std::size_t i = 0; i + 1 < described.points_m.size(); ++i) {
            const DVec3 a = point(i), b = point(i + 1);
            const double length = std::hypot(b.x - a.x, b.z - a.z);
            if (length < 1e-9) continue;
            double yaw = degrees_of(std::atan2(b.x - a.x, a.z - b.z));
            double s = left_over;
            for (; s <= length && walk.frames.size() < 1'000'000; s += step) {
                DVec3 p = a + (b - a) * (s / length);
                const bool on_ground = described.points_m[i].size() == 2 || described.points_m[i + 1].size() == 2;
                if (on_ground) p.y = ground(p.x, p.z).value_or(0.0) + described.eye_height_m;
                walk.frames.push_back({glm::round(p * 1e6) / 1e6, std::round(yaw * 1e6) / 1e6, 0, 0});
            }
            left_over = s - length;
        }
        return walk;
    }

    using Ground = GroundHeight;

    /// The ground as it is at this point of the building: town, terrain, or what has been placed so far, except that
    /// nothing stands on scattered things.
    Ground ground_now() {
        if (!terrain_ && !town_ground_) {
            surface_.update(world_, ground_end_.value_or(world_.placements.size()));
            return surface_.now();
        }
        return [this](double x, double z) -> std::optional<double> {
            if (town_ground_ && (!terrain_ || in_town(x, z))) return town_ground_->height_at(x, z);
            return terrain_->height_at(x, z);
        };
    }

    [[nodiscard]] bool in_town(double x, double z) const {
        return std::any_of(site_.blocks.begin(), site_.blocks.end(),
                           [&](const std::array<DVec2, 4>& block) { return contains(block, DVec2(x, z)); });
    }

    [[nodiscard]] DBox3 static_bounds() const {
        DBox3 bounds;
        for (const Placement& placement : world_.placements)
            if (placement.kind != PlacementKind::dynamic)
                for (const Vec3& p : world_.meshes[placement.mesh].geometry.positions)
                    bounds.add(placement.position + DVec3(placement.world_from_mesh * p));
        return bounds;
    }

    const SceneDescription& scene_;
    int scale_;
    CookContext& context_;
    std::optional<GroundFrame> frame_;
    WorldSource world_;
    std::map<std::string, std::uint32_t> textures_;
    std::map<std::pair<std::string, ModelKind>, Model> models_;
    std::unique_ptr<Terrain> terrain_;
    std::unique_ptr<TownGround> town_ground_;
    city::CitySite site_;
    GrowingGround surface_;
    std::optional<std::size_t> ground_end_;  ///< placements behind it are no ground
    Obstacles obstacles_;
    std::vector<WaterDescription> waters_;
};

}  // namespace

Result<WorldSource> load_scene_toml(const std::filesystem::path& path, const SceneTomlSettings& settings,
                                    CookContext& context) {
    FF_ASSIGN(const SceneDescription scene, read_scene_description(path));
    context.add_input(path);
    Result<WorldSource> world = SceneBuilder(scene, settings.scale, context).build();
    if (!world) {
        // Every message names a file; those of the parts name their own.
        if (world.error().message.rfind("holds nothing", 0) == 0)
            return bad_input(fmt::format("{}: {}", path.string(), world.error().message));
        return world.error();
    }
    return world;
}

}  // namespace ff::cook
