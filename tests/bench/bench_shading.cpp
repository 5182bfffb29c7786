// Milliseconds of the shading pass for whole 640x480 images: a town from the street and from above, a wood, near and
// far, all pixels textured, or prelit beyond some distances, with the error that this makes. Or sixteen views of a
// pack's walk, each cast anew before it is shaded, so that the caches are as they are in a frame. Usage: bench_shading
// [laps [folder for the pictures]] | PACK.ffpack:WALK [laps [folder]]

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <string>
#include <unordered_set>
#include <vector>

#include "engine/core/jobs.h"
#include "engine/core/stopwatch.h"
#include "engine/farfield/ray_caster.h"
#include "engine/scene/prelit_colors.h"
#include "engine/shading/image_difference.h"
#include "engine/shading/shading_pass.h"
#include "tests/bench/bench_world.h"
#include "tests/bench/cpu_watch.h"
#include "tests/bench/pack_walk.h"
#include "tests/support/tiles.h"

namespace {

using namespace ff;

constexpr int kWidth = 640, kHeight = 480;

std::vector<farfield::TileRequest> whole_image() {
    return test::all_tiles(kWidth, kHeight);
}

struct Shot {
    std::string name;
    const scene::StaticScene* scene;
    PinholeView view;
    shading::ShadeSettings settings;
    farfield::VisibilityBuffer visibility;
    std::vector<double> ms[2];  ///< one worker, two workers
    double psnr_db = 99.0;      ///< against full shading
};

/// Triangles set up: once per tile that sees them.
std::size_t tile_triangles(const farfield::VisibilityBuffer& visibility) {
    std::size_t count = 0;
    for (int y = 0; y < kHeight; y += farfield::kTileSize)
        for (int x = 0; x < kWidth; x += farfield::kTileSize) {
            std::unordered_set<std::uint64_t> names;
            for (int j = 0; j < farfield::kTileSize; ++j)
                for (int i = 0; i < farfield::kTileSize; ++i) {
                    const std::size_t at = visibility.index(x + i, y + j);
                    if (visibility.instance[at] != farfield::kSkyInstance)
                        names.insert(std::uint64_t(visibility.instance[at]) << 32 | visibility.triangle[at]);
                }
            count += names.size();
        }
    return count;
}

double sky_percent(const farfield::VisibilityBuffer& visibility) {
    std::size_t sky = 0;
    for (int y = 0; y < kHeight; ++y)
        for (int x = 0; x < kWidth; ++x) sky += visibility.instance[visibility.index(x, y)] == farfield::kSkyInstance;
    return 100.0 * double(sky) / (kWidth * kHeight);
}

Shot make_shot(std::string name, const scene::StaticScene& scene, farfield::RayCaster& caster, double x, double above,
               double z, double yaw, double pitch, shading::ShadeSettings settings = {}) {
    Camera camera;
    camera.position = {x, bench::town_height(float(x), float(z)) + above, z};
    camera.yaw = yaw;
    camera.pitch = pitch;
    Shot shot{std::move(name), &scene, make_view(camera, kWidth, kHeight), settings, {}, {}};
    shot.visibility.resize(kWidth, kHeight);
    caster.cast_tiles(shot.view, whole_image(), shot.visibility);
    return shot;
}

void write_ppm(const std::string& path, const shading::Image& image) {
    if (std::FILE* file = std::fopen(path.c_str(), "wb")) {
        fmt::print(file, "P6 {} {} 255\n", image.width, image.height);
        for (int y = 0; y < image.height; ++y)
            std::for_each_n(&image.pixels[std::size_t(y) * std::size_t(image.stride)], image.width,
                            [&](std::uint32_t c) { std::fwrite(&c, 1, 3, file); });
        std::fclose(file);
    }
}

/// How the vectors of eight pixels are made up, percent of all.
struct Vectors {
    double sky = 0, one_triangle = 0, more = 0;  ///< all sky, one triangle, the rest
};

Vectors count_vectors(const farfield::VisibilityBuffer& visibility) {
    Vectors vectors;
    constexpr double kShare = 100.0 / (kWidth / 8 * kHeight);
    for (int y = 0; y < kHeight; ++y)
        for (int x = 0; x < kWidth; x += 8) {
            const std::size_t at = visibility.index(x, y);
            bool same = true;
            for (std::size_t i = at; i < at + 8; ++i)
                same &= visibility.instance[i] == visibility.instance[at] &&
                        (visibility.triangle[i] == visibility.triangle[at] ||
                         visibility.instance[i] == farfield::kSkyInstance);
            const bool sky = visibility.instance[at] == farfield::kSkyInstance;
            (!same ? vectors.more : sky ? vectors.sky : vectors.one_triangle) += kShare;
        }
    return vectors;
}

/// Sixteen frames of a pack's walk, evenly.
int run_pack(const std::string& pack, const std::string& walk_name, int laps, const char* folder) {
    const Result<bench::PackWalk> opened = bench::open_pack_walk(pack, walk_name);
    if (!opened) {
        fmt::print(stderr, "bench_shading: {}\n", opened.error().message);
        return 3;
    }
    const scene::Walk& walk = *opened->walk;
    constexpr std::size_t kViews = 16;
    const scene::StaticScene& scene = opened->world->scene();
    const auto caster = farfield::make_beam_caster(scene);
    const auto tiles = whole_image();
    farfield::VisibilityBuffer visibility;
    visibility.resize(kWidth, kHeight);
    shading::Image image;
    image.resize(kWidth, kHeight);
    std::vector<double> ms[2];
    Vectors vectors;
    double triangles = 0;
    for (int lap = 0; lap < laps; ++lap)
        for (std::size_t i = 0; i < kViews; ++i) {
            const PinholeView view = make_view(walk.camera(i * walk.frames.size() / kViews), kWidth, kHeight);
            for (int workers = 1; workers <= 2; ++workers) {
                const WorkerLimit limit(workers);
                caster->cast_tiles(view, tiles, visibility);
                const Stopwatch watch;
                const bench::CpuWatch cpu;
                shading::shade_tiles(scene, {}, view, visibility, tiles, {}, image);
                ms[workers - 1].push_back(workers == 1 ? cpu.milliseconds() : watch.milliseconds());
            }
            if (lap > 0) continue;
            const Vectors here = count_vectors(visibility);
            vectors.sky += here.sky / kViews;
            vectors.one_triangle += here.one_triangle / kViews;
            vectors.more += here.more / kViews;
            triangles += double(tile_triangles(visibility)) / double(kViews * tiles.size());
            if (folder != nullptr) write_ppm(fmt::format("{}/{}.ppm", folder, i), image);
        }
    for (std::vector<double>& times : ms) std::sort(times.begin(), times.end());
    fmt::print(
        "640x480, {} laps of {} views; {:.1f} triangles a tile; vectors of 8: {:.0f}% sky, {:.0f}% one triangle, "
        "{:.0f}% more\nms, median (best): one worker, CPU {:.2f} ({:.2f}); two, wall {:.2f} ({:.2f})\n",
        laps, kViews, triangles, vectors.sky, vectors.one_triangle, vectors.more, ms[0][ms[0].size() / 2], ms[0][0],
        ms[1][ms[1].size() / 2], ms[1][0]);
    return 0;
}

}  // namespace

