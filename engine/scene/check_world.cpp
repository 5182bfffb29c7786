#include "engine/scene/check_world.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <mutex>
#include <vector>

#include "engine/core/jobs.h"
#include "engine/scene/check_animation.h"
#include "engine/scene/mesh_slices.h"

namespace ff::scene {
namespace {

constexpr double kMaxBound = 4.0 * kMaxWorldCoordinate;  // of a box around things that stand within the limit
constexpr float kMaxScale = 1e6f;
constexpr double kMinDeterminant = 1e-30;
constexpr std::size_t kGrain = 1u << 16;
constexpr std::size_t kMaxNameBytes = 1024;
constexpr std::uint32_t kMaxTextureSide = 8192;
constexpr std::uint32_t kMaxPanoramaSide = 16384;
constexpr std::uint32_t kMaxGridSize = 4096;
constexpr std::uint32_t kKnownMaterialFlags = 0xFF;

bool is_finite(float x) {
    return (std::bit_cast<std::uint32_t>(x) & 0x7F800000u) != 0x7F800000u;
}
bool is_within(double x, double low, double high) {
    return x >= low && x <= high;  // false for a NaN
}
bool is_within(const DVec3& p, double limit) {
    return is_within(p.x, -limit, limit) && is_within(p.y, -limit, limit) && is_within(p.z, -limit, limit);
}
bool is_within(const Vec3& p, double low, double high) {
    return is_within(p.x, low, high) && is_within(p.y, low, high) && is_within(p.z, low, high);
}
bool is_box(const DBox3& box) {
    return !box.is_empty() && is_within(box.low, kMaxBound) && is_within(box.high, kMaxBound);
}
bool is_rotation_and_scale(const Mat3& m) {
    for (int column = 0; column < 3; ++column)
        if (!is_within(m[column], -kMaxScale, kMaxScale)) return false;
    const DVec3 a(m[0]), b(m[1]), c(m[2]);
    const double determinant =
        a.x * (b.y * c.z - b.z * c.y) - b.x * (a.y * c.z - a.z * c.y) + c.x * (a.y * b.z - a.z * b.y);
    return std::abs(determinant) >= kMinDeterminant;
}

class Checker {
  public:
    Checker(const StaticScene& scene, const WorldInfo& info, std::uint64_t leaf_count)
        : s_(scene), info_(info), leaf_count_(leaf_count) {}

    std::optional<WorldProblem> run() {
        // Later checks rely on earlier ones.
        if (check_sizes() && check_textures() && check_materials() && check_meshes() && check_cells() &&
            check_instances() && check_vertices() && check_triangles() && check_mesh_trees() && check_instance_tree() &&
            check_height_grid() && check_environment() && check_lamps() && check_sounds() && check_simulated() &&
            check_info())
            return std::nullopt;
        return problem_;
    }

  private:
    // Of several problems found at once the one with the lowest element counts: the same for any number of workers.
    bool report(std::string_view array, std::uint64_t element, std::string what) {
        const std::scoped_lock lock(mutex_);
        if (!problem_ || element < problem_->element) problem_ = {array, element, std::move(what)};
        return false;
    }

    template <class Ok, class Describe>
    bool each(std::string_view array, std::size_t count, Ok&& ok, Describe&& describe) {
        parallel_ranges(count, kGrain, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i)
                if (!ok(i)) [[unlikely]] {
                    report(array, i, describe(i));
                    return;
                }
        });
        return !problem_;
    }

    bool check_sizes();
    bool check_textures();
    bool check_materials();
    bool check_meshes();
    bool check_cells();
    bool check_instances();
    bool check_vertices();
    bool check_triangles();
    bool check_mesh_trees();
    bool check_instance_tree();
    bool check_height_grid();
    bool check_environment();
    bool check_lamps();
    bool check_sounds();
    bool is_moving_model(const MovingModel& model) const;
    bool check_simulated();
    bool check_info();

