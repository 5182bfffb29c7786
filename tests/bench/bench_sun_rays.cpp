// Sun rays against Embree's occlusion queries, the same points and the same sun, on sixteen views of a pack's walk: one
// worker, interleaved, in processor time. Whole images; a tenth of the pixels, strewn; the edge pixels alone. Ours has
// to find the points and their normals first; "points given" and Embree's rays are made beforehand.
// Usage: bench_sun_rays PACK.ffpack:WALK [laps] [views] [width] [height] [ours [row]]: without Embree, and of one
// row only, for profiles

#include <embree3/rtcore.h>
#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "engine/core/jobs.h"
#include "engine/farfield/alpha_test.h"
#include "engine/farfield/ray_caster.h"
#include "engine/farfield/sun_rays.h"
#include "engine/farfield/sun_rays_reference.h"
#include "tests/bench/cpu_watch.h"
#include "tests/bench/pack_walk.h"
#include "tests/support/tiles.h"

namespace {

using namespace ff;
using farfield::TileRequest;

/// A hit is none where its material lets light through. Rays carry their footprint as their time: nothing moves here.
void filter_see_through(const RTCFilterFunctionNArguments* a) {
    const auto& scene = *static_cast<const scene::StaticScene*>(a->geometryUserPtr);
    std::uint32_t last_instance = RTC_INVALID_GEOMETRY_ID, last_triangle = 0;
    farfield::AlphaSurface surface;
    for (unsigned lane = 0; lane < a->N; ++lane) {
        if (a->valid[lane] == 0) continue;
        const std::uint32_t placed = RTCHitN_instID(a->hit, a->N, lane, 0);
        const std::uint32_t instance = placed == RTC_INVALID_GEOMETRY_ID ? RTCHitN_geomID(a->hit, a->N, lane) : placed;
        const std::uint32_t triangle = RTCHitN_primID(a->hit, a->N, lane);
        if (instance != last_instance || triangle != last_triangle)
            surface = farfield::make_alpha_surface(scene, scene.instances[instance], instance, triangle);
        last_instance = instance, last_triangle = triangle;
        if (!is_opaque_at(surface, RTCHitN_u(a->hit, a->N, lane), RTCHitN_v(a->hit, a->N, lane),
                          RTCRayN_time(a->ray, a->N, lane)))
            a->valid[lane] = 0;
    }
}

/// The scene as Embree has it fastest: meshes that stand once put into the world, others instanced.
class EmbreeShadows {
  public:
    explicit EmbreeShadows(const scene::StaticScene& scene) : scene_(scene), device_(rtcNewDevice(nullptr)) {
        top_ = rtcNewScene(device_);
        std::vector<std::uint32_t> uses(scene.meshes.size(), 0);
        for (const scene::Instance& instance : scene.instances) ++uses[instance.mesh];
        std::vector<RTCScene> of_mesh(scene.meshes.size(), nullptr);
        for (std::uint32_t id = 0; id < scene.instances.size(); ++id) {
            const scene::Instance& instance = scene.instances[id];
            const DVec3 offset = instance.position - scene.origin;
            if (scene.meshes[instance.mesh].triangle_count == 0) continue;
            if (uses[instance.mesh] == 1) {
                attach(top_, instance.mesh, id, DMat3(instance.world_from_mesh), offset);
                continue;
            }
            RTCScene& sub = of_mesh[instance.mesh];
            if (sub == nullptr) {
                sub = rtcNewScene(device_);
                attach(sub, instance.mesh, 0, DMat3(1.0), DVec3(0.0));
                rtcCommitScene(sub);
            }
            const Mat3& m = instance.world_from_mesh;
            const Vec3 o(offset);
            const float columns[12] = {m[0].x, m[0].y, m[0].z, m[1].x, m[1].y, m[1].z,
                                       m[2].x, m[2].y, m[2].z, o.x,    o.y,    o.z};
            RTCGeometry placed = rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_INSTANCE);
            rtcSetGeometryInstancedScene(placed, sub);
            rtcSetGeometryTransform(placed, 0, RTC_FORMAT_FLOAT3X4_COLUMN_MAJOR, columns);
            rtcCommitGeometry(placed);
            rtcAttachGeometryByID(top_, placed, id);
            rtcReleaseGeometry(placed);
        }
        for (RTCScene sub : of_mesh)
            if (sub != nullptr) rtcReleaseScene(sub);
        rtcCommitScene(top_);
    }
    ~EmbreeShadows() {
        rtcReleaseScene(top_);
        rtcReleaseDevice(device_);
    }
    EmbreeShadows(const EmbreeShadows&) = delete;
    EmbreeShadows& operator=(const EmbreeShadows&) = delete;

