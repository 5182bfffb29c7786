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
constexpr std::uint32_t kNoTriangle = 0xFFFFFFFFu;
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
    std::optional<farfield::MirrorPlane> plane;
    float f0 = 0.0f;
    bool fades = false;
};

Facet facet_of(const MirrorInput& input, std::uint32_t id, std::uint32_t triangle) {
    const scene::StaticScene& scene = input.scene;
    const scene::Instance& instance = *instance_of(scene, input.dynamic, id);
    const std::size_t index = std::size_t(scene.meshes[instance.mesh].first_triangle) + triangle;
    const scene::Material& material = scene.materials[scene.triangle_materials[index]];
    const Vec4& color = material.base_color;
    const bool is_water = (material.flags & scene::kMaterialWater) != 0;
    const float metallic = is_water ? 0.0f : material.metallic;
    return {.plane = mirror_plane(scene, instance, triangle, input.view.position),
            .f0 = std::lerp(shading::kDielectric, std::max({color.x, color.y, color.z}), metallic),
            .fades = !is_water};
}

}  // namespace

MirrorFlags MirrorTest::flags_of(std::uint32_t instance) {
    if (instance == instance_) return flags_;
    instance_ = instance;
    triangle_ = kNoTriangle;
    kind_ = MirrorKind::none;
    const scene::Instance* const seen = instance_of(scene_, dynamic_, instance);
    mesh_ = seen != nullptr ? &scene_.meshes[seen->mesh] : nullptr;
    flags_ = mesh_ != nullptr ? mesh_->material_flags & (scene::kMaterialWater | scene::kMaterialMirror) : 0;
    return flags_;
}

MirrorKind MirrorTest::operator()(std::uint32_t instance, std::uint32_t triangle) {
    if (flags_of(instance) == 0 || triangle == triangle_) return kind_;
    triangle_ = triangle;
    kind_ = MirrorKind::none;
    if (triangle >= mesh_->triangle_count) return kind_;
    const scene::Material& material =
        scene_.materials[scene_.triangle_materials[std::size_t(mesh_->first_triangle) + triangle]];
    if (scene::is_mirror(material))
        kind_ = (material.flags & scene::kMaterialWater) != 0 ? MirrorKind::water : MirrorKind::glass;
    return kind_;
}

bool MirrorTest::is_plain_row(const std::uint32_t* instance) {
    unsigned other = 0;
    for (int i = 0; i < kTileSize; ++i)
        other |= unsigned(instance[i] != plain_) & unsigned(instance[i] != kSkyInstance);
    if (other == 0) return true;
    if (flags_of(instance[0]) == 0) plain_ = instance[0];
    return false;
}

std::uint16_t MirrorTest::mirrors_of_row(const std::uint32_t* instance, const std::uint32_t* triangle) {
    if (is_plain_row(instance)) return 0;
    unsigned mirrors = 0;
    for (int i = 0; i < kTileSize; ++i) mirrors |= unsigned((*this)(instance[i], triangle[i]) != MirrorKind::none) << i;
    return std::uint16_t(mirrors);
}

std::optional<farfield::MirrorPlane> mirror_plane(const scene::StaticScene& scene, const scene::Instance& instance,
                                                  std::uint32_t triangle, const WorldPos& eye) {
    const scene::Mesh& mesh = scene.meshes[instance.mesh];
    const std::size_t index = std::size_t(mesh.first_triangle) + triangle;
    const DMat3 to_world(instance.world_from_mesh);
    DVec3 corner[3];
    for (std::size_t k = 0; k < 3; ++k)
        corner[k] = to_world * DVec3(scene.positions[mesh.first_vertex + scene.indices[3 * index + k]]) +
                    (instance.position - eye);
    DVec3 normal = glm::cross(corner[1] - corner[0], corner[2] - corner[0]);
    const double length = glm::length(normal);
    if (!(length > 0.0)) return std::nullopt;
    normal /= length;
    double height = -glm::dot(normal, corner[0]);
    if (height < 0.0) {
        normal = -normal;
        height = -height;
    }
    if (!(height > 1e-3)) return std::nullopt;
    return farfield::MirrorPlane{Vec3(normal), height};
}