int main(int argc, char** argv) {
    if (const std::string name = argc > 1 ? argv[1] : ""; name.find(':') != std::string::npos)
        return run_pack(name.substr(0, name.rfind(':')), name.substr(name.rfind(':') + 1),
                        argc > 2 ? std::atoi(argv[2]) : 5, argc > 3 ? argv[3] : nullptr);
    const int laps = argc > 1 ? std::atoi(argv[1]) : 41;
    scene::SceneData town = bench::make_town({.cells = 6});
    scene::SceneData wood = bench::make_town({.cells = 3, .buildings = 4, .trees = 3000});
    town.prelit_colors = scene::make_prelit_colors(town);
    wood.prelit_colors = scene::make_prelit_colors(wood);
    const scene::StaticScene town_scene = town.view(), wood_scene = wood.view();
    const auto town_caster = farfield::make_embree_caster(town_scene);
    const auto wood_caster = farfield::make_embree_caster(wood_scene);
    constexpr float kPrelitBeyondM[] = {1000.0f, 300.0f, 100.0f, 0.0f};

    std::vector<Shot> shots;
    shots.push_back(make_shot("town, street", town_scene, *town_caster, 40, 1.7, 20, 1.3, 0.02));
    shots.push_back(make_shot("town, roofs", town_scene, *town_caster, 130, 80, -115, 3.9, -0.4));
    for (const float beyond_m : kPrelitBeyondM)
        shots.push_back(make_shot(fmt::format("  prelit beyond {} m", beyond_m), town_scene, *town_caster, 130, 80,
                                  -115, 3.9, -0.4, {.prelit_beyond_m = beyond_m}));
    shots.push_back(make_shot("wood, inside", wood_scene, *wood_caster, 40, 1.7, 20, 1.3, 0.02));
    shots.push_back(make_shot("wood, above", wood_scene, *wood_caster, 40, 60, 20, 0.7, -0.3));
    for (const float beyond_m : kPrelitBeyondM)
        shots.push_back(make_shot(fmt::format("  prelit beyond {} m", beyond_m), wood_scene, *wood_caster, 40, 60, 20,
                                  0.7, -0.3, {.prelit_beyond_m = beyond_m}));
    shots.push_back(make_shot("sky", town_scene, *town_caster, 40, 80, 20, 0.3, 0.9));

    const auto tiles = whole_image();
    shading::Image image;
    image.resize(kWidth, kHeight);
    shading::Image full;
    full.resize(kWidth, kHeight);
    for (Shot& shot : shots) {
        shading::shade_tiles(*shot.scene, {}, shot.view, shot.visibility, tiles, {}, full);
        shading::shade_tiles(*shot.scene, {}, shot.view, shot.visibility, tiles, shot.settings, image);
        shot.psnr_db = shading::compare_images(image, full, 0).psnr_db;
    }
    for (int lap = 0; lap < laps; ++lap)
        for (Shot& shot : shots)
            for (int workers = 1; workers <= 2; ++workers) {
                const WorkerLimit limit(workers);
                const Stopwatch watch;
                const bench::CpuWatch cpu;
                shading::shade_tiles(*shot.scene, {}, shot.view, shot.visibility, tiles, shot.settings, image);
                // Alone: processor time, which others on the machine disturb less. Two: what the frame waits for.
                shot.ms[workers - 1].push_back(workers == 1 ? cpu.milliseconds() : watch.milliseconds());
                if (lap == 0 && workers == 1 && argc > 2)
                    write_ppm(fmt::format("{}/{}.ppm", argv[2], &shot - shots.data()), image);
            }
    fmt::print("640x480, {} laps; ms: median (best)\n{:<28}{:>8}{:>16}{:>18}{:>18}{:>8}\n", laps, "", "sky %",
               "triangles*tiles", "1 worker, CPU", "2, wall", "dB");
    for (Shot& shot : shots) {
        for (std::vector<double>& ms : shot.ms) std::sort(ms.begin(), ms.end());
        const auto times = [&](int i) {
            return fmt::format("{:.2f} ({:.2f})", shot.ms[i][std::size_t(laps / 2)], shot.ms[i][0]);
        };
        fmt::print("{:<28}{:>8.1f}{:>16}{:>18}{:>18}{:>8.1f}\n", shot.name, sky_percent(shot.visibility),
                   tile_triangles(shot.visibility), times(0), times(1), shot.psnr_db);
    }
}
