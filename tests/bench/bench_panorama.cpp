// What the panorama saves and what it costs in accuracy: a turn on the spot and a walk, against casting and shading
// every pixel. Usage: bench_panorama [frames] [face size] [edge contrast] [image directory]
// Or what each step of a frame costs on a pack's walk, every map filled from nothing, and a hash of the pictures:
// bench_panorama PACK.ffpack:WALK [laps]
// Times are processor time of one worker.

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <string>
#include <vector>

#include "engine/core/jobs.h"
#include "engine/farfield/beam_caster.h"
#include "engine/farfield/horizon.h"
#include "engine/farfield/panorama.h"
#include "engine/farfield/ray_caster.h"
#include "engine/shading/shading_pass.h"
#include "tests/bench/bench_world.h"
#include "tests/bench/cpu_watch.h"
#include "tests/bench/pack_walk.h"

namespace {

using namespace ff;
using farfield::TileRequest;
using farfield::VisibilityBuffer;

constexpr int kWidth = 640, kHeight = 480;

std::vector<TileRequest> all_tiles() {
    std::vector<TileRequest> tiles;
    for (int y = 0; y < kHeight; y += farfield::kTileSize)
        for (int x = 0; x < kWidth; x += farfield::kTileSize) {
            TileRequest tile{std::uint16_t(x), std::uint16_t(y), {}};
            std::fill_n(tile.rows, farfield::kTileSize, std::uint16_t(0xFFFF));
            tiles.push_back(tile);
        }
    return tiles;
}

double psnr_db(const shading::Image& a, const shading::Image& b) {
    double sum = 0;
    for (int y = 0; y < kHeight; ++y)
        for (int x = 0; x < kWidth; ++x) {
            const std::uint32_t p = a.pixels[std::size_t(y * a.stride + x)];
            const std::uint32_t q = b.pixels[std::size_t(y * b.stride + x)];
            for (int shift = 0; shift < 24; shift += 8) {
                const double d = double((p >> shift) & 255) - double((q >> shift) & 255);
                sum += d * d;
            }
        }
    const double mean = sum / (3.0 * kWidth * kHeight);
    return mean > 0 ? 10 * std::log10(255.0 * 255.0 / mean) : 99.0;
}

void write_ppm(const std::string& path, const shading::Image& image) {
    std::FILE* file = std::fopen(path.c_str(), "wb");
    if (file == nullptr) return;
    fmt::print(file, "P6 {} {} 255\n", image.width, image.height);
    for (int y = 0; y < image.height; ++y)
        for (int x = 0; x < image.width; ++x) std::fwrite(&image.pixels[std::size_t(y * image.stride + x)], 1, 3, file);
    std::fclose(file);
}

double median(std::vector<double> values) {
    std::sort(values.begin(), values.end());
    return values.empty() ? 0.0 : values[values.size() / 2];
}
double p99(std::vector<double> values) {
    std::sort(values.begin(), values.end());
    return values.empty() ? 0.0 : values[values.size() * 99 / 100];
}

Camera turning(int frame, int frames) {
    Camera camera;
    camera.position = {40.0, bench::town_height(40, 20) + 1.7, 20.0};
    camera.yaw = 2 * kPi * frame / frames;
    camera.pitch = 0.1 * std::sin(4 * kPi * frame / frames);
    return camera;
}
Camera walking(int frame, int) {
    Camera camera;
    const double x = 40.0 + 0.053 * frame, z = 20.0 - 0.01 * frame;
    camera.position = {x, bench::town_height(float(x), float(z)) + 30.0, z};
    camera.yaw = 0.6;
    return camera;
}

struct Way {
    const char* name;
    bool fill;  ///< cast texels of the map, else pixels of the screen
    farfield::PanoramaLimits limits;
};

void run(const scene::StaticScene& scene, farfield::RayCaster& caster, const char* walk, Camera (*camera_of)(int, int),
         int frames, const farfield::PanoramaSettings& settings, const Way& way, const std::string& images) {
    const auto tiles = all_tiles();
    farfield::Panorama panorama(settings);
    VisibilityBuffer reference_visibility, visibility;
    shading::Image reference, image, face_image;
    reference_visibility.resize(kWidth, kHeight);
    visibility.resize(kWidth, kHeight);
    reference.resize(kWidth, kHeight);
    image.resize(kWidth, kHeight);
    face_image.resize(settings.face_size, 6 * settings.face_size);
    std::vector<TileRequest> to_cast;
    std::vector<double> full_ms, plan_ms, fill_ms, lookup_ms, rest_ms, total_ms, errors;
    double filled = 0, cast = 0, edges = 0, stale = 0, parallax = 0;
    for (int frame = 0; frame < frames; ++frame) {
        const PinholeView view = make_view(camera_of(frame, frames), kWidth, kHeight);
        bench::CpuWatch watch;
        caster.cast_tiles(view, tiles, reference_visibility);
        shading::shade_tiles(scene, {}, view, reference_visibility, tiles, {}, reference);
        const double full = watch.milliseconds();

        watch.restart();
        panorama.begin_frame(view.position);
        double planned = 0, fill = 0;
        if (way.fill) {
            filled += double(panorama.plan_fill(view, tiles, way.limits));
            planned = watch.milliseconds();
            for (int face = 0; face < 6; ++face) {
                const auto requests = panorama.fill_requests(face);
                if (requests.empty()) continue;
                const PinholeView face_view = panorama.face_view(face);
                caster.cast_tiles(face_view, requests, panorama.map());
                shading::shade_tiles(scene, {}, face_view, panorama.map(), requests, {}, face_image);
                panorama.commit_fill(face, face_image.pixels, face_image.stride);
            }
            fill = watch.milliseconds() - planned;
        }
        const farfield::PanoramaStats stats =
            panorama.lookup(view, tiles, way.limits, {&visibility, image.pixels.data(), image.stride}, to_cast);
        const double looked_up = watch.milliseconds() - planned - fill;
        caster.cast_tiles(view, to_cast, visibility);
        shading::shade_tiles(scene, {}, view, visibility, to_cast, {}, image);
        if (!way.fill) panorama.store(view, to_cast, visibility, image.pixels, image.stride);
        const double total = watch.milliseconds();
        errors.push_back(psnr_db(reference, image));
        if (frame < 3) continue;  // the first frames fill the map
        full_ms.push_back(full), plan_ms.push_back(planned), fill_ms.push_back(fill), lookup_ms.push_back(looked_up);
        rest_ms.push_back(total - planned - fill - looked_up), total_ms.push_back(total);
        cast += double(stats.cast), edges += double(stats.edges), stale += double(stats.stale);
        parallax = std::max(parallax, double(stats.parallax_p99_px));
        if (!images.empty() && frame == frames / 3) {
            write_ppm(images + "/" + walk + "_reference.ppm", reference);
            write_ppm(images + "/" + walk + "_" + way.name + ".ppm", image);
        }
    }
    const double n = double(full_ms.size()) * kWidth * kHeight / 100.0;
    fmt::print(
        "| {} | {} | {:.2f} | {:.2f} | {:.2f} | {:.2f} | {:.2f} | {:.2f} | {:.2f} | {:.1f} | {:.1f} | {:.1f} | "
        "{:.1f} | {:.1f} | {:.1f} | {:.1f} | {:.2f} |\n",
        walk, way.name, median(full_ms), median(total_ms), p99(total_ms), median(plan_ms), median(fill_ms),
        median(lookup_ms), median(rest_ms), median(full_ms) / median(total_ms), filled / n, cast / n, edges / n,
        stale / n, *std::min_element(errors.begin(), errors.end()), median(errors), parallax);
}

/// Takes the pixels of `mask` out of `tiles`; tiles without any left go, too.
void remove(const farfield::PixelMask& mask, std::vector<TileRequest>& tiles) {
    for (TileRequest& tile : tiles)
        for (int j = 0; j < farfield::kTileSize; ++j)
            tile.rows[j] = std::uint16_t(
                tile.rows[j] &
                ~mask.tiles[std::size_t(tile.y / 16) * std::size_t(mask.tiles_x) + std::size_t(tile.x / 16)].rows[j]);
    std::erase_if(tiles, [](const TileRequest& tile) {
        return std::all_of(tile.rows, tile.rows + farfield::kTileSize, [](std::uint16_t row) { return row == 0; });
    });
}

enum Step { kMake, kPlan, kCastTexels, kShadeTexels, kCommit, kLookup, kVerify, kCast, kShade, kSteps };
constexpr const char* kStepNames[kSteps] = {"make",   "plan",   "cast texels", "shade texels", "commit",
                                            "lookup", "verify", "cast",        "shade"};

struct LapCounts {
    double filled = 0, cast = 0, verified = 0, verified_tiles = 0;
    std::uint64_t hash = 14695981039346656037u;  ///< FNV-1a of all pictures
};

/// One lap of a walk. `times` gets each frame's steps where they took less than what stands there.
LapCounts run_lap(const scene::StaticScene& scene, farfield::RayCaster& caster, const std::vector<PinholeView>& views,
                  std::vector<std::array<double, kSteps>>& times) {
    LapCounts counts;
    farfield::PanoramaLimits limits;
    limits.edges = farfield::EdgeRule::verify;
    farfield::HorizonMap horizon;
    farfield::PixelMask sky, verified;
    std::unique_ptr<farfield::Panorama> panorama;
    VisibilityBuffer visibility;
    shading::Image image, texels;
    visibility.resize(kWidth, kHeight);
    image.resize(kWidth, kHeight);
    std::vector<TileRequest> to_cast, to_shade;
    for (std::size_t frame = 0; frame < views.size(); ++frame) {
        const PinholeView& view = views[frame];
        std::vector<TileRequest> wanted = all_tiles();
        horizon.update(scene, view);
        farfield::find_sky_pixels(view, horizon, sky);
        remove(sky, wanted);
        verified.reset(kWidth, kHeight);

        std::array<double, kSteps> ms{};
        bench::CpuWatch watch;
        const auto stop = [&](Step step) {
            ms[step] += watch.milliseconds();
            watch.restart();
        };
        if (!panorama) {
            const int size = farfield::Panorama::face_size_for(view);
            panorama = std::make_unique<farfield::Panorama>(farfield::PanoramaSettings{.face_size = size});
            stop(kMake);
            texels.resize(size, 6 * size);
        }
        watch.restart();
        panorama->begin_frame(view.position);
        counts.filled += double(panorama->plan_fill(view, wanted, limits));
        stop(kPlan);
        for (int face = 0; face < 6; ++face) {
            const auto requests = panorama->fill_requests(face);
            if (requests.empty()) continue;
            const PinholeView face_view = panorama->face_view(face);
            caster.cast_tiles(face_view, requests, panorama->map());
            stop(kCastTexels);
            shading::shade_tiles(scene, {}, face_view, panorama->map(), requests, {}, texels);
            stop(kShadeTexels);
            panorama->commit_fill(face, texels.pixels, texels.stride);
            stop(kCommit);
        }
        const farfield::PanoramaTarget target{nullptr, image.pixels.data(), image.stride, true};
        counts.cast += double(panorama->lookup(view, wanted, limits, target, to_cast).cast);
        stop(kLookup);
        panorama->verify_edges(scene, view, target, visibility, verified);
        stop(kVerify);
        caster.cast_tiles(view, to_cast, visibility);
        stop(kCast);
        to_shade = to_cast;
        for (std::size_t t = 0; t < verified.tiles.size(); ++t) {
            if (verified.tiles[t].count() == 0) continue;
            counts.verified += verified.tiles[t].count();
            ++counts.verified_tiles;
            TileRequest tile{std::uint16_t(t % std::size_t(verified.tiles_x) * farfield::kTileSize),
                             std::uint16_t(t / std::size_t(verified.tiles_x) * farfield::kTileSize),
                             {}};
            std::copy_n(verified.tiles[t].rows, farfield::kTileSize, tile.rows);
            to_shade.push_back(tile);
        }
        watch.restart();
        shading::shade_tiles(scene, {}, view, visibility, to_shade, {}, image);
        stop(kShade);
        for (int y = 0; y < kHeight; ++y)
            for (int x = 0; x < kWidth; ++x)
                counts.hash = (counts.hash ^ image.pixels[std::size_t(y * image.stride + x)]) * 1099511628211u;
        for (int step = 0; step < kSteps; ++step)
            times[frame][std::size_t(step)] = std::min(times[frame][std::size_t(step)], ms[std::size_t(step)]);
    }
    return counts;
}

int run_pack(const std::string& pack, const std::string& walk_name, int laps) {
    const Result<bench::PackWalk> opened = bench::open_pack_walk(pack, walk_name);
    if (!opened) {
        fmt::print(stderr, "bench_panorama: {}\n", opened.error().message);
        return 3;
    }
    const scene::Walk& walk = *opened->walk;
    std::vector<PinholeView> views;
    for (std::size_t i = 0; i < walk.frames.size(); ++i) views.push_back(make_view(walk.camera(i), kWidth, kHeight));
    const auto caster = farfield::make_beam_caster(opened->world->scene());
    std::array<double, kSteps> most;
    most.fill(1e9);
    std::vector<std::array<double, kSteps>> times(views.size(), most);
    LapCounts counts;
    for (int lap = 0; lap < laps; ++lap) counts = run_lap(opened->world->scene(), *caster, views, times);
    fmt::print("| step | ms, mean over frames of the best lap | most |\n|---|---|---|\n");
    for (std::size_t step = 0; step < kSteps; ++step) {
        double sum = 0, worst = 0;
        for (const auto& frame : times) sum += frame[step], worst = std::max(worst, frame[step]);
        fmt::print("| {} | {:.3f} | {:.2f} |\n", kStepNames[step], sum / double(views.size()), worst);
    }
    const auto n = double(views.size());
    fmt::print("\na frame: {:.0f} texels filled, {:.0f} pixels cast, {:.0f} verified in {:.0f} tiles; hash {:016x}\n",
               counts.filled / n, counts.cast / n, counts.verified / n, counts.verified_tiles / n, counts.hash);
    return 0;
}

}  // namespace