    // The tree under nodes[0]; leaf(id) says what is wrong with a leaf's id, "" for nothing.
    template <class Leaf>
    bool check_tree(std::string_view array, std::span<const BvhNode> nodes, std::uint64_t first_node,
                    std::span<std::uint8_t> depth, Leaf&& leaf);

    const StaticScene& s_;
    const WorldInfo& info_;
    const std::uint64_t leaf_count_;
    std::mutex mutex_;
    std::optional<WorldProblem> problem_;
};

bool Checker::check_sizes() {
    const std::uint64_t triangles = s_.triangle_materials.size();
    constexpr std::uint64_t kIds = std::numeric_limits<std::uint32_t>::max();
    const auto same = [&](std::string_view array, std::uint64_t count, std::uint64_t expected) {
        return count == expected || report(array, count, fmt::format("{} elements; expected {}", count, expected));
    };
    const auto at_most = [&](std::string_view array, std::uint64_t count, std::uint64_t most) {
        return count <= most || report(array, count, fmt::format("{} elements; expected at most {}", count, most));
    };
    return same("attributes", s_.attributes.size(), s_.positions.size()) &&
           same("indices", s_.indices.size(), 3 * triangles) &&
           same("prelit_colors", s_.prelit_colors.size(), triangles) &&
           at_most("positions", s_.positions.size(), kIds) && at_most("triangle_materials", triangles, kIds) &&
           at_most("meshes", s_.meshes.size(), kIds) && at_most("instances", s_.instances.size(), kMaxInstances) &&
           at_most("materials", s_.materials.size(), 1u << 16) && at_most("textures", s_.textures.size(), kIds) &&
           at_most("mesh_nodes", s_.mesh_nodes.size(), kBvhLeafBit) && at_most("mesh_leaves", leaf_count_, kBvhLeafBit);
}

bool Checker::check_textures() {
    std::uint64_t end = 0;
    for (std::size_t i = 0; i < s_.textures.size(); ++i) {
        const Texture& t = s_.textures[i];
        if (!std::has_single_bit(t.width) || !std::has_single_bit(t.height) || t.width > kMaxTextureSide ||
            t.height > kMaxTextureSide)
            return report(
                "textures", i,
                fmt::format("{} x {} texels; expected powers of two up to {}", t.width, t.height, kMaxTextureSide));
        if (const auto levels = std::uint32_t(std::bit_width(std::max(t.width, t.height))); t.level_count != levels)
            return report("textures", i, fmt::format("{} levels; expected {}", t.level_count, levels));
        if (t.wrap_u > Wrap::mirror || t.wrap_v > Wrap::mirror)
            return report("textures", i, fmt::format("wraps {} and {}; expected 0 to 2", int(t.wrap_u), int(t.wrap_v)));
        if (t.first_texel != end)
            return report("textures", i, fmt::format("begins at texel {}; expected {}", t.first_texel, end));
        for (std::uint32_t level = 0; level < t.level_count; ++level)
            end += std::uint64_t(std::max(1u, t.width >> level)) * std::max(1u, t.height >> level);
        if (end > s_.texels.size())
            return report("textures", i, fmt::format("ends at texel {} of {}", end, s_.texels.size()));
    }
    return end == s_.texels.size() ||
           report("texels", end, fmt::format("{} texels; expected {}, the textures' own", s_.texels.size(), end));
}