    /// Rays as Embree takes them, kLanes at a time, in the given order.
    template <class Packet, int kLanes>
    static std::vector<Packet> packets_of(const WorldPos& scene_origin, std::span<const farfield::ShadowRay> rays) {
        std::vector<Packet> packets((rays.size() + kLanes - 1) / kLanes);
        for (std::size_t i = 0; i < packets.size() * kLanes; ++i) {
            Packet& p = packets[i / kLanes];
            const std::size_t lane = i % kLanes;
            const farfield::ShadowRay& ray = rays[std::min(i, rays.size() - 1)];
            const Vec3 origin(ray.origin - scene_origin), direction(ray.direction);
            p.org_x[lane] = origin.x, p.org_y[lane] = origin.y, p.org_z[lane] = origin.z;
            p.dir_x[lane] = direction.x, p.dir_y[lane] = direction.y, p.dir_z[lane] = direction.z;
            p.tnear[lane] = 0.0f;
            p.tfar[lane] = i < rays.size() ? 1e30f : -1.0f;
            p.time[lane] = ray.footprint_m;
            p.mask[lane] = ~0u;
        }
        return packets;
    }

    void occluded(std::vector<RTCRay16>& packets) const {
        run(packets, [&](auto* valid, auto* context, RTCRay16& p) { rtcOccluded16(valid, top_, context, &p); });
    }
    void occluded(std::vector<RTCRay8>& packets) const {
        run(packets, [&](auto* valid, auto* context, RTCRay8& p) { rtcOccluded8(valid, top_, context, &p); });
    }
    void occluded(std::vector<RTCRay>& rays) const {
        RTCIntersectContext context;
        rtcInitIntersectContext(&context);
        for (RTCRay& ray : rays) rtcOccluded1(top_, &context, &ray);
    }

  private:
    template <class Packet>
    void run(std::vector<Packet>& packets, auto&& query) const {
        RTCIntersectContext context;
        rtcInitIntersectContext(&context);
        context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
        alignas(64) int valid[16];
        std::fill_n(valid, 16, -1);
        for (Packet& packet : packets) query(valid, &context, packet);
    }

    void attach(RTCScene to, std::uint32_t mesh_id, std::uint32_t id, const DMat3& axes, const DVec3& offset) {
        const scene::Mesh& mesh = scene_.meshes[mesh_id];
        RTCGeometry geometry = rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_TRIANGLE);
        auto* vertices = static_cast<Vec3*>(rtcSetNewGeometryBuffer(
            geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, sizeof(Vec3), mesh.vertex_count));
        for (std::uint32_t v = 0; v < mesh.vertex_count; ++v)
            vertices[v] = Vec3(axes * DVec3(scene_.positions[mesh.first_vertex + v]) + offset);
        rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, scene_.indices.data(),
                                   std::size_t(mesh.first_triangle) * 12, 12, mesh.triangle_count);
        if ((mesh.material_flags & (scene::kMaterialAlphaMask | scene::kMaterialBlend)) != 0) {
            rtcSetGeometryUserData(geometry, &scene_);
            rtcSetGeometryOccludedFilterFunction(geometry, filter_see_through);
        }
        rtcCommitGeometry(geometry);
        rtcAttachGeometryByID(to, geometry, id);
        rtcReleaseGeometry(geometry);
    }

    scene::StaticScene scene_;
    RTCDevice device_;
    RTCScene top_;
};

std::vector<TileRequest> tiles_where(int width, int height, const std::function<bool(int, int)>& keep) {
    std::vector<TileRequest> tiles;
    for (TileRequest tile : test::all_tiles(width, height)) {
        bool any = false;
        for (int row = 0; row < farfield::kTileSize; ++row) {
            tile.rows[row] = 0;
            for (int i = 0; i < farfield::kTileSize; ++i)
                if (keep(tile.x + i, tile.y + row)) tile.rows[row] = std::uint16_t(tile.rows[row] | 1u << i);
            any |= tile.rows[row] != 0;
        }
        if (any) tiles.push_back(tile);
    }
    return tiles;
}

/// Pixels beside another surface: another instance, or a depth that differs by a twentieth.
bool is_edge(const farfield::VisibilityBuffer& visibility, int x, int y) {
    if (x + 1 >= visibility.width || y + 1 >= visibility.height) return false;
    const std::size_t at = visibility.index(x, y);
    const auto differs = [&](std::size_t other) {
        const float ratio = visibility.depth[at] / visibility.depth[other];
        return visibility.instance[at] != visibility.instance[other] || !(std::abs(ratio - 1.0f) < 0.05f);
    };
    return differs(visibility.index(x + 1, y)) || differs(visibility.index(x, y + 1));
}

