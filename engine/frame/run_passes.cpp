#include "engine/frame/run_passes.h"

#include <algorithm>
#include <bit>
#include <glm/geometric.hpp>

#include "engine/core/check.h"
#include "engine/core/jobs.h"
#include "engine/core/log.h"
#include "engine/effects/wind.h"
#include "engine/farfield/tile_regroup.h"
#include "engine/frame/known_frame.h"
#include "engine/frame/reprojected_frame.h"
#include "engine/frame/restless_mirrors.h"
#include "engine/frame/shade_settings.h"
#include "engine/frame/timed_pass.h"
#include "engine/nearfield/near_renderer.h"

namespace ff::frame {
namespace {

using farfield::CastCost;
using farfield::kTileSize;
using farfield::PixelMask;
using farfield::TileRequest;

void mark_sky(const PixelMask& sky, farfield::VisibilityBuffer& visibility) {
    for (std::size_t t = 0; t < sky.tiles.size(); ++t) {
        const farfield::TileMask& mask = sky.tiles[t];
        const int x0 = int(t % std::size_t(sky.tiles_x)) * kTileSize;
        const int y0 = int(t / std::size_t(sky.tiles_x)) * kTileSize;
        for (int row = 0; row < kTileSize; ++row) {
            if (mask.rows[row] == 0) continue;
            const std::size_t first = visibility.index(x0, y0 + row);
            if (mask.rows[row] == 0xFFFFu) {
                std::fill_n(&visibility.instance[first], kTileSize, farfield::kSkyInstance);
                std::fill_n(&visibility.depth[first], kTileSize, std::numeric_limits<float>::infinity());
                continue;
            }
            for (unsigned i = 0; i < kTileSize; ++i) {
                if (((mask.rows[row] >> i) & 1u) == 0) continue;
                visibility.instance[first + i] = farfield::kSkyInstance;
                visibility.depth[first + i] = std::numeric_limits<float>::infinity();
            }
        }
    }
}

/// Takes the pixels of one mask out of another.
void remove(const PixelMask& from_here, PixelMask& mask) {
    for (std::size_t t = 0; t < mask.tiles.size(); ++t)
        for (int row = 0; row < kTileSize; ++row)
            mask.tiles[t].rows[row] = std::uint16_t(mask.tiles[t].rows[row] & ~from_here.tiles[t].rows[row]);
}

/// Leaves in a mask only the pixels that the other one has, too.
void intersect(const PixelMask& other, PixelMask& mask) {
    for (std::size_t t = 0; t < mask.tiles.size(); ++t)
        for (int row = 0; row < kTileSize; ++row)
            mask.tiles[t].rows[row] = std::uint16_t(mask.tiles[t].rows[row] & other.tiles[t].rows[row]);
}

/// The tiles' pixels that none of the masks has answered; tiles that are done are left out.
void collect_requests(std::span<const TileRequest> all, std::span<const PixelMask* const> answered,
                      std::vector<TileRequest>& requests) {
    requests.clear();
    for (std::size_t t = 0; t < all.size(); ++t) {
        TileRequest request = all[t];
        for (const PixelMask* mask : answered) {
            const farfield::TileMask& tile = mask->tiles[t];
            for (int row = 0; row < kTileSize; ++row) request.rows[row] &= std::uint16_t(~tile.rows[row]);
        }
        if (!request.is_empty()) requests.push_back(request);
    }
}

/// The pixels of a mask; tiles without any are left out.
void collect_requests(const PixelMask& mask, std::vector<TileRequest>& requests) {
    requests.clear();
    for (std::size_t t = 0; t < mask.tiles.size(); ++t) {
        const farfield::TileMask& tile = mask.tiles[t];
        if (std::all_of(std::begin(tile.rows), std::end(tile.rows), [](std::uint16_t row) { return row == 0; }))
            continue;
        TileRequest& request = requests.emplace_back();
        request.x = std::uint16_t(int(t % std::size_t(mask.tiles_x)) * kTileSize);
        request.y = std::uint16_t(int(t / std::size_t(mask.tiles_x)) * kTileSize);
        std::copy(std::begin(tile.rows), std::end(tile.rows), request.rows);
    }
}

void mark(std::span<const TileRequest> requests, PixelMask& mask) {
    for (const TileRequest& request : requests) {
        farfield::TileMask& tile = mask.tile_of(request);
        for (int row = 0; row < kTileSize; ++row) tile.rows[row] |= request.rows[row];
    }
}

/// Marks the pixels of `wanted` that are not in `left`, tile lists in any order.
void subtract(std::span<const TileRequest> wanted, std::span<const TileRequest> left, PixelMask& mask) {
    mark(wanted, mask);
    for (const TileRequest& request : left) {
        farfield::TileMask& tile = mask.tile_of(request);
        for (int row = 0; row < kTileSize; ++row) tile.rows[row] &= std::uint16_t(~request.rows[row]);
    }
}

/// Takes pixels on which the shadow of something that moves may fall out of a mask of finished colours.
/// @param may_fall  by tile: 0 where none falls
void take_out_shaded(const farfield::MovingShadows& shadows, std::span<const TileRequest> tiles,
                     std::span<const std::uint8_t> may_fall, const farfield::VisibilityBuffer& visibility,
                     PixelMask& coloured) {
    constexpr std::size_t kTilesPerTask = 64;
    parallel_ranges(tiles.size(), kTilesPerTask, [&](std::size_t begin, std::size_t end) {
        for (std::size_t t = begin; t < end; ++t) {
            if (may_fall[t] == 0) continue;
            TileRequest tile = tiles[t];
            farfield::TileMask& mask = coloured.tile_of(tile);
            for (int row = 0; row < kTileSize; ++row) tile.rows[row] &= mask.rows[row];
            if (tile.is_empty() || !shadows.find(visibility, tile)) continue;
            for (int row = 0; row < kTileSize; ++row) mask.rows[row] &= std::uint16_t(~tile.rows[row]);
        }
    });
}

bool falls(const FramePlan& plan) {
    return plan.effects.is_active(effects::EffectId::rain) || plan.effects.is_active(effects::EffectId::snow);
}

/// Cast pixels of mirrors that are at rest show what the texels around do: reflections for a pixel here and there would
/// cost more than those of all texels did.
void show_resting_mirrors(const FramePlan& plan, const scene::StaticScene& scene, FrameHistory& history,
                          shading::Image& image) {
    PixelMask& mirrors = history.answered;
    mirrors = history.sources.cast;
    keep_resting_mirrors(plan, scene, history, mirrors);
    PixelMask& left = history.left;
    left = mirrors;
    history.panorama->known_colors(history.visibility, image.pixels.data(), image.stride, left);
    remove(left, mirrors);
    for (std::size_t t = 0; t < mirrors.tiles.size(); ++t)
        for (int row = 0; row < kTileSize; ++row) history.coloured.tiles[t].rows[row] |= mirrors.tiles[t].rows[row];
}

/// OpenGL ran out of something in the middle of a frame: the frame goes on without it.
void report(const Status& status) {
    if (!status) log_warning("near field: {}", status.error().message);
}

/// @param dynamic  what is drawn beside the static cells
nearfield::DrawSet cull(const FramePlan& plan, std::span<const scene::Instance> dynamic, const Tools& tools,
                        FrameHistory& history) {
    tools.culler.cull(plan.view, dynamic, history.visible, plan.near_m);
    return {.instances = history.visible.instances,
            .dynamic = dynamic,
            .complete_within_m = plan.near_m,
            .environment = &plan.environment};
}

/// Modes raster and near: the whole picture by OpenGL.
void draw_by_rasteriser(const FramePlan& plan, const Tools& tools, FrameHistory& history, shading::Image& image,
                        FrameStats& stats) {
    const TimedPass timed(stats, Pass::near_field);
    nearfield::NearStats near_stats;
    report(tools.near_renderer->render_shaded(plan.view, cull(plan, plan.dynamic, tools, history), image, near_stats));
    stats.near_triangles = near_stats.triangles;
    stats.near_draws = near_stats.draws;
    stats.pixels.near_field = std::uint64_t(plan.view.width) * std::uint64_t(plan.view.height);
}

/// The near field's ids and depths, and which pixels it covers.
void draw_near_field(const FramePlan& plan, const Tools& tools, FrameHistory& history, FrameStats& stats) {
    PixelMask& covered = history.sources.near_field;
    {
        const TimedPass timed(stats, Pass::near_field);
        nearfield::NearStats near_stats;
        report(
            tools.near_renderer->render_ids(plan.view, cull(plan, {}, tools, history), history.visibility, near_stats));
        stats.near_triangles = near_stats.triangles;
        stats.near_draws = near_stats.draws;
    }
    const TimedPass timed(stats, Pass::opacity);
    const farfield::VisibilityBuffer& visibility = history.visibility;
    farfield::opacity_from_depth(visibility.depth.data(), visibility.stride, visibility.width, visibility.height,
                                 farfield::EmptyDepth::infinite, covered);
    stats.pixels.near_field = covered.count();
    if (plan.software_opacity) {
        PixelMask& answered = history.answered;
        answered = covered;
        history.opacity.draw(tools.scene, {}, history.visible.instances, plan.view, covered);
        intersect(answered, covered);  // it has no depth, and does not know what lies beyond the near distance
        const std::uint64_t known = covered.count();
        stats.opacity_missed = stats.pixels.near_field - std::min(known, stats.pixels.near_field);
        stats.pixels.near_field = known;
    }
}

void blend_layers(const FramePlan& plan, const Tools& tools, FrameHistory& history, shading::Image& image,
                  FrameStats& stats) {
    const TimedPass timed(stats, Pass::blend);
    const TimedEffect timed_effect(stats, effects::EffectId::transparency);
    const farfield::LayerScene layers{tools.scene, tools.layer_index,
                                      plan.dynamic.empty() ? nullptr : &tools.dynamic_overlay.moving()};
    const farfield::SunRays* const sun = begin_sun_rays(plan, tools.scene, plan.dynamic, history.sun);
    const shading::LayerCounts counts = shading::blend_layers(
        layers, plan.view, history.visibility, history.all_tiles,
        shade_settings(plan, tools, plan.view, nullptr, history.lights, stats), sun, history.layers, image);
    stats.layers = counts.shaded;
    count_sun_rays(counts.sun_rays, stats);
}

void draw_fall(const FramePlan& plan, const Tools& tools, FrameHistory& history, shading::Image& image,
               FrameStats& stats) {
    const TimedPass timed(stats, Pass::fall);
    const bool rains = plan.effects.is_active(effects::EffectId::rain);
    const effects::EffectId effect = rains ? effects::EffectId::rain : effects::EffectId::snow;
    const TimedEffect timed_effect(stats, effect);
    if (!history.shelter) history.shelter = std::make_unique<effects::Shelter>();
    const std::uint64_t rays = history.shelter->update(plan.view.position, tools.casters.get(CasterKind::embree));
    stats.work(effect).rays += rays;
    effects::draw_fall(plan.fall, plan.view, history.visibility, *history.shelter, image);
}

/// Whether texels lit by one sun may be shown under another until they are lit anew: light differs by a few percent.
bool is_near(const Vec3& a, const Vec3& b) {
    constexpr float kWithin = 0.0262f;  // radians: 1.5 degrees
    return glm::dot(a - b, a - b) <= kWithin * kWithin;
}

/// The map for frames like this one, told where the viewer stands.
void begin_panorama(const FramePlan& plan, FrameHistory& history) {
    if (!history.panorama) {
        PinholeView full = plan.view;  // the map is made once, for frames of full size
        full.u_step *= float(plan.view.width) / float(plan.image_width);
        full.v_step *= float(plan.view.height) / float(plan.image_height);
        const int size = farfield::Panorama::face_size_for(full, plan.panorama_density);
        history.panorama = std::make_unique<farfield::Panorama>(farfield::PanoramaSettings{.face_size = size});
        history.panorama->populate();
        history.panorama_colors.resize(size, 6 * size);
        populate_pages(history.panorama_colors.pixels);
        const auto tiles_side = std::size_t((size + kTileSize - 1) / kTileSize);
        history.panorama_marks.reserve(tiles_side * tiles_side);
    }
    const scene::Environment& light = plan.environment;
    const bool reflects = plan.effects[effects::EffectId::reflections].state != effects::State::off;
    const PanoramaLook look{.blend_within_m = plan.view.blend_within_m,
                            .sun_shadows = plan.sun_shadows,
                            .fog_density_per_m = light.fog_density_per_m,
                            .lamps_within_m = plan.lamps_within_m,
                            .reflections_within_m = reflects ? plan.reflections_within_m : 0.0f,
                            .air_error = plan.air_error,
                            .water_within_m = plan.water_within_m,
                            .water_is_rough = plan.effects[effects::EffectId::water].state != effects::State::off,
                            .atmosphere = light.atmosphere,
                            .weather = light.weather};
    if (history.panorama_look != look || !is_near(history.panorama_light.oldest_sun, light.to_sun)) {
        history.panorama->clear();
        history.panorama_light = {.oldest_sun = light.to_sun, .started_sun = light.to_sun};
    }
    history.panorama_look = look;
    history.panorama->begin_frame(plan.view.position);
}

/// Which texels show mirrors.
void mark_mirrors(const FramePlan& plan, const scene::StaticScene& scene, const farfield::VisibilityBuffer& map,
                  std::span<const TileRequest> tiles, std::vector<farfield::TileMask>& marks) {
    marks.assign(tiles.size(), farfield::TileMask{});
    const auto is_off = [&](effects::EffectId id) { return plan.effects[id].state == effects::State::off; };
    if (is_off(effects::EffectId::reflections) && is_off(effects::EffectId::water)) return;
    parallel_ranges(tiles.size(), 32, [&](std::size_t begin, std::size_t end) {
        effects::MirrorTest kind_of(scene, plan.dynamic);
        for (std::size_t t = begin; t < end; ++t) {
            for (int row = 0; row < kTileSize; ++row) {
                const std::size_t first = map.index(tiles[t].x, tiles[t].y + row);
                marks[t].rows[row] = kind_of.mirrors_of_row(&map.instance[first], &map.triangle[first]);
            }
        }
    });
}

/// Casts and shades the texels that were chosen.
void fill_chosen(const FramePlan& plan, const Tools& tools, FrameHistory& history, FrameStats& stats) {
    farfield::Panorama& panorama = *history.panorama;
    for (int face = 0; face < 6; ++face) {
        const auto texels = panorama.fill_requests(face);
        if (texels.empty()) continue;
        PinholeView view = panorama.face_view(face);
        view.blend_within_m = plan.view.blend_within_m;
        {
            const TimedPass timed(stats, Pass::cast);
            stats.rays +=
                tools.casters.get(plan.caster, plan.grid_cells_per_item).cast_tiles(view, texels, panorama.map()).rays;
        }
        const std::uint8_t* const sun_seen =
            find_sun_of_panorama(plan, tools.scene, view, texels, panorama, history.sun, stats);
        const shading::Reflections* const reflections =
            find_reflections_of_panorama(plan, tools, view, texels, history, stats);
        {
            const TimedPass timed(stats, Pass::shade);
            stats.shaded_pixels +=
                shading::shade_tiles(tools.scene, {}, view, panorama.map(), texels,
                                     shade_settings(plan, tools, view, sun_seen, history.lights, stats, reflections),
                                     history.panorama_colors);
        }
        const TimedPass timed(stats, Pass::store);
        mark_mirrors(plan, tools.scene, panorama.map(), texels, history.panorama_marks);
        panorama.commit_fill(face, history.panorama_colors.pixels, history.panorama_colors.stride,
                             history.panorama_marks);
    }
}

/// Casts the texels that the wanted pixels lack.
/// @return rays that it took, at most limits.ray_budget
std::uint64_t fill_panorama(const FramePlan& plan, const Tools& tools, const farfield::PanoramaLimits& limits,
                            FrameHistory& history, FrameStats& stats) {
    std::uint64_t chosen = 0;
    {
        const TimedPass timed(stats, Pass::panorama);
        chosen = history.panorama->plan_fill(plan.view, history.wanted, limits);
    }
    fill_chosen(plan, tools, history, stats);
    return chosen;
}

/// Lights texels anew, a part of the map a frame, while they show another sun than this frame's: a sun that moves on
/// and on costs every frame as much, and none all of the map.
void relight_panorama(const FramePlan& plan, const Tools& tools, FrameHistory& history, FrameStats& stats) {
    constexpr std::uint64_t kFrames = 24;  // in which as many texels as a view has are lit
    PanoramaLight& light = history.panorama_light;
    const Vec3& sun = plan.environment.to_sun;
    if (!light.is_round) {
        if (light.oldest_sun == sun) return;
        light = {.oldest_sun = light.oldest_sun, .started_sun = sun, .next = 0, .is_round = true};
    }
    const std::uint64_t texels = 2 * std::uint64_t(plan.view.width) * std::uint64_t(plan.view.height) / kFrames;
    bool is_complete = false;
    {
        const TimedPass timed(stats, Pass::panorama);
        constexpr std::uint64_t kTile = std::uint64_t(kTileSize) * std::uint64_t(kTileSize);
        is_complete = history.panorama->plan_refresh(std::max(texels, kTile), light.next);
    }
    fill_chosen(plan, tools, history, stats);
    if (!is_complete) return;
    light.oldest_sun = light.started_sun;
    light.is_round = false;
}

/// Takes tiles in which leaves move from those that the panorama is asked for: it knows them as they stand still.
void find_swaying(const FramePlan& plan, const Tools& tools, FrameHistory& history, FrameStats& stats) {
    const TimedPass timed(stats, Pass::panorama);
    const TimedEffect timed_effect(stats, effects::EffectId::wind);
    MovingTiles& tiles = history.swaying_tiles;
    tiles.begin(plan.view);
    effects::for_foliage_within(tools.scene, plan.view.position, plan.view.sway.within_m,
                                [&](const DBox3& bounds) { tiles.add(bounds); });
    history.swaying_share = double(std::count_if(history.all_tiles.begin(), history.all_tiles.end(),
                                                 [&](const TileRequest& tile) { return tiles.has(tile); })) /
                            double(history.all_tiles.size());
    if (!plan.look_up_panorama) return;
    std::erase_if(history.wanted, [&](const TileRequest& tile) {
        if (tiles.has(tile)) history.swaying.push_back(tile);
        return tiles.has(tile);
    });
}

/// Tiles in which something that moves may show, or cast its shadow on what is seen.
void find_tiles_of_moving(const FramePlan& plan, FrameHistory& history) {
    history.tiles_of_moving.assign(history.all_tiles.size(), 0);
    if (plan.dynamic.empty()) return;
    history.moving_tiles.begin(plan.view);
    for (const scene::Instance& instance : plan.dynamic) history.moving_tiles.add(instance.bounds);
    constexpr std::size_t kTilesPerTask = 128;
    parallel_ranges(history.all_tiles.size(), kTilesPerTask, [&](std::size_t begin, std::size_t end) {
        for (std::size_t t = begin; t < end; ++t) {
            const TileRequest& tile = history.all_tiles[t];
            const bool may_show =
                history.moving_tiles.has(tile) || (plan.sun_shadows && history.moving_shadows.may_fall_into(tile));
            history.tiles_of_moving[t] = std::uint8_t(may_show);
        }
    });
}

/// Answers from the map what it can; the rest is left in history.requests.
void look_up_panorama(const FramePlan& plan, const Tools& tools, const farfield::PanoramaLimits& limits,
                      FrameHistory& history, shading::Image& image, FrameStats& stats) {
    farfield::Panorama& panorama = *history.panorama;
    const TimedPass timed(stats, Pass::panorama);
    // Depths are fetched only where something may stand before the texels, names where its shadow may fall on them, and
    // both where they mirror.
    using farfield::PanoramaNames;
    const bool wants_depths = plan.keep_ids || falls(plan) || plan.effects.is_active(effects::EffectId::transparency);
    const bool wants_marked = !plan.dynamic.empty() || has_restless_mirrors(plan, history);
    const PanoramaNames names = plan.keep_ids  ? PanoramaNames::all
                                : wants_marked ? PanoramaNames::marked
                                               : PanoramaNames::none;
    const bool wants_visibility = wants_depths || names != PanoramaNames::none;
    find_tiles_of_moving(plan, history);
    const farfield::PanoramaTarget target{.visibility = wants_visibility ? &history.visibility : nullptr,
                                          .colors = image.pixels.data(),
                                          .color_stride = image.stride,
                                          .depths = wants_depths,
                                          .names = names,
                                          .whole = history.tiles_of_moving,
                                          .named = &history.named};
    const farfield::PanoramaStats found = panorama.lookup(plan.view, history.wanted, limits, target, history.requests);
    stats.pixels.panorama = found.reused + found.stale + found.unanswered;
    stats.pixels.stale = found.stale + found.unanswered;
    stats.parallax_p99_px = found.parallax_p99_px;
    stats.parallax_max_px = found.parallax_max_px;
    panorama.verify_edges(tools.scene, plan.view, target, history.visibility, history.sources.verified);
}

}  // namespace

farfield::RayCaster& Casters::get(CasterKind kind, double grid_cells_per_item) {
    auto& caster = casters_[std::size_t(kind)];
    if (!caster || (kind == CasterKind::grid && grid_cells_per_item != grid_cells_per_item_)) {
        switch (kind) {
            case CasterKind::beam:
                caster = farfield::make_beam_caster(scene_);
                break;
            case CasterKind::embree:
                caster = farfield::make_embree_caster(scene_);
                break;
            case CasterKind::grid:
                caster = farfield::make_grid_caster(scene_, grid_cells_per_item);
                grid_cells_per_item_ = grid_cells_per_item;
                break;
        }
    }
    return *caster;
}

namespace {

/// Every surface but transparent layers, each pixel by the cheapest source that is right.
void draw_surfaces(const FramePlan& plan, const Tools& tools, FrameHistory& history, shading::Image& image,
                   FrameStats& stats) {
    farfield::VisibilityBuffer& visibility = history.visibility;
    SourceMasks& sources = history.sources;

    bound_moving(plan.dynamic, history.moving);
    history.moving_shadows.begin(plan.view, history.moving, tools.scene.environment.to_sun);
    find_mirrored(plan, history);

    // Near field: what is close enough that triangles are cheaper than pixels.
    if (plan.rasterise) {
        FF_CHECK(tools.near_renderer != nullptr, "a near field needs OpenGL");
        draw_near_field(plan, tools, history, stats);
    }

    // Sky: pixels above the skyline.
    if (plan.trace_horizon) {
        const TimedPass timed(stats, Pass::horizon);
        history.horizon.set_quality(0.0f, plan.horizon_subsample);
        stats.horizon_azimuths = history.horizon.update(tools.scene, plan.view).columns;
        farfield::find_sky_pixels(plan.view, history.horizon, sources.sky);
        remove(sources.near_field, sources.sky);
        stats.pixels.sky = sources.sky.count();
        mark_sky(sources.sky, visibility);
    }

    const PixelMask* const cheaper[] = {&sources.near_field, &sources.sky};
    collect_requests(history.all_tiles, cheaper, history.wanted);

    // Panorama: pixels whose cached texel still looks right from here.
    // What nobody answers within the budget keeps its colour of the last frame.
    if (image.width != plan.view.width || image.height != plan.view.height)
        image.resize(plan.view.width, plan.view.height);
    std::vector<TileRequest>* casts = &history.wanted;
    if (plan.look_up_panorama || plan.store_panorama || plan.fill_panorama) {
        const TimedPass timed(stats, Pass::panorama);
        begin_panorama(plan, history);
    }
    if (plan.look_up_panorama || plan.fill_panorama) relight_panorama(plan, tools, history, stats);
    history.swaying.clear();
    history.swaying_share = 0.0;
    if (!plan.view.sway.is_none()) find_swaying(plan, tools, history, stats);
    farfield::PanoramaLimits limits{
        .max_parallax_px = plan.max_parallax_px, .edges = plan.panorama_edges, .ray_budget = plan.ray_budget};
    history.panorama_is_full = false;
    if (plan.fill_panorama) {
        farfield::PanoramaLimits fill_limits = limits;
        fill_limits.ray_budget = std::min(limits.ray_budget, plan.fill_budget);
        const std::uint64_t filled = fill_panorama(plan, tools, fill_limits, history, stats);
        limits.ray_budget -= filled;
        history.panorama_is_full = history.panorama->is_fill_complete();
    }
    if (plan.look_up_panorama) {
        look_up_panorama(plan, tools, limits, history, image, stats);
        casts = &history.requests;
    }
    subtract(history.wanted, *casts, sources.panorama);
    casts->insert(casts->end(), history.swaying.begin(), history.swaying.end());
    mark(*casts, sources.cast);

    // Casts: everything that nothing cheaper has answered.
    {
        const TimedPass timed(stats, Pass::cast);
        const CastCost cost =
            tools.casters.get(plan.caster, plan.grid_cells_per_item).cast_tiles(plan.view, *casts, visibility);
        stats.rays += cost.rays;
        stats.nodes_visited += cost.nodes;
        stats.triangles_tested += cost.triangles;
        const std::uint64_t pixels = sources.cast.count();
        stats.pixels.cast_miss = farfield::count_sky(*casts, visibility);
        stats.pixels.cast_hit = pixels - stats.pixels.cast_miss;
    }

    // What moves: over all that stands still, wherever it is nearer.
    if (!plan.dynamic.empty()) {
        const TimedPass timed(stats, Pass::cast);
        tools.dynamic_overlay.draw(plan.view, plan.dynamic, history.all_tiles, visibility, sources.dynamic);
        stats.pixels.dynamic = sources.dynamic.count();
        for (PixelMask* mask : {&sources.near_field, &sources.sky, &sources.panorama, &sources.cast})
            remove(sources.dynamic, *mask);
    }

    // Shading: each pixel once, whoever found it.
    {
        const TimedPass timed(stats, Pass::shade);
        PixelMask& coloured = history.coloured;
        coloured = sources.panorama;
        remove(sources.verified, coloured);
        if (plan.look_up_panorama && plan.effects.is_active(effects::EffectId::reflections))
            show_resting_mirrors(plan, tools.scene, history, image);
        if (plan.look_up_panorama && plan.sun_shadows && !plan.dynamic.empty())
            take_out_shaded(history.moving_shadows, history.all_tiles, history.tiles_of_moving, visibility, coloured);
        // Mirrors that were cast and are coloured all the same are at rest.
        if (plan.look_up_panorama && has_restless_mirrors(plan, history))
            take_out_restless_mirrors(plan, tools.scene, history, &history.named, coloured);
        const PixelMask* const done[] = {&coloured};
        collect_requests(history.all_tiles, done, history.to_shade);
    }
    const std::uint8_t* const sun_seen =
        find_sun(plan, tools.scene, visibility, history.to_shade,
                 plan.look_up_panorama ? history.panorama.get() : nullptr, history.sun, stats);
    const shading::Reflections* const reflections = find_reflections(plan, tools, history.to_shade, history, stats);
    {
        const TimedPass timed(stats, Pass::shade);
        stats.shaded_pixels += shading::shade_tiles(
            tools.scene, plan.dynamic, plan.view, visibility, history.to_shade,
            shade_settings(plan, tools, plan.view, sun_seen, history.lights, stats, reflections), image);
    }
    if (plan.store_panorama) {
        const TimedPass timed(stats, Pass::store);
        // But mirrors that may show what moves: it would stay in them.
        PixelMask& steady = history.coloured;
        steady = sources.cast;
        if (has_restless_mirrors(plan, history)) take_out_restless_mirrors(plan, tools.scene, history, nullptr, steady);
        collect_requests(steady, history.to_store);
        history.panorama->store(plan.view, history.to_store, visibility, image.pixels, image.stride, sun_seen);
    }
}

/// All passes but the last, at the size of the plan's view.
FrameStats draw_view(const FramePlan& plan, const Tools& tools, FrameHistory& history, shading::Image& image) {
    FrameStats stats;
    stats.effects = plan.effects;
    history.fit(plan.view.width, plan.view.height);
    SourceMasks& sources = history.sources;
    for (PixelMask* mask :
         {&sources.near_field, &sources.sky, &sources.panorama, &sources.cast, &sources.dynamic, &sources.verified})
        mask->reset(plan.view.width, plan.view.height);

    if (plan.mode == Mode::raster || plan.mode == Mode::near) {
        FF_CHECK(tools.near_renderer != nullptr, "mode raster needs OpenGL");
        draw_by_rasteriser(plan, tools, history, image, stats);
    } else {
        if (plan.primitives_are_known)
            draw_known_frame(plan, tools, history, image, stats);
        else if (plan.mode == Mode::reproject)
            draw_reprojected_frame(plan, tools, history, image, stats);
        else
            draw_surfaces(plan, tools, history, image, stats);
        // Transparent layers, over everything and remembered by nothing.
        if (plan.effects.is_active(effects::EffectId::transparency)) blend_layers(plan, tools, history, image, stats);
        if (falls(plan)) draw_fall(plan, tools, history, image, stats);
    }
    stats.near_m = plan.near_m;
    stats.ray_budget = plan.ray_budget;
    return stats;
}

}  // namespace

FrameStats run_passes(const FramePlan& plan, const Tools& tools, FrameHistory& history, shading::Image& image) {
    if (plan.view.width == plan.image_width && plan.view.height == plan.image_height)
        return draw_view(plan, tools, history, image);
    if (image.width != plan.image_width || image.height != plan.image_height)
        image.resize(plan.image_width, plan.image_height);
    FrameStats stats = draw_view(plan, tools, history, history.reduced);
    stats.resolution = double(plan.view.width) / plan.image_width;
    const TimedPass timed(stats, Pass::upscale);
    history.upscaler.run(history.reduced, image);
    return stats;
}

}  // namespace ff::frame