bool Checker::check_materials() {
    const auto texture_ok = [&](std::uint32_t id) { return id == kNoTexture || id < s_.textures.size(); };
    for (std::size_t i = 0; i < s_.materials.size(); ++i) {
        const Material& m = s_.materials[i];
        for (const std::uint32_t id : {m.base_color_texture, m.emissive_texture, m.metallic_roughness_texture})
            if (!texture_ok(id))
                return report("materials", i,
                              fmt::format("texture {}; expected one of {}, or none", id, s_.textures.size()));
        if (!is_within(Vec3(m.base_color), 0.0, 1e6) || !is_within(m.base_color.w, 0.0, 1e6) ||
            !is_within(m.emissive, 0.0, 1e6) || !is_within(m.alpha_cutoff, 0.0, 1e6) ||
            !is_within(m.metallic, 0.0, 1.0) || !is_within(m.roughness, 0.0, 1.0))
            return report("materials", i,
                          fmt::format("colour ({}, {}, {}, {}), emissive ({}, {}, {}), cutoff {}, metallic {}, "
                                      "roughness {}; expected finite numbers from 0, the last two to 1",
                                      m.base_color.x, m.base_color.y, m.base_color.z, m.base_color.w, m.emissive.x,
                                      m.emissive.y, m.emissive.z, m.alpha_cutoff, m.metallic, m.roughness));
        if ((m.flags & ~kKnownMaterialFlags) != 0)
            return report("materials", i,
                          fmt::format("flags {:#x}; expected no bit over {:#x}", m.flags, kKnownMaterialFlags));
    }
    return true;
}

bool Checker::check_meshes() {
    struct Part {
        std::string_view name;
        std::uint32_t Mesh::*first;
        std::uint32_t Mesh::*count;
        std::uint64_t size;
        std::uint64_t end = 0;
    } parts[] = {{"vertices", &Mesh::first_vertex, &Mesh::vertex_count, s_.positions.size()},
                 {"triangles", &Mesh::first_triangle, &Mesh::triangle_count, s_.triangle_materials.size()},
                 {"nodes", &Mesh::first_node, &Mesh::node_count, s_.mesh_nodes.size()},
                 {"leaves", &Mesh::first_leaf, &Mesh::leaf_count, leaf_count_}};
    for (std::size_t i = 0; i < s_.meshes.size(); ++i) {
        const Mesh& mesh = s_.meshes[i];
        for (Part& part : parts) {
            if (mesh.*part.first != part.end || mesh.*part.count > part.size - part.end)
                return report("meshes", i,
                              fmt::format("{} {} from {}; expected them from {}, of {}", mesh.*part.count, part.name,
                                          mesh.*part.first, part.end, part.size));
            part.end += mesh.*part.count;
        }
        const bool empty = mesh.triangle_count == 0;
        if ((mesh.node_count == 0) != empty || (mesh.leaf_count == 0) != empty)
            return report("meshes", i,
                          fmt::format("{} triangles in {} nodes and {} leaves; expected none or some of all",
                                      mesh.triangle_count, mesh.node_count, mesh.leaf_count));
        const Box3& box = mesh.bounds;
        if (!empty && (box.is_empty() || !is_within(box.low, -kMaxMeshCoordinate, kMaxMeshCoordinate) ||
                       !is_within(box.high, -kMaxMeshCoordinate, kMaxMeshCoordinate)))
            return report("meshes", i, "bounds that are no box; expected low <= high, both finite");
    }
    for (const Part& part : parts)
        if (part.end != part.size)
            return report("meshes", s_.meshes.size(),
                          fmt::format("{} {} belong to no mesh; expected none", part.size - part.end, part.name));
    return true;
}

bool Checker::check_cells() {
    std::uint64_t end = 0;
    for (std::size_t i = 0; i < s_.cells.size(); ++i) {
        const Cell& cell = s_.cells[i];
        if (cell.first_instance != end || cell.instance_count > s_.instances.size() - end)
            return report("cells", i,
                          fmt::format("{} instances from {}; expected them from {}, of {}", cell.instance_count,
                                      cell.first_instance, end, s_.instances.size()));
        end += cell.instance_count;
        if (!is_within(cell.origin, kMaxBound) || (cell.triangle_count > 0 && !is_box(cell.bounds)))
            return report("cells", i, "an origin or bounds that are not finite; expected a point and a box");
    }
    return end == s_.instances.size() ||
           report("cells", s_.cells.size(),
                  fmt::format("{} instances are in no cell; expected none", s_.instances.size() - end));
}

