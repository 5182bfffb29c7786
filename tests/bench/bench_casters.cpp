// One table of all ray casters: build time, memory, and rays per second of
// processor time over whole images, sparse masks, foliage.
// Usage: bench_casters [cells a side] [terrain quads a cell and side] [workers]

#include <embree3/rtcore.h>
#include <fmt/core.h>

#include <algorithm>
#include <cstdlib>
#include <functional>
#include <vector>

#include "engine/core/jobs.h"
#include "engine/farfield/embree_caster.h"
#include "engine/farfield/ray_caster.h"
#include "tests/bench/bench_world.h"
#include "tests/bench/cpu_watch.h"

namespace {

using namespace ff;
using farfield::RayCaster;
using farfield::TileRequest;
using farfield::VisibilityBuffer;

constexpr int kWidth = 640, kHeight = 480;
constexpr int kLaps = 9;

/// Tiles of an image with each pixel kept by `keep(x, y)`.
std::vector<TileRequest> tiles_where(const std::function<bool(int, int)>& keep) {
    std::vector<TileRequest> tiles;
    for (int y = 0; y < kHeight; y += farfield::kTileSize)
        for (int x = 0; x < kWidth; x += farfield::kTileSize) {
            TileRequest tile{std::uint16_t(x), std::uint16_t(y), {}};
            bool any = false;
            for (int j = 0; j < farfield::kTileSize; ++j)
                for (int i = 0; i < farfield::kTileSize; ++i)
                    if (keep(x + i, y + j)) {
                        tile.rows[j] = std::uint16_t(tile.rows[j] | 1u << i);
                        any = true;
                    }
            if (any) tiles.push_back(tile);
        }
    return tiles;
}

std::vector<PinholeView> bench_views() {
    std::vector<PinholeView> views;
    for (int i = 0; i < 4; ++i) {
        Camera camera;
        const double x = 40.0 + 30.0 * i, z = 20.0 - 45.0 * i;
        camera.position = {x, bench::town_height(float(x), float(z)) + (i == 3 ? 80.0 : 1.7), z};
        camera.yaw = 1.3 * i;
        camera.pitch = i == 3 ? -0.4 : 0.02;
        views.push_back(make_view(camera, kWidth, kHeight));
    }
    return views;
}

/// Median over laps of the time for all views, as millions of rays a second.
double rate(RayCaster& caster, const std::vector<PinholeView>& views, const std::vector<TileRequest>& tiles,
            VisibilityBuffer& out) {
    std::vector<double> laps;
    std::uint64_t rays = 0;
    for (int lap = 0; lap < kLaps; ++lap) {
        const bench::CpuWatch watch;
        rays = 0;
        for (const PinholeView& view : views) rays += caster.cast_tiles(view, tiles, out).rays;
        laps.push_back(watch.seconds());
    }
    std::sort(laps.begin(), laps.end());
    return double(rays) / laps[laps.size() / 2] * 1e-6;
}

/// Embree alone: packets whose directions were made beforehand, hits left where they are. What the caster is held to.
class RawEmbree {
  public:
    RawEmbree(const scene::StaticScene& scene, RTCSceneFlags flags) : device_(rtcNewDevice(nullptr)) {
        top_ = rtcNewScene(device_);
        rtcSetSceneFlags(top_, flags);
        for (const scene::Instance& instance : scene.instances) {
            const scene::Mesh& mesh = scene.meshes[instance.mesh];
            RTCGeometry geometry = rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_TRIANGLE);
            auto* vertices = static_cast<Vec3*>(rtcSetNewGeometryBuffer(
                geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, sizeof(Vec3), mesh.vertex_count));
            for (std::uint32_t v = 0; v < mesh.vertex_count; ++v)
                vertices[v] = Vec3(DMat3(instance.world_from_mesh) * DVec3(scene.positions[mesh.first_vertex + v]) +
                                   instance.position - scene.origin);
            rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, scene.indices.data(),
                                       std::size_t(mesh.first_triangle) * 12, 12, mesh.triangle_count);
            rtcCommitGeometry(geometry);
            rtcAttachGeometry(top_, geometry);
            rtcReleaseGeometry(geometry);
        }
        rtcCommitScene(top_);
        origin_ = scene.origin;
    }
    ~RawEmbree() {
        rtcReleaseScene(top_);
        rtcReleaseDevice(device_);
    }

    double rate16(const std::vector<PinholeView>& views) {
        return rate_of<RTCRayHit16, 16>(views,
                                        [&](const int* valid, RTCIntersectContext* context, RTCRayHit16* packet) {
                                            rtcIntersect16(valid, top_, context, packet);
                                        });
    }
    double rate8(const std::vector<PinholeView>& views) {
        return rate_of<RTCRayHit8, 8>(views, [&](const int* valid, RTCIntersectContext* context, RTCRayHit8* packet) {
            rtcIntersect8(valid, top_, context, packet);
        });
    }

  private:
    template <class Packet, int kLanes>
    double rate_of(const std::vector<PinholeView>& views, auto&& intersect) {
        constexpr int kRows = kLanes / 4;
        std::vector<double> seconds(kLaps, 0.0);
        for (const PinholeView& view : views) {
            std::vector<Packet> fresh(std::size_t(kWidth) * kHeight / kLanes);
            std::size_t next = 0;
            for (int ty = 0; ty < kHeight; ty += 16)
                for (int tx = 0; tx < kWidth; tx += 16)
                    for (int y = ty; y < ty + 16; y += kRows)
                        for (int x = tx; x < tx + 16; x += 4) {
                            Packet& p = fresh[next++];
                            p = Packet{};
                            const Vec3 origin(view.position - origin_);
                            for (int lane = 0; lane < kLanes; ++lane) {
                                const Vec3 d = view.direction(x + lane % 4, y + lane / 4);
                                p.ray.org_x[lane] = origin.x, p.ray.org_y[lane] = origin.y;
                                p.ray.org_z[lane] = origin.z;
                                p.ray.dir_x[lane] = d.x, p.ray.dir_y[lane] = d.y, p.ray.dir_z[lane] = d.z;
                                p.ray.tfar[lane] = 1e30f;
                                p.ray.mask[lane] = ~0u;
                                p.hit.geomID[lane] = RTC_INVALID_GEOMETRY_ID;
                            }
                        }
            for (int lap = 0; lap < kLaps; ++lap) {
                std::vector<Packet> packets = fresh;
                const bench::CpuWatch watch;
                parallel_ranges(packets.size(), 8 * 256 / kLanes, [&](std::size_t begin, std::size_t end) {
                    RTCIntersectContext context;
                    rtcInitIntersectContext(&context);
                    context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
                    alignas(64) int valid[kLanes];
                    std::fill_n(valid, kLanes, -1);
                    for (std::size_t i = begin; i < end; ++i) intersect(valid, &context, &packets[i]);
                });
                seconds[std::size_t(lap)] += watch.seconds();
            }
        }
        std::sort(seconds.begin(), seconds.end());
        return double(views.size()) * kWidth * kHeight / seconds[kLaps / 2] * 1e-6;
    }

    RTCDevice device_;
    RTCScene top_;
    WorldPos origin_;
};