Mirrors::Mirrors(int width, int height, int least_step) {
    const auto reduced = [&](int pixels) { return std::size_t(tiles_along((pixels + least_step - 1) / least_step)); };
    const std::size_t tiles = reduced(width) * reduced(height);
    asked_.reserve(std::size_t(tiles_along(width)) * std::size_t(tiles_along(height)));
    const std::size_t pixels = tiles * std::size_t(kTileSize) * std::size_t(kTileSize);
    for (auto* names : {&instance_, &triangle_}) names->resize(pixels);
    for (auto* planes : {&plane_, &widened_}) planes->resize(pixels);
    rows_.resize(tiles * kTileSize);
    for (auto* flags : {&is_asked_, &has_mirrors_}) flags->resize(tiles);
    for (auto* lists : {&mirror_tiles_, &wide_tiles_}) lists->reserve(tiles);
    looked_at_.reserve(tiles);
    planes_.reserve(kMostPlanes);
    for (auto& list : tiles_) list.reserve(tiles);
}

std::uint64_t Mirrors::find(const MirrorInput& input, int step) {
    width_ = (input.view.width + step - 1) / step;
    height_ = (input.view.height + step - 1) / step;
    tiles_x_ = tiles_along(width_);
    tiles_y_ = tiles_along(height_);
    stride_ = tiles_x_ * kTileSize;
    for (auto* flags : {&is_asked_, &has_mirrors_}) flags->resize(std::size_t(tiles_x_) * std::size_t(tiles_y_));
    find_asked(input, step);
    probe(input, step);
    list_tiles();
    assign_planes(input, step);
    keep_largest();
    widen();
    return collect_tiles();
}

/// Calls visit(x, y, index) for the pixels of a tile of the reduced image.
template <class Visit>
void Mirrors::visit_pixels(std::uint32_t tile, Visit&& visit) const {
    const int x0 = int(tile) % tiles_x_ * kTileSize, y0 = int(tile) / tiles_x_ * kTileSize;
    for (int y = y0; y < std::min(y0 + kTileSize, height_); ++y)
        for (int x = x0; x < std::min(x0 + kTileSize, width_); ++x)
            visit(x, y, std::size_t(y) * std::size_t(stride_) + std::size_t(x));
}

void Mirrors::find_asked(const MirrorInput& input, int step) {
    asked_x_ = tiles_along(input.view.width);
    asked_.assign(std::size_t(asked_x_) * std::size_t(tiles_along(input.view.height)), 0);
    std::fill(is_asked_.begin(), is_asked_.end(), std::uint8_t(0));
    for (std::size_t i = 0; i < input.tiles.size(); ++i) {
        const int x = (input.tiles[i].x - input.left) / kTileSize, y = (input.tiles[i].y - input.top) / kTileSize;
        asked_[std::size_t(y * asked_x_ + x)] = std::uint32_t(i + 1);
        is_asked_[std::size_t(y / step * tiles_x_ + x / step)] = 1;
    }
}

void Mirrors::probe(const MirrorInput& input, int step) {
    const std::size_t tiles_per_task = step == 1 ? 32 : 4;
    parallel_ranges(has_mirrors_.size(), tiles_per_task, [&](std::size_t begin, std::size_t end) {
        MirrorTest kind_of(input.scene, input.dynamic);
        for (std::size_t t = begin; t < end; ++t)
            has_mirrors_[t] = std::uint8_t(is_asked_[t] != 0 && probe_tile(input, step, std::uint32_t(t), kind_of));
    });
}