bool Checker::check_instances() {
    const auto has_triangles = [&](const Instance& i) { return s_.meshes[i.mesh].triangle_count > 0; };
    const bool good = each(
        "instances", s_.instances.size(),
        [&](std::size_t i) {
            const Instance& instance = s_.instances[i];
            return instance.mesh < s_.meshes.size() && instance.cell < s_.cells.size() &&
                   i - s_.cells[instance.cell].first_instance < s_.cells[instance.cell].instance_count &&
                   is_within(instance.position, kMaxWorldCoordinate) &&
                   is_rotation_and_scale(instance.world_from_mesh) &&
                   (!has_triangles(instance) || is_box(instance.bounds));
        },
        [&](std::size_t i) {
            const Instance& instance = s_.instances[i];
            return fmt::format(
                "mesh {} of {}, cell {} of {}, at ({}, {}, {}); expected ids in range, the cell that "
                "counts it, a position within {:g} m, a matrix that can be inverted and finite bounds",
                instance.mesh, s_.meshes.size(), instance.cell, s_.cells.size(), instance.position.x,
                instance.position.y, instance.position.z, kMaxWorldCoordinate);
        });
    if (!good) return false;
    return each(
        "cells", s_.cells.size(),
        [&](std::size_t i) {
            std::uint64_t triangles = 0;
            for (const Instance& instance :
                 s_.instances.subspan(s_.cells[i].first_instance, s_.cells[i].instance_count))
                triangles += s_.meshes[instance.mesh].triangle_count;
            return triangles == s_.cells[i].triangle_count;
        },
        [&](std::size_t i) {
            return fmt::format("{} triangles; expected the sum of its instances'", s_.cells[i].triangle_count);
        });
}

bool Checker::check_vertices() {
    return each(
               "positions", s_.positions.size(),
               [&](std::size_t i) {
                   const Vec3& p = s_.positions[i];
                   return std::abs(p.x) <= kMaxMeshCoordinate && std::abs(p.y) <= kMaxMeshCoordinate &&
                          std::abs(p.z) <= kMaxMeshCoordinate;
               },
               [&](std::size_t i) {
                   const Vec3& p = s_.positions[i];
                   return fmt::format("({}, {}, {}); expected metres within {:g}", p.x, p.y, p.z, kMaxMeshCoordinate);
               }) &&
           each(
               "attributes", s_.attributes.size(),
               [&](std::size_t i) { return is_finite(s_.attributes[i].uv.x) && is_finite(s_.attributes[i].uv.y); },
               [&](std::size_t i) {
                   return fmt::format("uv ({}, {}); expected finite numbers", s_.attributes[i].uv.x,
                                      s_.attributes[i].uv.y);
               });
}

bool Checker::check_triangles() {
    const std::vector<MeshSlice> slices = slice_meshes(s_.meshes, &Mesh::triangle_count, kGrain);
    parallel_ranges(slices.size(), 8, [&](std::size_t begin, std::size_t end) {
        for (const MeshSlice& slice : std::span(slices).subspan(begin, end - begin)) {
            const Mesh& mesh = s_.meshes[slice.mesh];
            const std::uint64_t first = std::uint64_t(mesh.first_triangle) + slice.begin;
            const auto indices = s_.indices.subspan(3 * first, 3 * std::size_t(slice.end - slice.begin));
            const auto bad = std::find_if(indices.begin(), indices.end(),
                                          [&](std::uint32_t index) { return index >= mesh.vertex_count; });
            if (bad != indices.end()) {
                report(
                    "indices", 3 * first + std::uint64_t(bad - indices.begin()),
                    fmt::format("vertex {}; expected one of the {} of mesh {}", *bad, mesh.vertex_count, slice.mesh));
                return;
            }
        }
    });
    if (problem_) return false;
    return each(
        "triangle_materials", s_.triangle_materials.size(),
        [&](std::size_t i) { return s_.triangle_materials[i] < s_.materials.size(); },
        [&](std::size_t i) {
            return fmt::format("material {}; expected one of {}", s_.triangle_materials[i], s_.materials.size());
        });
}