/// The rays of the requests, in blocks of 4 x 4 pixels, and the pixels they belong to.
struct Rays {
    std::vector<farfield::ShadowRay> rays;
    std::vector<std::size_t> pixels;
};
Rays rays_of(const scene::StaticScene& scene, const PinholeView& view, const farfield::VisibilityBuffer& visibility,
             std::span<const TileRequest> tiles, const Vec3& to_sun) {
    Rays out;
    for (const TileRequest& tile : tiles)
        for (int i = 0; i < farfield::kTileSize * farfield::kTileSize; ++i) {
            const int column = i / 16 % 4 * 4 + i % 4, row = i / 64 * 4 + i / 4 % 4;
            const int x = tile.x + column, y = tile.y + row;
            if (((tile.rows[row] >> column) & 1) == 0 || x >= view.width || y >= view.height) continue;
            const farfield::SunQuestion question = sun_question_reference(scene, view, visibility, {}, to_sun, x, y);
            if (question.kind != farfield::SunQuestion::Kind::ray) continue;
            out.rays.push_back(question.ray);
            out.pixels.push_back(visibility.index(x, y));
        }
    return out;
}

struct Row {
    enum Way : std::size_t { kOurs, kPoints, k16, k8, k1, kWays };
    const char* name;
    std::uint64_t rays = 0, lit = 0, different = 0, nodes = 0, triangles = 0;
    std::array<double, kWays> least{}, middle{};  // seconds
};

void run_view(const scene::StaticScene& scene, farfield::SunRays& ours, const EmbreeShadows* embree,
              const PinholeView& view, const farfield::VisibilityBuffer& visibility, std::span<const TileRequest> tiles,
              const Vec3& to_sun, int laps, Row& row) {
    Rays rays;
    if (embree != nullptr) rays = rays_of(scene, view, visibility, tiles, to_sun);
    const auto fresh16 = EmbreeShadows::packets_of<RTCRay16, 16>(scene.origin, rays.rays);
    const auto fresh8 = EmbreeShadows::packets_of<RTCRay8, 8>(scene.origin, rays.rays);
    std::vector<RTCRay> fresh1(rays.rays.size());
    for (std::size_t i = 0; i < fresh1.size(); ++i) {
        const RTCRay8& p = fresh8[i / 8];
        const std::size_t lane = i % 8;
        fresh1[i] = {.org_x = p.org_x[lane],
                     .org_y = p.org_y[lane],
                     .org_z = p.org_z[lane],
                     .tnear = 0.0f,
                     .dir_x = p.dir_x[lane],
                     .dir_y = p.dir_y[lane],
                     .dir_z = p.dir_z[lane],
                     .time = p.time[lane],
                     .tfar = 1e30f,
                     .mask = ~0u,
                     .id = 0,
                     .flags = 0};
    }
    std::vector<std::uint8_t> lit(visibility.depth.size(), 0);
    std::array<std::vector<double>, Row::kWays> seconds;
    farfield::CastCost cost;
    const auto timed = [&](std::size_t way, auto&& work) {
        const bench::CpuWatch watch;
        work();
        seconds[way].push_back(watch.seconds());
    };
    // The very rays that Embree gets.
    std::vector<farfield::SunPoint> points;
    for (const farfield::ShadowRay& ray : rays.rays)
        points.push_back({.position = Vec3(ray.origin - view.position), .footprint_m = ray.footprint_m});
    std::vector<std::uint8_t> lit_points(points.size());
    std::vector<RTCRay8> packets8;
    for (int lap = 0; lap < laps; ++lap) {
        // Every input has just been written, as it has in a frame.
        const farfield::VisibilityBuffer seen = visibility;
        timed(Row::kOurs, [&] { cost = ours.cast(view, seen, tiles, {}, to_sun, lit.data()); });
        if (embree == nullptr) continue;
        timed(Row::kPoints, [&] { ours.cast_points(view.position, points, {}, to_sun, lit_points.data()); });
        std::vector<RTCRay16> packets16 = fresh16;
        packets8 = fresh8;
        std::vector<RTCRay> single = fresh1;
        timed(Row::k16, [&] { embree->occluded(packets16); });
        timed(Row::k8, [&] { embree->occluded(packets8); });
        timed(Row::k1, [&] { embree->occluded(single); });
    }
    for (std::size_t way = 0; way < (embree != nullptr ? std::size_t(Row::kWays) : 1u); ++way) {
        std::sort(seconds[way].begin(), seconds[way].end());
        row.least[way] += seconds[way].front();
        row.middle[way] += seconds[way][seconds[way].size() / 2];
    }
    row.rays += cost.rays;
    row.nodes += cost.nodes;
    row.triangles += cost.triangles;
    for (std::size_t i = 0; i < rays.rays.size(); ++i) {
        const bool sees_sun = lit[rays.pixels[i]] != 0;
        row.lit += sees_sun;
        row.different += sees_sun != (packets8[i / 8].tfar[i % 8] > 0.0f);
    }
}

}  // namespace