/// Names what the mirrors' pixels of a tile of the reduced image see.
/// @return whether there are any
bool Mirrors::probe_tile(const MirrorInput& input, int step, std::uint32_t tile, MirrorTest& kind_of) {
    const farfield::VisibilityBuffer& seen = input.visibility;
    bool any = false;
    std::uint32_t plain = kSkyInstance;  // the last instance without mirrors: mostly all see the same
    // The last answer, as neighbours see the same.
    std::uint32_t instance = kSkyInstance, triangle = kNoTriangle;
    MirrorKind kind = MirrorKind::none;
    const auto note = [&](int x, int y, std::size_t at) {
        if (seen.instance[at] != instance || seen.triangle[at] != triangle) {
            instance = seen.instance[at];
            triangle = seen.triangle[at];
            kind = kind_of(instance, triangle);
            if (kind_of.flags_of(instance) == 0) plain = instance;
        }
        if (kind == MirrorKind::none) return;
        if (kind == MirrorKind::glass ? !(seen.depth[at] < input.within_m) : seen.depth[at] < input.water_beyond_m)
            return;
        const std::size_t to = std::size_t(y) * std::size_t(stride_) + std::size_t(x);
        if (any && instance_[to] != kSkyInstance) return;
        if (!any) visit_pixels(tile, [&](int, int, std::size_t pixel) { instance_[pixel] = kSkyInstance; });
        any = true;
        instance_[to] = instance;
        triangle_[to] = triangle;
    };
    // Two probes along a side of a pixel at most: what is smaller than half of it may be missed.
    const int apart = step / std::min(step, 2), first = apart / 2;
    const int shift = std::countr_zero(unsigned(step));
    unsigned probed = 0;  // columns
    for (int i = first; i < kTileSize; i += apart) probed |= 1u << i;
    const int side = kTileSize / step;  // pixels that a tile of the view has here
    const int x0 = int(tile) % tiles_x_ * step, y0 = int(tile) / tiles_x_ * step;  // tiles of the view
    const int rows = int(asked_.size()) / asked_x_;
    for (int ty = y0; ty < std::min(y0 + step, rows); ++ty)
        for (int tx = x0; tx < std::min(x0 + step, asked_x_); ++tx) {
            const std::uint32_t place = asked_[std::size_t(ty * asked_x_ + tx)];
            if (place == 0) continue;
            const farfield::TileRequest& request = input.tiles[place - 1];
            unsigned whole_columns = 0xFFFFu;
            for (const std::uint16_t row : request.rows) whole_columns &= row;
            // Single pixels each for itself, as the probes could miss them.
            const bool is_strewn = whole_columns == 0;
            for (int j = is_strewn ? 0 : first; j < kTileSize; j += is_strewn ? 1 : apart) {
                const std::size_t row = seen.index(request.x, request.y + j);
                for (unsigned bits = is_strewn ? request.rows[j] : request.rows[j] & probed; bits != 0;
                     bits &= bits - 1) {
                    const int i = std::countr_zero(bits);
                    const std::size_t at = row + std::size_t(i);
                    if (seen.instance[at] != plain) note(tx * side + (i >> shift), ty * side + (j >> shift), at);
                }
            }
        }
    return any;
}