template <class Leaf>
bool Checker::check_tree(std::string_view array, std::span<const BvhNode> nodes, std::uint64_t first_node,
                         std::span<std::uint8_t> depth, Leaf&& leaf) {
    constexpr float kInf = std::numeric_limits<float>::infinity();
    if (nodes.empty()) return true;
    depth[0] = 1;
    for (std::size_t n = 0; n < nodes.size(); ++n) {
        const BvhNode& node = nodes[n];
        const auto wrong = [&](int lane, std::string_view what) {
            return report(array, first_node + n, fmt::format("lane {}: child {:#x}: {}", lane, node.child[lane], what));
        };
        if (depth[n] == 0) return report(array, first_node + n, "hangs nowhere; expected one parent");
        for (int lane = 0; lane < kBvhWidth; ++lane) {
            const std::uint32_t child = node.child[lane];
            const Vec3 low(node.low_x[lane], node.low_y[lane], node.low_z[lane]);
            const Vec3 high(node.high_x[lane], node.high_y[lane], node.high_z[lane]);
            if (child == kBvhEmpty) {
                if (low != Vec3(kInf) || high != Vec3(-kInf)) return wrong(lane, "no child; expected an empty box");
                continue;
            }
            if (!is_within(low, -kMaxBound, kMaxBound) || !is_within(high, -kMaxBound, kMaxBound) || low.x > high.x ||
                low.y > high.y || low.z > high.z)
                return wrong(lane, "a box that is none; expected low <= high, both finite");
            if ((child & kBvhLeafBit) != 0) {
                if (const std::string_view what = leaf(child & ~kBvhLeafBit); !what.empty()) return wrong(lane, what);
                continue;
            }
            if (child <= n || child >= nodes.size() || depth[child] != 0)
                return wrong(lane, "expected a node behind its parent, in range and in no other place");
            if (depth[n] == kMaxBvhDepth) return wrong(lane, "deeper than 64 levels; expected at most as many");
            depth[child] = std::uint8_t(depth[n] + 1);
        }
    }
    return true;
}

bool Checker::check_mesh_trees() {
    std::vector<std::uint8_t> depth(s_.mesh_nodes.size());
    std::vector<std::uint8_t> leaf_seen(leaf_count_);
    parallel_ranges(s_.meshes.size(), 64, [&](std::size_t begin, std::size_t end) {
        for (std::size_t m = begin; m < end; ++m) {
            const Mesh& mesh = s_.meshes[m];
            const auto seen = std::span(leaf_seen).subspan(mesh.first_leaf, mesh.leaf_count);
            const bool good = check_tree("mesh_nodes", s_.mesh_nodes.subspan(mesh.first_node, mesh.node_count),
                                         mesh.first_node, std::span(depth).subspan(mesh.first_node, mesh.node_count),
                                         [&](std::uint32_t id) -> std::string_view {
                                             if (id >= seen.size() || seen[id] != 0)
                                                 return "expected a leaf of the mesh that hangs in no other place";
                                             seen[id] = 1;
                                             return {};
                                         });
            if (!good) return;
            const auto unseen = std::find(seen.begin(), seen.end(), std::uint8_t(0));
            if (unseen != seen.end()) {
                report("mesh_nodes", mesh.first_node,
                       fmt::format("leaf {} of mesh {} hangs nowhere; expected one parent", unseen - seen.begin(), m));
                return;
            }
        }
    });
    return !problem_;
}