int main(int argc, char** argv) {
    const WorkerLimit limit(1);
    const std::string name = argc > 1 ? argv[1] : "";
    if (const std::size_t colon = name.rfind(':'); colon != std::string::npos)
        return run_pack(name.substr(0, colon), name.substr(colon + 1), argc > 2 ? std::atoi(argv[2]) : 3);
    const int frames = argc > 1 ? std::atoi(argv[1]) : 60;
    farfield::PanoramaSettings settings;
    if (argc > 2) settings.face_size = std::atoi(argv[2]);
    if (argc > 3) settings.edge_contrast = std::atoi(argv[3]);
    const std::string images = argc > 4 ? argv[4] : "";
    bench::TownSize size;
    size.trees = 60;
    const scene::SceneData town = bench::make_town(size);
    scene::StaticScene scene{.origin = town.origin,
                             .bounds = town.bounds,
                             .positions = town.positions,
                             .attributes = town.attributes,
                             .indices = town.indices,
                             .triangle_materials = town.triangle_materials,
                             .meshes = town.meshes,
                             .instances = town.instances,
                             .materials = town.materials,
                             .textures = town.textures,
                             .texels = town.texels};
    const auto caster = farfield::make_embree_caster(scene);
    fmt::print(
        "| walk | way | full ms | total | p99 | plan | fill | lookup | rest | ratio | filled % | cast % | edges "
        "% | stale % | psnr min | psnr median | parallax p99 "
        "|\n|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|"
        "\n");
    farfield::PanoramaLimits limits;
    farfield::PanoramaLimits blend = limits;
    blend.edges = farfield::EdgeRule::blend;
    farfield::PanoramaLimits by_distance = limits;
    by_distance.measure = farfield::ConfidenceMeasure::distance;
    by_distance.max_distance_m = 0.15f;  // about as many rays as the parallax limit asks for
    run(scene, *caster, "turn", turning, frames, settings, {"fill", true, limits}, images);
    run(scene, *caster, "turn", turning, frames, settings, {"fill-blend", true, blend}, images);
    run(scene, *caster, "turn", turning, frames, settings, {"store", false, limits}, images);
    run(scene, *caster, "walk", walking, frames, settings, {"fill", true, limits}, images);
    run(scene, *caster, "walk", walking, frames, settings, {"store", false, limits}, images);
    run(scene, *caster, "walk", walking, frames, settings, {"store-distance", false, by_distance}, images);
    return 0;
}