/// Tiles with mirrors, those with a mirror's pixel beside them, and those that anyone who asks is in or beside.
void Mirrors::list_tiles() {
    mirror_tiles_.clear();
    wide_tiles_.clear();
    looked_at_.clear();
    for (int y = 0; y < tiles_y_; ++y)
        for (int x = 0; x < tiles_x_; ++x) {
            const auto tile = std::uint32_t(y * tiles_x_ + x);
            unsigned near = 0, asked = 0;
            for (int ny = std::max(0, y - 1); ny <= std::min(tiles_y_ - 1, y + 1); ++ny)
                for (int nx = std::max(0, x - 1); nx <= std::min(tiles_x_ - 1, x + 1); ++nx) {
                    near |= has_mirrors_[std::size_t(ny * tiles_x_ + nx)];
                    asked |= is_asked_[std::size_t(ny * tiles_x_ + nx)];
                }
            if (asked == 0) continue;
            looked_at_.push_back({std::uint16_t(x * kTileSize), std::uint16_t(y * kTileSize), {}});
            if (has_mirrors_[tile] != 0) mirror_tiles_.push_back(tile);
            if (near == 0) continue;
            wide_tiles_.push_back(tile);
            if (has_mirrors_[tile] == 0) visit_pixels(tile, [&](int, int, std::size_t at) { plane_[at] = kNone; });
        }
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
    for (const std::uint32_t tile : mirror_tiles_) {
        visit_pixels(tile, [&](int x, int y, std::size_t at) {
            plane_[at] = kNone;
            if (instance_[at] == kSkyInstance) return;
            if (instance_[at] != instance || triangle_[at] != triangle) {
                instance = instance_[at];
                triangle = triangle_[at];
                facet = facet_of(input, instance, triangle);
                plane = kNone;
            }
            if (!facet.plane) return;
            const Vec3 ray = input.view.direction(std::min(x * step + step / 2, input.view.width - 1),
                                                  std::min(y * step + step / 2, input.view.height - 1));
            const float slope = -glm::dot(ray, facet.plane->normal);
            if (facet.fades && !(facet.plane->height_m < double(input.within_m) * double(slope))) return;
            if (!(shading::reflection_share(slope / glm::length(ray), facet.f0) > 0.0f)) return;
            // Only now: what shows nothing takes no place among the planes.
            if (plane == kNone) plane = find_plane(*facet.plane);
            if (plane == kNone) return;
            plane_[at] = plane;
            ++planes_[plane].pixels;
        });
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
    std::fill_n(rows_.begin(), std::size_t(tiles_x_) * std::size_t(tiles_y_) * kTileSize, std::uint16_t(0));
    for (const std::uint32_t tile : mirror_tiles_)
        visit_pixels(tile, [&](int x, int y, std::size_t at) {
            if (plane_[at] == kNone) return;
            plane_[at] = place[plane_[at]];
            if (plane_[at] == kNone) return;
            std::uint16_t& row = rows_[std::size_t(tile) * kTileSize + std::size_t(y % kTileSize)];
            row = std::uint16_t(row | 1u << x % kTileSize);
        });
}

/// The pixels of a row of a tile that have planes, by bits from 16 on, with those of the tiles to its left and right.
std::uint64_t Mirrors::row_around(int tile_x, int y) const {
    if (y < 0 || y >= tiles_y_ * kTileSize) return 0;
    std::uint64_t around = 0;
    for (int k = -1; k <= 1; ++k) {
        if (tile_x + k < 0 || tile_x + k >= tiles_x_) continue;
        const auto tile = std::size_t(y / kTileSize * tiles_x_ + tile_x + k);
        around |= std::uint64_t(rows_[tile * kTileSize + std::size_t(y % kTileSize)]) << (kTileSize * (k + 1));
    }
    return around;
}

/// Pixels beside mirrors are asked for, too: what is filtered, and what waves bend rays to.
void Mirrors::widen() {
    if (found_ == 0) return;
    constexpr int kReach = 2;
    parallel_ranges(wide_tiles_.size(), 4, [&](std::size_t begin, std::size_t end) {
        for (const std::uint32_t tile : std::span(wide_tiles_).subspan(begin, end - begin)) {
            const int tile_x = int(tile) % tiles_x_, y0 = int(tile) / tiles_x_ * kTileSize;
            std::uint64_t around[kTileSize + 2 * kReach];
            for (int j = -kReach; j < kTileSize + kReach; ++j) around[j + kReach] = row_around(tile_x, y0 + j);
            for (int j = 0; j < kTileSize; ++j) {
                const std::size_t first = std::size_t(y0 + j) * std::size_t(stride_) + std::size_t(tile_x * kTileSize);
                std::uint8_t* const row = widened_.data() + first;
                const std::uint64_t* const here = around + j + kReach;
                std::copy_n(plane_.data() + first, kTileSize, row);
                std::uint64_t beside = 0;
                for (int reach = 1; reach <= kReach; ++reach)
                    for (const std::uint64_t other : {here[-reach], *here, here[reach]})
                        beside |= other | other << reach | other >> reach;
                for (unsigned left = unsigned((beside & ~*here) >> kTileSize) & 0xFFFFu; left != 0; left &= left - 1) {
                    const int i = std::countr_zero(left);
                    if (tile_x * kTileSize + i >= width_ || y0 + j >= height_) continue;
                    // The nearest plane, along rows and columns first.
                    constexpr int kX[] = {0, -1, 1, 0, -1, 1, -1, 1}, kY[] = {-1, 0, 0, 1, -1, -1, 1, 1};
                    std::uint8_t plane = kNone;
                    for (int reach = 1; reach <= kReach && plane == kNone; ++reach)
                        for (int k = 0; k < 8 && plane == kNone; ++k) {
                            const int dx = reach * kX[k], dy = reach * kY[k];
                            if ((here[dy] >> (kTileSize + i + dx) & 1u) != 0)
                                plane = plane_[first + std::size_t(i) + std::size_t(dy * stride_ + dx)];
                        }
                    row[i] = plane;
                }
            }
        }
    });
}

std::uint64_t Mirrors::collect_tiles() {
    for (auto& list : tiles_) list.clear();
    if (found_ == 0) return 0;
    std::uint64_t pixels = 0;
    for (const std::uint32_t tile : wide_tiles_) {
        const int x0 = int(tile) % tiles_x_ * kTileSize, y0 = int(tile) / tiles_x_ * kTileSize;
        std::array<farfield::TileRequest, kMost> requests;
        std::uint32_t present = 0;  // planes, by bits
        visit_pixels(tile, [&](int x, int y, std::size_t at) {
            const std::uint8_t plane = widened_[at];
            if (plane == kNone) return;
            if ((present >> plane & 1u) == 0) requests[plane] = {std::uint16_t(x0), std::uint16_t(y0), {}};
            present |= 1u << plane;
            std::uint16_t& row = requests[plane].rows[y - y0];
            row = std::uint16_t(row | 1u << (x - x0));
            ++pixels;
        });
        for (; present != 0; present &= present - 1) {
            const auto plane = std::size_t(std::countr_zero(present));
            tiles_[plane].push_back(requests[plane]);
        }
    }
    return pixels;
}

}  // namespace ff::effects
