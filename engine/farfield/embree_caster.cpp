#include "engine/farfield/embree_caster.h"

#include <embree3/rtcore.h>

#include <atomic>
#include <cmath>
#include <limits>
#include <vector>

#include "engine/core/check.h"
#include "engine/core/jobs.h"
#include "engine/core/stopwatch.h"
#include "engine/farfield/embree_caster_alpha.h"
#include "engine/farfield/embree_caster_packets.h"
#include "engine/farfield/float_ray.h"
#include "engine/farfield/tile_regroup.h"

namespace ff::farfield {
namespace {

using scene::Instance;
using scene::Mesh;
using scene::StaticScene;

/// Tiles that one task casts: leftovers regroup within them, so more give fuller packets and fewer give better balance.
constexpr std::size_t kTilesPerTask = 8;
constexpr std::size_t kRaysPerTask = 1024;

bool count_memory(void* bytes, ssize_t change, bool) {
    static_cast<std::atomic<std::int64_t>*>(bytes)->fetch_add(change, std::memory_order_relaxed);
    return true;
}

void report_error(void*, RTCError code, const char* text) {
    FF_CHECK(code == RTC_ERROR_NONE, "Embree error {}: {}", int(code), text);
}

RTCGeometry make_triangles(RTCDevice device, RTCBuildQuality quality, const std::uint32_t* indices,
                           std::uint32_t triangle_count) {
    RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
    rtcSetGeometryBuildQuality(geometry, quality);
    rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, indices, 0,
                               3 * sizeof(std::uint32_t), triangle_count);
    return geometry;
}

class EmbreeCaster final : public RayCaster {
  public:
    EmbreeCaster(const StaticScene& scene, const EmbreeOptions& options);
    ~EmbreeCaster() override;

    CastCost cast_tiles(const PinholeView& view, std::span<const TileRequest> tiles, VisibilityBuffer& out) override {
        return cast(view, tiles, false, out);
    }
    CastCost cast_tiles_beyond(const PinholeView& view, std::span<const TileRequest> tiles,
                               VisibilityBuffer& out) override {
        return cast(view, tiles, true, out);
    }
    CastCost cast_rays(std::span<const Ray> rays, std::span<RayHit> hits) override;
    [[nodiscard]] std::uint64_t memory_bytes() const override {
        return std::uint64_t(device_bytes_.load(std::memory_order_relaxed)) + own_bytes_;
    }
    [[nodiscard]] double build_seconds() const override { return build_seconds_; }

  private:
    CastCost cast(const PinholeView& view, std::span<const TileRequest> tiles, bool beyond, VisibilityBuffer& out);
    void attach_direct(const StaticScene& scene, std::uint32_t instance_id);
    void attach_instances(const StaticScene& scene, std::uint32_t mesh_id, std::span<const std::uint32_t> instances);
    void set_alpha_filter(RTCGeometry geometry, std::uint32_t mesh_id);