int main(int argc, char** argv) {
    const std::string name = argc > 1 ? argv[1] : "";
    const std::size_t colon = name.rfind(':');
    if (colon == std::string::npos) {
        fmt::print(stderr, "bench_sun_rays: PACK.ffpack:WALK [laps] [views] [width] [height]\n");
        return 2;
    }
    const int laps = argc > 2 ? std::atoi(argv[2]) : 5;
    const std::size_t views = argc > 3 ? std::size_t(std::atoi(argv[3])) : 16;
    const int width = argc > 4 ? std::atoi(argv[4]) : 640, height = argc > 5 ? std::atoi(argv[5]) : 480;
    const Result<bench::PackWalk> opened = bench::open_pack_walk(name.substr(0, colon), name.substr(colon + 1));
    if (!opened) {
        fmt::print(stderr, "bench_sun_rays: {}\n", opened.error().message);
        return 3;
    }
    const WorkerLimit limit(1);
    const scene::StaticScene scene = opened->world->scene();
    const scene::Walk& walk = *opened->walk;
    const Vec3 to_sun = scene.environment.to_sun;
    farfield::SunRays ours(scene);
    const bool is_alone = argc > 6 && std::string(argv[6]) == "ours";
    const std::size_t only = argc > 7 ? std::size_t(std::atoi(argv[7])) : 3;
    const auto embree = is_alone ? nullptr : std::make_unique<EmbreeShadows>(scene);
    const auto beams = farfield::make_beam_caster(scene);
    std::array<Row, 3> rows{Row{"whole"}, Row{"random 10%"}, Row{"edges"}};
    farfield::VisibilityBuffer visibility;
    visibility.resize(width, height);
    const auto all = test::all_tiles(width, height);
    const auto is_strewn = [](int x, int y) {
        std::uint32_t h = std::uint32_t(x) * 0x9E3779B1u ^ std::uint32_t(y) * 0x85EBCA77u;
        h = (h ^ (h >> 15)) * 0x2C1B3C6Du;
        return ((h ^ (h >> 12)) >> 8) % 10 == 0;
    };
    const auto strewn = tiles_where(width, height, is_strewn);
    for (std::size_t i = 0; i < views; ++i) {
        const PinholeView view = make_view(walk.camera(i * walk.frames.size() / views), width, height);
        beams->cast_tiles(view, all, visibility);
        const auto edges = tiles_where(width, height, [&](int x, int y) { return is_edge(visibility, x, y); });
        const std::array<std::vector<TileRequest>, 3> requests = {all, strewn, edges};
        for (std::size_t r = 0; r < rows.size(); ++r)
            if (only == rows.size() || only == r)
                run_view(scene, ours, embree.get(), view, visibility, requests[r], to_sun, laps, rows[r]);
    }
    fmt::print("{}, {} views, Mrays/s by the least and by the median of {} laps\n", name, views, laps);
    for (const Row& row : rows) {
        const auto rate = [&](std::size_t way, bool least) {
            return double(row.rays) / (least ? row.least[way] : row.middle[way]) * 1e-6;
        };
        const auto ratio = [&](std::size_t way, bool least) {
            return rate(way, least) / std::max({rate(Row::k16, least), rate(Row::k8, least), rate(Row::k1, least)});
        };
        fmt::print("{:10} | {:7} rays a view, {:3.0f}% lit | ours {:5.1f} {:5.1f}, points given {:5.1f} {:5.1f}",
                   row.name, row.rays / views, 100.0 * double(row.lit) / double(row.rays), rate(Row::kOurs, true),
                   rate(Row::kOurs, false), rate(Row::kPoints, true), rate(Row::kPoints, false));
        fmt::print(
            " | Embree 16 {:5.1f} {:5.1f}, 8 {:5.1f} {:5.1f}, 1 {:5.1f} {:5.1f} | ours/best {:4.2f} {:4.2f}, {:4.2f} "
            "{:4.2f}",
            rate(Row::k16, true), rate(Row::k16, false), rate(Row::k8, true), rate(Row::k8, false), rate(Row::k1, true),
            rate(Row::k1, false), ratio(Row::kOurs, true), ratio(Row::kOurs, false), ratio(Row::kPoints, true),
            ratio(Row::kPoints, false));
        fmt::print(" | {:4.0f} ppm differ | a ray: {:.2f} nodes, {:.2f} triangles\n",
                   1e6 * double(row.different) / double(row.rays), double(row.nodes) / double(row.rays),
                   double(row.triangles) / double(row.rays));
    }
    return 0;
}