void print_row(const char* name, RayCaster& caster, RayCaster& foliage_opaque, RayCaster& foliage_masked) {
    const auto views = bench_views();
    VisibilityBuffer out;
    out.resize(kWidth, kHeight);
    const auto all = tiles_where([](int, int) { return true; });
    const auto hash = [](int x, int y) { return (std::uint32_t(x) * 73856093u ^ std::uint32_t(y) * 19349663u) >> 7; };
    const auto half = tiles_where([&](int x, int y) { return hash(x, y) % 2 == 0; });
    const auto eighth = tiles_where([&](int x, int y) { return hash(x, y) % 8 == 0; });
    const auto edges = tiles_where([](int x, int y) { return (x + y / 3) % 37 < 2; });
    const double full_rate = rate(caster, views, all, out);
    fmt::print("| {} | {:.2f} | {:.0f} | {:.1f} | {:.1f} | {:.1f} | {:.1f} |", name, caster.build_seconds(),
               double(caster.memory_bytes()) / 1048576.0, full_rate, rate(caster, views, half, out),
               rate(caster, views, eighth, out), rate(caster, views, edges, out));
    fmt::print(" {:.1f} | {:.1f} |\n", rate(foliage_opaque, views, all, out), rate(foliage_masked, views, all, out));
}

}  // namespace

int main(int argc, char** argv) {
    bench::TownSize size;
    size.trees = 0;
    if (argc > 1) size.cells = std::atoi(argv[1]);
    if (argc > 2) size.terrain_quads = std::atoi(argv[2]);
    const WorkerLimit limit(argc > 3 ? std::atoi(argv[3]) : 0);
    const scene::SceneData town = bench::make_town(size);
    bench::TownSize wood = size;
    wood.buildings = 9;
    wood.trees = 600;
    const scene::SceneData masked = bench::make_town(wood);
    wood.masked_trees = false;
    const scene::SceneData opaque = bench::make_town(wood);
    const auto view_of = [](const scene::SceneData& d) {
        return scene::StaticScene{.origin = d.origin,
                                  .bounds = d.bounds,
                                  .positions = d.positions,
                                  .attributes = d.attributes,
                                  .indices = d.indices,
                                  .triangle_materials = d.triangle_materials,
                                  .meshes = d.meshes,
                                  .instances = d.instances,
                                  .materials = d.materials,
                                  .textures = d.textures,
                                  .texels = d.texels};
    };
    const scene::StaticScene scene = view_of(town), masked_scene = view_of(masked), opaque_scene = view_of(opaque);
    fmt::print("{} triangles, {} workers; Mrays/s\n\n", town.triangle_materials.size(), worker_count());
    const auto views = bench_views();
    {
        RawEmbree raw(scene, RTC_SCENE_FLAG_NONE), robust(scene, RTC_SCENE_FLAG_ROBUST);
        fmt::print("Embree alone: 16 wide {:.1f}, 8 wide {:.1f}; robust {:.1f}, {:.1f}\n\n", raw.rate16(views),
                   raw.rate8(views), robust.rate16(views), robust.rate8(views));
    }
    fmt::print("| caster | build s | MiB | full | half | eighth | edges | foliage opaque | foliage masked |\n");
    fmt::print("|---|---|---|---|---|---|---|---|---|\n");
    const auto embree_row = [&](const char* name, const farfield::EmbreeOptions& options) {
        const auto caster = make_embree_caster(scene, options);
        const auto caster_opaque = make_embree_caster(opaque_scene, options);
        const auto caster_masked = make_embree_caster(masked_scene, options);
        print_row(name, *caster, *caster_opaque, *caster_masked);
    };
    {
        const auto grid = farfield::make_grid_caster(scene);
        print_row("regular grid", *grid, *farfield::make_grid_caster(opaque_scene),
                  *farfield::make_grid_caster(masked_scene));
    }
    embree_row("Embree 16 robust", {.packet_width = 16});
    embree_row("Embree 8 robust", {.packet_width = 8});
    embree_row("Embree 16 fast", {.packet_width = 16, .robust = false});
    embree_row("Embree 8 fast", {.packet_width = 8, .robust = false});
    embree_row("Embree 16 compact", {.packet_width = 16, .compact = true});
    return 0;
}