    StaticScene scene_;  ///< spans of the caller's arrays, which outlive the caster
    const WorldPos origin_;
    RTCSceneFlags scene_flags_ = RTC_SCENE_FLAG_NONE;
    RTCDevice device_ = nullptr;
    RTCScene top_ = nullptr;
    int packet_width_ = 16;
    std::atomic<std::int64_t> device_bytes_{0};
    std::uint64_t own_bytes_ = 0;
    double build_seconds_ = 0.0;
    std::vector<std::vector<Vec3>> moved_vertices_;  ///< of direct meshes, relative to origin_
};

EmbreeCaster::EmbreeCaster(const StaticScene& scene, const EmbreeOptions& options)
    : scene_(scene), origin_(scene.origin) {
    const Stopwatch watch;
    if (options.robust) scene_flags_ = RTCSceneFlags(scene_flags_ | RTC_SCENE_FLAG_ROBUST);
    if (options.compact) scene_flags_ = RTCSceneFlags(scene_flags_ | RTC_SCENE_FLAG_COMPACT);
    device_ = rtcNewDevice(nullptr);
    FF_CHECK(device_ != nullptr, "Embree finds no usable processor: error {}", int(rtcGetDeviceError(nullptr)));
    rtcSetDeviceErrorFunction(device_, report_error, nullptr);
    rtcSetDeviceMemoryMonitorFunction(device_, count_memory, &device_bytes_);
    // Embree traverses 16 lanes at once only with AVX-512; on AVX2 packets of 8 are the faster ones.
    const bool has_16 = rtcGetDeviceProperty(device_, RTC_DEVICE_PROPERTY_NATIVE_RAY16_SUPPORTED) != 0;
    packet_width_ = options.packet_width != 0 ? options.packet_width : has_16 ? 16 : 8;
    FF_CHECK(packet_width_ == 8 || packet_width_ == 16, "packets of {} rays; 8 or 16", packet_width_);

    top_ = rtcNewScene(device_);
    rtcSetSceneFlags(top_, scene_flags_);

    // Which instances each mesh has, in the order of their ids.
    std::vector<std::uint32_t> first(scene.meshes.size() + 1, 0);
    for (const Instance& instance : scene.instances) ++first[instance.mesh + 1];
    for (std::size_t m = 0; m < scene.meshes.size(); ++m) first[m + 1] += first[m];
    std::vector<std::uint32_t> of_mesh(scene.instances.size());
    std::vector<std::uint32_t> next(first.begin(), first.end() - 1);
    for (std::uint32_t i = 0; i < scene.instances.size(); ++i) of_mesh[next[scene.instances[i].mesh]++] = i;

    for (std::uint32_t m = 0; m < scene.meshes.size(); ++m) {
        const std::uint32_t count = first[m + 1] - first[m];
        if (count == 0 || scene.meshes[m].triangle_count == 0) continue;
        if (count == 1)
            attach_direct(scene, of_mesh[first[m]]);
        else
            attach_instances(scene, m, std::span(of_mesh).subspan(first[m], count));
    }
    rtcCommitScene(top_);
    build_seconds_ = watch.seconds();
}

EmbreeCaster::~EmbreeCaster() {
    rtcReleaseScene(top_);
    rtcReleaseDevice(device_);
}

void EmbreeCaster::set_alpha_filter(RTCGeometry geometry, std::uint32_t mesh_id) {
    constexpr std::uint32_t kSeeThrough = scene::kMaterialAlphaMask | scene::kMaterialBlend;
    if ((scene_.meshes[mesh_id].material_flags & kSeeThrough) == 0) return;
    rtcSetGeometryUserData(geometry, &scene_);
    rtcSetGeometryIntersectFilterFunction(geometry, embree::filter_see_through);
}

/// A mesh that stands in the world once is part of the top scene itself: no second traversal, and the builder sees all
/// such triangles together. Its vertices are rounded once from exact world positions, so that cells that share a
/// border keep sharing it.
void EmbreeCaster::attach_direct(const StaticScene& scene, std::uint32_t instance_id) {
    const Instance& instance = scene.instances[instance_id];
    const Mesh& mesh = scene.meshes[instance.mesh];
    const DVec3 offset = instance.position - origin_;
    const DMat3 axes(instance.world_from_mesh);
    std::vector<Vec3> moved;
    moved.reserve(mesh.vertex_count + 2);  // Embree reads 16 bytes at each vertex
    for (const Vec3& p : scene.positions.subspan(mesh.first_vertex, mesh.vertex_count))
        moved.push_back(Vec3(axes * DVec3(p) + offset));
    moved.resize(mesh.vertex_count + 2, Vec3(0.0f));
    own_bytes_ += moved.size() * sizeof(Vec3);
    moved_vertices_.push_back(std::move(moved));

    RTCGeometry geometry = make_triangles(device_, RTC_BUILD_QUALITY_MEDIUM,
                                          &scene.indices[3 * std::size_t(mesh.first_triangle)], mesh.triangle_count);
    rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, moved_vertices_.back().data(), 0,
                               sizeof(Vec3), mesh.vertex_count);
    set_alpha_filter(geometry, instance.mesh);
    rtcCommitGeometry(geometry);
    rtcAttachGeometryByID(top_, geometry, instance_id);
    rtcReleaseGeometry(geometry);
}