bool Checker::check_instance_tree() {
    std::vector<std::uint8_t> depth(s_.instance_nodes.size());
    std::vector<std::uint8_t> seen(s_.instances.size());
    return check_tree("instance_nodes", s_.instance_nodes, 0, depth, [&](std::uint32_t id) -> std::string_view {
        if (id >= seen.size() || seen[id] != 0) return "expected an instance that hangs in no other place";
        if (s_.meshes[s_.instances[id].mesh].triangle_count == 0) return "expected an instance that has triangles";
        seen[id] = 1;
        return {};
    });
}

bool Checker::check_height_grid() {
    const HeightGrid& grid = s_.height_grid;
    if (grid.size != 0 && (!std::has_single_bit(grid.size) || grid.size > kMaxGridSize))
        return report(
            "height_grid", 0,
            fmt::format("{} squares a side; expected a power of two up to {}, or 0", grid.size, kMaxGridSize));
    std::uint64_t squares = 0;
    for (std::uint64_t size = grid.size; size > 0; size /= 2) squares += size * size;
    if (grid.heights.size() != squares)
        return report("heights", grid.heights.size(),
                      fmt::format("{} heights; expected {} for {} squares a side and all levels", grid.heights.size(),
                                  squares, grid.size));
    if (!is_within(grid.square_m, 1e-9, kMaxBound) || !is_within(DVec3(grid.low_x, grid.base_y, grid.low_z), kMaxBound))
        return report("height_grid", 0,
                      fmt::format("squares of {} m from ({}, {}), heights over {}; expected finite numbers, squares "
                                  "over 0",
                                  grid.square_m, grid.low_x, grid.low_z, grid.base_y));
    return each(
        "heights", grid.heights.size(),
        [&](std::size_t i) { return grid.heights[i] < std::numeric_limits<float>::infinity(); },
        [&](std::size_t i) { return fmt::format("{}; expected a finite height, or -inf", grid.heights[i]); });
}

bool Checker::check_lamps() {
    for (std::size_t i = 0; i < s_.lamps.size(); ++i) {
        const Lamp& lamp = s_.lamps[i];
        if (!is_within(lamp.position, kMaxWorldCoordinate) || !is_within(lamp.color, 0.0, 1.0) ||
            !is_within(lamp.lumens, 0.0, 1e9) || !is_within(lamp.radius_m, 1e-3, 1000.0) ||
            !is_within(lamp.on_below_sun_deg, -90.0, 90.0))
            return report("lamps", i, "a place, colour, strength, radius or angle out of range");
    }
    return true;
}

bool Checker::check_environment() {
    const Environment& e = s_.environment;
    const double length2 =
        double(e.to_sun.x) * e.to_sun.x + double(e.to_sun.y) * e.to_sun.y + double(e.to_sun.z) * e.to_sun.z;
    if (!is_within(length2, 0.98, 1.02))
        return report("environment", 0, fmt::format("to_sun of length {}; expected 1", std::sqrt(length2)));
    for (const Vec3& color : {e.sun_radiance, e.sky_zenith, e.sky_horizon, e.ground_bounce})
        if (!is_within(color, 0.0, 1e9))
            return report(
                "environment", 0,
                fmt::format("a colour ({}, {}, {}); expected finite numbers from 0", color.x, color.y, color.z));
    if (!is_within(e.fog_density_per_m, 0.0, 1e9))
        return report("environment", 0, fmt::format("fog {}; expected a finite number from 0", e.fog_density_per_m));
    if (const float t = e.atmosphere.turbidity; t != 0.0f && !is_within(t, 1.0, 10.0))
        return report("environment", 0, fmt::format("turbidity {}; expected 0, or [1, 10]", t));
    if (!is_within(e.atmosphere.brightness, 0.0, 1e9))
        return report("environment", 0,
                      fmt::format("brightness {}; expected a finite number from 0", e.atmosphere.brightness));
    const Weather& w = e.weather;
    if (!is_within(w.rain, 0.0, 1.0) || !is_within(w.snow, 0.0, 1.0) || !is_within(w.wind_m_s.x, -1e3, 1e3) ||
        !is_within(w.wind_m_s.y, -1e3, 1e3))
        return report("environment", 0, "weather; expected rain and snow in [0, 1] and a wind below 1 km/s");
    if (e.panorama_width > kMaxPanoramaSide || e.panorama_height > kMaxPanoramaSide ||
        (e.panorama_width == 0) != (e.panorama_height == 0) ||
        e.panorama.size() != std::uint64_t(4) * e.panorama_width * e.panorama_height)
        return report("sky_panorama", e.panorama.size(),
                      fmt::format("{} numbers for {} x {} texels; expected four a texel, at most {} texels a side",
                                  e.panorama.size(), e.panorama_width, e.panorama_height, kMaxPanoramaSide));
    return each(
        "sky_panorama", e.panorama.size(), [&](std::size_t i) { return (e.panorama[i] & 0x7C00) != 0x7C00; },
        [&](std::size_t i) { return fmt::format("half float {:#06x}; expected a finite one", e.panorama[i]); });
}

