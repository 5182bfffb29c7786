// What the panorama saves and what it costs in accuracy: a turn on the spot and a walk, against casting and shading
// every pixel. Usage: bench_panorama [frames] [face size] [edge contrast] [image directory]
// Times are processor time of one worker.

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

#include "engine/core/jobs.h"
#include "engine/farfield/panorama.h"
#include "engine/farfield/ray_caster.h"
#include "engine/shading/shading_pass.h"
#include "tests/bench/bench_world.h"
#include "tests/bench/cpu_watch.h"

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

}  // namespace

int main(int argc, char** argv) {
    const int frames = argc > 1 ? std::atoi(argv[1]) : 60;
    const WorkerLimit limit(1);
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