void EmbreeCaster::attach_instances(const StaticScene& scene, std::uint32_t mesh_id,
                                    std::span<const std::uint32_t> instances) {
    const Mesh& mesh = scene.meshes[mesh_id];
    RTCScene sub = rtcNewScene(device_);
    rtcSetSceneFlags(sub, scene_flags_);
    RTCGeometry geometry = make_triangles(device_, RTC_BUILD_QUALITY_MEDIUM,
                                          &scene.indices[3 * std::size_t(mesh.first_triangle)], mesh.triangle_count);
    const Vec3* vertices = &scene.positions[mesh.first_vertex];
    if (mesh.first_vertex + std::size_t(mesh.vertex_count) + 1 > scene.positions.size()) {
        // The last mesh of the array has nothing behind it that Embree might read.
        moved_vertices_.emplace_back(vertices, vertices + mesh.vertex_count);
        moved_vertices_.back().resize(mesh.vertex_count + 2, Vec3(0.0f));
        own_bytes_ += moved_vertices_.back().size() * sizeof(Vec3);
        vertices = moved_vertices_.back().data();
    }
    rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, vertices, 0, sizeof(Vec3),
                               mesh.vertex_count);
    set_alpha_filter(geometry, mesh_id);
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(sub, geometry);
    rtcReleaseGeometry(geometry);
    rtcCommitScene(sub);
    for (const std::uint32_t id : instances) {
        const Instance& instance = scene.instances[id];
        const Vec3 offset(instance.position - origin_);
        const Mat3& m = instance.world_from_mesh;
        const float columns[12] = {m[0].x, m[0].y, m[0].z, m[1].x,   m[1].y,   m[1].z,
                                   m[2].x, m[2].y, m[2].z, offset.x, offset.y, offset.z};
        RTCGeometry placed = rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_INSTANCE);
        rtcSetGeometryInstancedScene(placed, sub);
        rtcSetGeometryTransform(placed, 0, RTC_FORMAT_FLOAT3X4_COLUMN_MAJOR, columns);
        rtcCommitGeometry(placed);
        rtcAttachGeometryByID(top_, placed, id);
        rtcReleaseGeometry(placed);
    }
    rtcReleaseScene(sub);
}

/// Whether every ray of the view is one that Embree may be given.
bool is_finite(const PinholeView& view) {
    double sum = view.position.x + view.position.y + view.position.z;
    for (int column = 0; column < 3; ++column)
        for (int row = 0; row < 3; ++row) sum += double(view.world_from_camera[column][row]);
    return std::isfinite(sum + double(view.u_step + view.u_first + view.v_step + view.v_first));
}

CastCost EmbreeCaster::cast(const PinholeView& view, std::span<const TileRequest> tiles, bool beyond,
                            VisibilityBuffer& out) {
    FF_CHECK(out.width >= view.width && out.height >= view.height, "a buffer of {}x{} for a view of {}x{}", out.width,
             out.height, view.width, view.height);
    if (!is_finite(view)) {
        for (const TileRequest& tile : tiles) write_sky(view, tile, out);
        return {.rays = count_pixels(tiles, view.width, view.height)};
    }
    const embree::PacketJob job{top_, &view, Vec3(view.position - origin_), &out, packet_width_, beyond};
    std::atomic<std::uint64_t> rays{0};
    parallel_ranges(tiles.size(), kTilesPerTask, [&](std::size_t begin, std::size_t end) {
        rays.fetch_add(embree::cast_packets(job, tiles.subspan(begin, end - begin)), std::memory_order_relaxed);
    });
    return {.rays = rays.load(std::memory_order_relaxed)};
}

CastCost EmbreeCaster::cast_rays(std::span<const Ray> rays, std::span<RayHit> hits) {
    FF_CHECK(hits.size() >= rays.size(), "{} rays, room for {} hits", rays.size(), hits.size());
    parallel_ranges(rays.size(), kRaysPerTask, [&](std::size_t begin, std::size_t end) {
        embree::CastContext cast;
        rtcInitIntersectContext(&cast.context);
        const auto cast_one = [&](const Ray& from) -> RayHit {
            const Vec3 origin(from.origin - origin_);
            const Vec3& direction = from.direction;
            RTCRayHit ray{};
            ray.ray.org_x = origin.x;
            ray.ray.org_y = origin.y;
            ray.ray.org_z = origin.z;
            ray.ray.dir_x = direction.x;
            ray.ray.dir_y = direction.y;
            ray.ray.dir_z = direction.z;
            ray.ray.tfar = std::numeric_limits<float>::infinity();
            ray.ray.mask = 0xFFFFFFFFu;
            ray.hit.geomID = RTC_INVALID_GEOMETRY_ID;
            ray.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
            const float sum = origin.x + origin.y + origin.z + direction.x + direction.y + direction.z;
            if (std::isfinite(sum)) rtcIntersect1(top_, &cast.context, &ray);
            const bool is_direct = ray.hit.instID[0] == RTC_INVALID_GEOMETRY_ID;
            return {is_direct ? ray.hit.geomID : ray.hit.instID[0], ray.hit.primID, ray.ray.tfar};
        };
        for (std::size_t i = begin; i < end; ++i) hits[i] = cast_float_ray(scene_.bounds, rays[i], cast_one);
    });
    return {.rays = rays.size()};
}

}  // namespace

std::unique_ptr<RayCaster> make_embree_caster(const scene::StaticScene& scene, const EmbreeOptions& options) {
    return std::make_unique<EmbreeCaster>(scene, options);
}

std::unique_ptr<RayCaster> make_embree_caster(const scene::StaticScene& scene) {
    return make_embree_caster(scene, EmbreeOptions{});
}

}  // namespace ff::farfield
