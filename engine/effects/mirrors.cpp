#include "engine/effects/mirrors.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <glm/geometric.hpp>

#include "engine/core/jobs.h"
#include "engine/shading/reflections.h"
#include "engine/shading/shading_model.h"

namespace ff::effects {
namespace {

using farfield::kSkyInstance;
using farfield::kTileSize;

constexpr std::uint8_t kNone = 0xFF;
constexpr std::size_t kMostPlanes = 96;    // looked at before the largest are kept
constexpr std::uint32_t kLeastPixels = 3;  // a plane with fewer is not worth a cast of its own
/// Mirrors whose planes are so near to each other are one: panes of a front.
constexpr float kSamePlane = 0.9999995f;  // cosine: 1 mm in a metre
constexpr double kSamePlaneM = 0.03;

int tiles_along(int pixels) {
    return (pixels + kTileSize - 1) / kTileSize;
}

const scene::Instance* instance_of(const scene::StaticScene& scene, std::span<const scene::Instance> dynamic,
                                   std::uint32_t id) {
    const std::size_t fixed = scene.instances.size();
    if (id < fixed) return &scene.instances[id];
    return id - fixed < dynamic.size() ? &dynamic[id - fixed] : nullptr;
}

/// A triangle's plane and how it mirrors.
struct Facet {
    farfield::MirrorPlane plane;
    float f0 = 0.0f;
    bool fades = false;
    bool exists = false;  ///< not edge on, nor without area
};

Facet facet_of(const MirrorInput& input, std::uint32_t id, std::uint32_t triangle) {
    const scene::StaticScene& scene = input.scene;
    const scene::Instance& instance = *instance_of(scene, input.dynamic, id);
    const scene::Mesh& mesh = scene.meshes[instance.mesh];
    const std::size_t index = std::size_t(mesh.first_triangle) + triangle;
    const scene::Material& material = scene.materials[scene.triangle_materials[index]];
    const DMat3 to_world(instance.world_from_mesh);
    DVec3 corner[3];
    for (std::size_t k = 0; k < 3; ++k)
        corner[k] = to_world * DVec3(scene.positions[mesh.first_vertex + scene.indices[3 * index + k]]) +
                    (instance.position - input.view.position);
    DVec3 normal = glm::cross(corner[1] - corner[0], corner[2] - corner[0]);
    const double length = glm::length(normal);
    if (!(length > 0.0)) return {};
    normal /= length;
    double height = -glm::dot(normal, corner[0]);
    if (height < 0.0) {
        normal = -normal;
        height = -height;
    }
    const Vec4& color = material.base_color;
    const bool is_water = (material.flags & scene::kMaterialWater) != 0;
    const float metallic = is_water ? 0.0f : material.metallic;
    return {.plane = {Vec3(normal), height},
            .f0 = std::lerp(shading::kDielectric, std::max({color.x, color.y, color.z}), metallic),
            .fades = !is_water,
            .exists = height > 1e-3};
}

}  // namespace

bool MirrorTest::operator()(std::uint32_t instance, std::uint32_t triangle) {
    if (instance == instance_ && (triangle == triangle_ || !has_mirrors_)) return is_mirror_;
    if (instance != instance_) {
        const scene::Instance* const seen = instance_of(scene_, dynamic_, instance);
        mesh_ = seen != nullptr ? &scene_.meshes[seen->mesh] : nullptr;
        constexpr std::uint32_t kMirrors = scene::kMaterialWater | scene::kMaterialMirror;
        has_mirrors_ = mesh_ != nullptr && (mesh_->material_flags & kMirrors) != 0;
    }
    instance_ = instance;
    triangle_ = triangle;
    is_mirror_ =
        has_mirrors_ && triangle < mesh_->triangle_count &&
        scene::is_mirror(scene_.materials[scene_.triangle_materials[std::size_t(mesh_->first_triangle) + triangle]]);
    return is_mirror_;
}

Mirrors::Mirrors(int width, int height) {
    const auto tiles = std::size_t(tiles_along(width)) * std::size_t(tiles_along(height));
    const std::size_t pixels = tiles * std::size_t(kTileSize) * std::size_t(kTileSize);
    for (auto* names : {&instance_, &triangle_}) names->resize(pixels);
    for (auto* planes : {&plane_, &widened_}) planes->resize(pixels);
    planes_.reserve(kMostPlanes);
    tiles_.reserve(tiles * kMost);
}

std::uint64_t Mirrors::find(const MirrorInput& input, int step) {
    width_ = (input.view.width + step - 1) / step;
    height_ = (input.view.height + step - 1) / step;
    stride_ = tiles_along(width_) * kTileSize;
    probe(input, step);
    assign_planes(input, step);
    keep_largest();
    widen();
    return collect_tiles();
}

void Mirrors::probe(const MirrorInput& input, int step) {
    // Four probes a pixel at most: what is smaller than half of it may be missed.
    const int probes = std::min(step, 2), apart = step / probes, first = apart / 2;
    parallel_ranges(std::size_t(height_), 8, [&](std::size_t begin, std::size_t end) {
        MirrorTest is_mirror(input.scene, input.dynamic);
        for (std::size_t y = begin; y < end; ++y) {
            std::uint32_t* const instances = instance_.data() + y * std::size_t(stride_);
            std::uint32_t* const triangles = triangle_.data() + y * std::size_t(stride_);
            for (int x = 0; x < width_; ++x) {
                instances[x] = kSkyInstance;
                for (int k = 0; k < probes * probes && instances[x] == kSkyInstance; ++k) {
                    const int px = std::min(x * step + first + k % probes * apart, input.view.width - 1);
                    const int py = std::min(int(y) * step + first + k / probes * apart, input.view.height - 1);
                    const std::size_t at = input.visibility.index(px, py);
                    if (!is_mirror(input.visibility.instance[at], input.visibility.triangle[at])) continue;
                    instances[x] = input.visibility.instance[at];
                    triangles[x] = input.visibility.triangle[at];
                }
            }
        }
    });
}

std::uint8_t Mirrors::find_plane(const farfield::MirrorPlane& plane) {
    const auto same = std::find_if(planes_.begin(), planes_.end(), [&](const Mirror& m) {
        return glm::dot(m.plane.normal, plane.normal) > kSamePlane &&
               std::abs(m.plane.height_m - plane.height_m) < kSamePlaneM;
    });
    if (same != planes_.end()) return std::uint8_t(same - planes_.begin());
    if (planes_.size() == kMostPlanes) return kNone;
    planes_.push_back({.plane = plane});
    return std::uint8_t(planes_.size() - 1);
}

void Mirrors::assign_planes(const MirrorInput& input, int step) {
    planes_.clear();
    std::uint32_t instance = kSkyInstance, triangle = 0;
    Facet facet;
    std::uint8_t plane = kNone;
    for (int y = 0; y < height_; ++y) {
        const std::size_t row = std::size_t(y) * std::size_t(stride_);
        for (int x = 0; x < width_; ++x) {
            const std::size_t at = row + std::size_t(x);
            plane_[at] = kNone;
            if (instance_[at] == kSkyInstance) continue;
            if (instance_[at] != instance || triangle_[at] != triangle) {
                instance = instance_[at];
                triangle = triangle_[at];
                facet = facet_of(input, instance, triangle);
                plane = kNone;
            }
            if (!facet.exists) continue;
            const Vec3 ray = input.view.direction(std::min(x * step + step / 2, input.view.width - 1),
                                                  std::min(y * step + step / 2, input.view.height - 1));
            const float slope = -glm::dot(ray, facet.plane.normal);
            if (facet.fades && !(facet.plane.height_m < double(input.within_m) * double(slope))) continue;
            if (!(shading::reflection_share(slope / glm::length(ray), facet.f0) > 0.0f)) continue;
            // Only now: what shows nothing takes no place among the planes.
            if (plane == kNone) plane = find_plane(facet.plane);
            if (plane == kNone) continue;
            plane_[at] = plane;
            ++planes_[plane].pixels;
        }
    }
}

void Mirrors::keep_largest() {
    std::array<std::uint8_t, kMostPlanes> order{}, place{};
    const std::size_t count = planes_.size();
    for (std::size_t i = 0; i < count; ++i) order[i] = std::uint8_t(i);
    std::sort(order.begin(), order.begin() + std::ptrdiff_t(count), [&](std::uint8_t a, std::uint8_t b) {
        return planes_[a].pixels != planes_[b].pixels ? planes_[a].pixels > planes_[b].pixels : a < b;
    });
    std::array<Mirror, kMost> largest;
    found_ = 0;
    place.fill(kNone);
    for (std::size_t i = 0; i < std::min(count, kMost) && planes_[order[i]].pixels >= kLeastPixels; ++i) {
        place[order[i]] = std::uint8_t(found_);
        largest[found_++] = planes_[order[i]];
    }
    std::copy_n(largest.begin(), found_, planes_.begin());
    for (int y = 0; y < height_; ++y) {
        std::uint8_t* const row = plane_.data() + std::size_t(y) * std::size_t(stride_);
        for (int x = 0; x < width_; ++x)
            if (row[x] != kNone) row[x] = place[row[x]];
    }
}

/// Pixels beside mirrors are asked for, too: what is filtered, and what waves bend rays to.
void Mirrors::widen() {
    if (found_ == 0) return;
    parallel_ranges(std::size_t(height_), 8, [&](std::size_t begin, std::size_t end) {
        for (std::size_t row = begin; row < end; ++row) {
            const int y = int(row);
            for (int x = 0; x < width_; ++x) {
                const auto at = [&](int dx, int dy) {
                    const int nx = x + dx, ny = y + dy;
                    return nx < 0 || ny < 0 || nx >= width_ || ny >= height_
                               ? kNone
                               : plane_[std::size_t(ny) * std::size_t(stride_) + std::size_t(nx)];
                };
                std::uint8_t plane = at(0, 0);
                for (int reach = 1; reach <= 2 && plane == kNone; ++reach)
                    for (int k = 0; k < 8 && plane == kNone; ++k) {
                        constexpr int kX[] = {0, -1, 1, 0, -1, 1, -1, 1}, kY[] = {-1, 0, 0, 1, -1, -1, 1, 1};
                        plane = at(reach * kX[k], reach * kY[k]);
                    }
                widened_[row * std::size_t(stride_) + std::size_t(x)] = plane;
            }
        }
    });
}

std::uint64_t Mirrors::collect_tiles() {
    tiles_.clear();
    std::uint64_t pixels = 0;
    for (std::size_t p = 0; p < found_; ++p) {
        planes_[p].first_tile = std::uint32_t(tiles_.size());
        for (int y = 0; y < height_; y += kTileSize)
            for (int x = 0; x < width_; x += kTileSize) {
                farfield::TileRequest tile{std::uint16_t(x), std::uint16_t(y), {}};
                std::uint64_t count = 0;
                for (int j = 0; j < std::min(kTileSize, height_ - y); ++j) {
                    const std::uint8_t* const row = widened_.data() + std::size_t(y + j) * std::size_t(stride_) + x;
                    unsigned bits = 0;
                    for (int i = 0; i < std::min(kTileSize, width_ - x); ++i) bits |= unsigned(row[i] == p) << i;
                    tile.rows[j] = std::uint16_t(bits);
                    count += std::uint64_t(std::popcount(bits));
                }
                if (count == 0) continue;
                tiles_.push_back(tile);
                pixels += count;
            }
        planes_[p].tile_count = std::uint32_t(tiles_.size()) - planes_[p].first_tile;
    }
    return pixels;
}

}  // namespace ff::effects
