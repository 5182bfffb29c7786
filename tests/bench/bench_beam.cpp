// Tile beams against Embree's packets on the same views, interleaved frame by frame: medians, and the pixels in which
// they differ (another primitive at a depth that differs by more than 1e-4), with whom an oracle in double finds wrong
// there. One worker in processor time, which other programs on the machine disturb least; two workers in wall time.
// Usage: bench_beam [world name, "all" or PACK.ffpack:WALK] [width] [height] [laps]

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <ctime>
#include <functional>
#include <string>
#include <vector>

#include "engine/core/jobs.h"
#include "engine/core/stopwatch.h"
#include "engine/farfield/embree_caster.h"
#include "engine/farfield/ray_caster.h"
#include "engine/farfield/visibility_difference.h"
#include "tests/bench/beam_oracle.h"
#include "tests/bench/pack_walk.h"
#include "tests/support/worlds.h"

namespace {

using namespace ff;
using farfield::CastCost;
using farfield::RayCaster;
using farfield::TileRequest;
using farfield::VisibilityBuffer;

struct World {
    const char* name;
    std::function<scene::SceneData()> make;
    double spread_m;  // cameras stand within this square
    double eye_m;
};

const std::vector<World>& worlds() {
    static const std::vector<World> all = {
        {"city", [] { return test::make_city({.cells = 16, .subdivisions = 5}); }, 1000.0, 1.7},
        {"city-above", [] { return test::make_city({.cells = 16, .subdivisions = 5}); }, 1000.0, 90.0},
        {"boxes", [] { return test::make_city({.cells = 16, .subdivisions = 1}); }, 1000.0, 1.7},
        {"forest", [] { return test::make_forest({.trees = 1200, .size_m = 200, .masked = false, .leaves = 3000}); },
         120.0, 1.7},
        {"forest-masked",
         [] { return test::make_forest({.trees = 1200, .size_m = 200, .masked = true, .leaves = 400}); }, 120.0, 1.7},
        {"terrain", [] { return test::make_terrain({.size_m = 8000, .spacing_m = 10}); }, 3000.0, 85.0},
    };
    return all;
}

std::vector<TileRequest> all_tiles(int width, int height) {
    std::vector<TileRequest> tiles;
    for (int y = 0; y < height; y += farfield::kTileSize) {
        for (int x = 0; x < width; x += farfield::kTileSize) {
            TileRequest tile{.x = std::uint16_t(x), .y = std::uint16_t(y)};
            for (std::uint16_t& row : tile.rows) row = 0xFFFF;
            tiles.push_back(tile);
        }
    }
    return tiles;
}

// Cameras at crossings of the city's streets, which is anywhere elsewhere.
std::vector<PinholeView> views_of(const World& world, int width, int height) {
    std::vector<PinholeView> views;
    test::Random random(11);
    for (int i = 0; i < 8; ++i) {
        Camera camera;
        const auto place = [&] { return std::round(random.in(-0.5, 0.5) * world.spread_m / 40.0) * 40.0; };
        camera.position = {place(), world.eye_m, place()};
        camera.yaw = random.in(-kPi, kPi);
        camera.pitch = world.eye_m > 50.0 ? -0.3 : 0.03;
        views.push_back(make_view(camera, width, height));
    }
    return views;
}

double processor_ms() {
    timespec now{};
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
    return double(now.tv_sec) * 1e3 + double(now.tv_nsec) * 1e-6;
}

double median(std::vector<double> values) {
    std::sort(values.begin(), values.end());
    return values[values.size() / 2];
}

void run(const std::string& name, const scene::StaticScene& scene, std::span<const PinholeView> views, int width,
         int height, int laps) {
    const auto embree = farfield::make_embree_caster(scene, {});
    const auto fast = farfield::make_embree_caster(scene, {.robust = false});
    const auto beam = farfield::make_beam_caster(scene);
    const std::array<RayCaster*, 3> casters = {embree.get(), fast.get(), beam.get()};
    const auto tiles = all_tiles(width, height);
    std::array<std::array<std::vector<double>, 2>, 3> ms;
    std::array<VisibilityBuffer, 3> images;
    for (VisibilityBuffer& image : images) image.resize(width, height);
    std::uint64_t different = 0, embree_wrong = 0, beam_wrong = 0, pixels = 0, nodes = 0, triangles = 0;
    for (int lap = 0; lap < laps; ++lap) {
        for (const PinholeView& view : views) {
            for (int workers = 1; workers <= 2; ++workers) {
                const WorkerLimit limit(workers);
                for (std::size_t c = 0; c < casters.size(); ++c) {
                    const Stopwatch watch;
                    const double processor = processor_ms();
                    const CastCost cost = casters[c]->cast_tiles(view, tiles, images[c]);
                    ms[c][std::size_t(workers - 1)].push_back(workers == 1 ? processor_ms() - processor
                                                                           : watch.milliseconds());
                    if (lap == 0 && workers == 1 && c == 2) {
                        nodes += cost.nodes;
                        triangles += cost.triangles;
                    }
                }
            }
            if (lap > 0) continue;
            for (int y = 0; y < height; ++y) {
                for (int x = 0; x < width; ++x) {
                    const std::size_t at = images[0].index(x, y);
                    ++pixels;
                    if (!farfield::is_wrong_pixel(images[2], images[0], at)) continue;
                    const bench::ExactHit exact = bench::find_exact_hit(scene, view, x, y);
                    ++different;
                    embree_wrong += bench::is_wrong(images[0], at, exact);
                    beam_wrong += bench::is_wrong(images[2], at, exact);
                }
            }
        }
    }
    const double per_tile = 1.0 / double(tiles.size() * views.size());
    const auto ppm = [&](std::uint64_t count) { return 1e6 * double(count) / double(pixels); };
    const auto figure = [&](std::size_t c, std::size_t w) { return median(ms[c][w]); };
    fmt::print(
        "{:14} {:8} tri | embree {:6.2f} {:6.2f} ms | fast {:6.2f} {:6.2f} | beam {:6.2f} {:6.2f} ms, {:4.0f} "
        "Mrays/s | ratio {:4.2f} {:4.2f} | {:5.1f} ppm differ, of them Embree wrong {:.1f}, beams {:.1f} | a tile: "
        "{:.1f} nodes, {:.0f} triangles\n",
        name, scene.triangle_materials.size(), figure(0, 0), figure(0, 1), figure(1, 0), figure(1, 1), figure(2, 0),
        figure(2, 1), width * height / figure(2, 1) * 1e-3, std::min(figure(0, 0), figure(1, 0)) / figure(2, 0),
        std::min(figure(0, 1), figure(1, 1)) / figure(2, 1), ppm(different), ppm(embree_wrong), ppm(beam_wrong),
        double(nodes) * per_tile, double(triangles) * per_tile);
}

// Sixteen frames of a pack's walk, evenly.
int run_pack(const std::string& pack, const std::string& walk_name, int width, int height, int laps) {
    const Result<bench::PackWalk> opened = bench::open_pack_walk(pack, walk_name);
    if (!opened) {
        fmt::print(stderr, "bench_beam: {}\n", opened.error().message);
        return 3;
    }
    const scene::Walk& walk = *opened->walk;
    std::vector<PinholeView> views;
    for (std::size_t i = 0; i < 16; ++i)
        views.push_back(make_view(walk.camera(i * walk.frames.size() / 16), width, height));
    run(walk_name, opened->world->scene(), views, width, height, laps);
    return 0;
}

}  // namespace

int main(int argc, char** argv) {
    const std::string name = argc > 1 ? argv[1] : "all";
    const int width = argc > 2 ? std::atoi(argv[2]) : 640, height = argc > 3 ? std::atoi(argv[3]) : 480;
    const int laps = argc > 4 ? std::atoi(argv[4]) : 5;
    if (const std::size_t colon = name.rfind(':'); colon != std::string::npos)
        return run_pack(name.substr(0, colon), name.substr(colon + 1), width, height, laps);
    for (const World& world : worlds()) {
        if (name != "all" && name != world.name) continue;
        const scene::SceneData data = world.make();
        run(world.name, data.view(), views_of(world, width, height), width, height, laps);
    }
    return 0;
}