bool Checker::check_sounds() {
    const SoundSet& sounds = info_.sounds;
    std::vector<std::string_view> names;
    for (std::size_t i = 0; i < sounds.clips.size(); ++i) {
        const SoundClip& clip = sounds.clips[i];
        if (clip.name.empty() || clip.name.size() > kMaxNameBytes || clip.samples.empty() || clip.rate_hz < 1000 ||
            clip.rate_hz > 192000)
            return report("sound_clips", i,
                          fmt::format("a name of {} bytes, {} samples at {} Hz; expected a name of 1 to {} bytes, at "
                                      "least one sample, and 1,000 to 192,000 Hz",
                                      clip.name.size(), clip.samples.size(), clip.rate_hz, kMaxNameBytes));
        names.push_back(clip.name);
    }
    std::sort(names.begin(), names.end());
    if (const auto twice = std::adjacent_find(names.begin(), names.end()); twice != names.end())
        return report("sound_clips", 0, fmt::format("two are called \"{}\"; expected names of their own", *twice));
    for (std::size_t i = 0; i < sounds.sources.size(); ++i) {
        const SoundSource& source = sounds.sources[i];
        if (source.clip >= sounds.clips.size() || !is_within(source.position, kMaxWorldCoordinate) ||
            !is_within(source.reference_m, 0.1, 1e4) || !is_within(source.gain, 0.0, 1.0))
            return report("sound_sources", i, "a clip, place, reference distance or gain out of range");
    }
    return true;
}

bool Checker::is_moving_model(const MovingModel& model) const {
    const std::uint64_t end = std::uint64_t(model.first_instance) + model.instance_count;
    const std::uint64_t animated_end = std::uint64_t(model.first_animated) + model.animated_count;
    return end <= info_.dynamic_instances.size() && animated_end <= info_.animation.instances.size() &&
           is_within(model.position, kMaxWorldCoordinate) && is_within(model.yaw, -1e6, 1e6);
}

bool Checker::check_simulated() {
    for (std::size_t i = 0; i < info_.flocks.size(); ++i) {
        const Flock& flock = info_.flocks[i];
        if (!is_moving_model(flock.model) || flock.birds == 0 || flock.birds > kMostBirds ||
            !is_within(flock.radius_m, 5.0, 1000.0))
            return report("flocks", i,
                          fmt::format("{} birds within {} m; expected 1 to {} within 5 to 1000 m, a finite place and "
                                      "some of {} dynamic instances",
                                      flock.birds, flock.radius_m, kMostBirds, info_.dynamic_instances.size()));
    }
    for (std::size_t i = 0; i < info_.loose_bodies.size(); ++i) {
        const LooseBody& body = info_.loose_bodies[i];
        if (!is_moving_model(body.model) || body.model.instance_count == 0 || body.model.animated_count != 0 ||
            !is_within(body.mass_kg, 1e-3, 1e6))
            return report("loose_bodies", i,
                          fmt::format("{} kg of {} instances; expected 0.001 to 1000000 kg, a finite place and some of "
                                      "{} dynamic instances, none animated",
                                      body.mass_kg, body.model.instance_count, info_.dynamic_instances.size()));
    }
    return true;
}

bool Checker::check_info() {
    const bool any = std::any_of(s_.cells.begin(), s_.cells.end(), [](const Cell& c) { return c.triangle_count > 0; });
    if (!is_within(s_.origin, kMaxBound) || (any && !is_box(s_.bounds)))
        return report("world", 0, "an origin or bounds that are not finite; expected a point and a box");
    if (info_.name.size() > kMaxNameBytes)
        return report("world", 0,
                      fmt::format("a name of {} bytes; expected at most {}", info_.name.size(), kMaxNameBytes));
    if (!is_within(info_.spawn_position, kMaxWorldCoordinate) || !is_within(info_.spawn_yaw, -1e6, 1e6))
        return report("world", 0, "a spawn point that is not finite; expected a position and radians");
    for (std::size_t i = 0; i < info_.dynamic_instances.size(); ++i) {
        const DynamicInstance& instance = info_.dynamic_instances[i];
        if (instance.mesh >= s_.meshes.size() || !is_within(instance.position, kMaxWorldCoordinate) ||
            !is_rotation_and_scale(instance.world_from_mesh))
            return report(
                "dynamic_instances", i,
                fmt::format("mesh {} at ({}, {}, {}); expected one of {} meshes, a position within {:g} m and "
                            "a matrix that can be inverted",
                            instance.mesh, instance.position.x, instance.position.y, instance.position.z,
                            s_.meshes.size(), kMaxWorldCoordinate));
    }
    if (const auto problem = find_animation_problem(info_.animation, s_.meshes))
        return report(problem->array, problem->element, problem->what);
    std::vector<std::string_view> names;
    for (std::size_t i = 0; i < info_.places.size(); ++i) {
        const NamedPlace& place = info_.places[i];
        if (place.name.empty() || place.name.size() > kMaxNameBytes || !is_moving_model(place))
            return report("places", i,
                          fmt::format("a name of {} bytes and {} instances from {} on; expected a name of 1 to {} "
                                      "bytes, a finite place, and some of {} dynamic instances",
                                      place.name.size(), place.instance_count, place.first_instance, kMaxNameBytes,
                                      info_.dynamic_instances.size()));
        names.push_back(place.name);
    }
    std::sort(names.begin(), names.end());
    if (const auto twice = std::adjacent_find(names.begin(), names.end()); twice != names.end())
        return report("places", 0, fmt::format("two places are called \"{}\"; expected names of their own", *twice));
    names.clear();
    for (std::size_t i = 0; i < info_.walks.size(); ++i) {
        const Walk& walk = info_.walks[i];
        if (walk.name.empty() || walk.name.size() > kMaxNameBytes)
            return report("walks", i,
                          fmt::format("a name of {} bytes; expected 1 to {}", walk.name.size(), kMaxNameBytes));
        names.push_back(walk.name);
        if (std::string problem = find_walk_problem(walk); !problem.empty())
            return report("walks", i, std::move(problem));
    }
    std::sort(names.begin(), names.end());
    if (const auto twice = std::adjacent_find(names.begin(), names.end()); twice != names.end())
        return report("walks", 0, fmt::format("two walks are called \"{}\"; expected names of their own", *twice));
    return true;
}

}  // namespace

std::optional<WorldProblem> find_world_problem(const StaticScene& scene, const WorldInfo& info,
                                               std::uint64_t leaf_count) {
    return Checker(scene, info, leaf_count).run();
}

}  // namespace ff::scene
