#include "tools/cook/coincident_surfaces.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <tuple>
#include <unordered_map>
#include <utility>

#include "engine/core/hash.h"
#include "tools/cook/coincident_layers.h"
#include "tools/cook/coincident_pairs.h"
#include "tools/cook/placed_triangles.h"

namespace ff::cook {
namespace {

using scene::MeshSource;
using scene::VertexAttributes;

std::vector<PlacementSlot> choose_slots(const WorldSource& world, const std::vector<bool>& stays_whole) {
    std::uint64_t instanced = 0;
    for (std::size_t i = 0; i < world.placements.size(); ++i)
        if (stays_whole[i] && !world.placements[i].stands_clear)
            instanced += world.meshes[world.placements[i].mesh].geometry.triangle_materials.size();
    std::vector<PlacementSlot> slots;
    std::vector<bool> seen(world.meshes.size(), false);
    for (std::size_t i = 0; i < world.placements.size(); ++i) {
        const Placement& placement = world.placements[i];
        PlacementSlot slot{.placement = static_cast<std::uint32_t>(i), .stays_whole = stays_whole[i]};
        if (slot.stays_whole) {
            slot.with_itself = !seen[placement.mesh];  // one stands for all
            seen[placement.mesh] = true;
            slot.with_others = !placement.stands_clear && placement.kind != PlacementKind::dynamic &&
                               instanced <= kMostInstancedTriangles;
        } else {
            slot.with_itself = slot.with_others = !placement.stands_clear;
        }
        if (slot.with_itself || slot.with_others) slots.push_back(slot);
    }
    return slots;
}

std::uint32_t flags_of(const WorldSource& world, const PlacedTriangles& triangles, std::uint32_t id) {
    return world.materials[triangles.material(id)].flags;
}

/// Whether two triangles with the same corners look the same from both sides: the shading turns normals to the viewer.
bool look_alike(const PlacedTriangles& triangles, std::uint32_t a, std::uint32_t b) {
    if (triangles.material(a) != triangles.material(b)) return false;
    const auto at = triangles.corners(a), there = triangles.corners(b);
    const auto attributes_of = [&](std::uint32_t id, std::size_t corner) {
        const MeshSource& mesh = triangles.mesh(id);
        return mesh.attributes[mesh.indices[3 * std::size_t{triangles.triangle(id)} + corner]];
    };
    const auto world_normal = [&](std::uint32_t id, const VertexAttributes& attributes) {
        const DMat3 normal_matrix = glm::transpose(glm::inverse(DMat3(triangles.placement(id).world_from_mesh)));
        return glm::normalize(normal_matrix * DVec3(scene::decode_normal(attributes.normal_oct)));
    };
    for (std::size_t c = 0; c < 3; ++c) {
        std::size_t nearest = 0;
        for (std::size_t k = 1; k < 3; ++k)
            if (glm::distance(at[c], there[k]) < glm::distance(at[c], there[nearest])) nearest = k;
        const VertexAttributes x = attributes_of(a, c), y = attributes_of(b, nearest);
        constexpr float kSameUv = 1e-4f;       // a tenth of a texel of the largest texture in use
        constexpr double kSameNormal = 0.999;  // cosine: a difference of light below one of 255
        if (x.color != y.color || std::abs(x.uv.x - y.uv.x) > kSameUv || std::abs(x.uv.y - y.uv.y) > kSameUv ||
            std::abs(glm::dot(world_normal(a, x), world_normal(b, y))) < kSameNormal)
            return false;
    }
    return true;
}

/// Marks triangles to drop; returns the pairs that are left to be moved apart.
std::vector<CoincidentPair> drop_covered(const WorldSource& world, const PlacedTriangles& triangles,
                                         const std::vector<CoincidentPair>& pairs, std::vector<bool>& dropped) {
    constexpr std::uint32_t kSeeThrough = scene::kMaterialAlphaMask | scene::kMaterialBlend;
    std::vector<CoincidentPair> left;
    for (const CoincidentPair& pair : pairs) {
        if (dropped[pair.first] || dropped[pair.second]) continue;
        if (pair.same_corners) {
            const std::uint32_t flags =
                flags_of(world, triangles, pair.first) | flags_of(world, triangles, pair.second);
            const bool alike = look_alike(triangles, pair.first, pair.second) &&
                               !(pair.same_facing && (flags & scene::kMaterialBlend) != 0);  // two layers blend twice
            const bool covered = pair.same_facing && (flags & kSeeThrough) == 0;
            const std::uint32_t a = triangles.slot(pair.first), b = triangles.slot(pair.second);
            const bool own = a == b || (!triangles.slots()[a].stays_whole && !triangles.slots()[b].stays_whole);
            if (own && (alike || covered)) {
                dropped[pair.first] = true;
                continue;
            }
            if (alike) continue;  // whichever is hit, the picture is the same
        }
        left.push_back(pair);
    }
    std::erase_if(left, [&](const CoincidentPair& pair) { return dropped[pair.first] || dropped[pair.second]; });
    return left;
}

struct PositionHash {
    std::size_t operator()(const std::array<std::uint32_t, 3>& bits) const {
        return hash_bytes(std::as_bytes(std::span(bits)));
    }
};
/// Patches that touch a point of a mesh, ascending.
using Touches = std::unordered_map<std::array<std::uint32_t, 3>, std::vector<std::uint32_t>, PositionHash>;

std::array<std::uint32_t, 3> bits_of(Vec3 p) {
    p += 0.0f;  // -0 and +0 are one
    return {std::bit_cast<std::uint32_t>(p.x), std::bit_cast<std::uint32_t>(p.y), std::bit_cast<std::uint32_t>(p.z)};
}

/// How far a corner moves: with its own patch, and with all others there that do not lie in a plane like it.
DVec3 corner_offset(const CoincidentLayers& layers, const std::vector<std::uint32_t>& touching, std::uint32_t own) {
    std::array<DVec3, 4> normals;
    std::size_t count = 0;
    DVec3 offset(0.0);
    const auto follow = [&](const CoincidentPatch& patch) {
        for (std::size_t i = 0; i < count; ++i)
            if (std::abs(glm::dot(normals[i], patch.normal)) > 0.9) return;
        if (count == normals.size()) return;
        normals[count++] = patch.normal;
        offset += patch.offset;
    };
    if (own != kNoPatch) follow(layers.patches[own]);
    for (const std::uint32_t patch : touching)
        if (patch != own) follow(layers.patches[patch]);
    return offset;
}

/// The slot's mesh without what is dropped, its patches and what hangs on them moved.
MeshSource edited_mesh(const PlacedTriangles& triangles, std::uint32_t slot, const CoincidentLayers& layers,
                       const std::vector<bool>& dropped, CoincidentReport& report) {
    const std::uint32_t first = triangles.first()[slot], end = triangles.first()[slot + 1];
    const MeshSource& mesh = triangles.mesh(first);
    const DMat3 mesh_from_world = glm::inverse(DMat3(triangles.placement(first).world_from_mesh));
    Touches touches;
    for (std::uint32_t id = first; id < end; ++id) {
        const std::uint32_t patch = layers.patch_of[id];
        if (patch == kNoPatch) continue;
        if (layers.patches[patch].offset != DVec3(0.0)) ++report.separated_triangles;
        for (std::size_t c = 0; c < 3; ++c) {
            std::vector<std::uint32_t>& at = touches[bits_of(mesh.positions[mesh.indices[3 * (id - first) + c]])];
            if (const auto place = std::lower_bound(at.begin(), at.end(), patch); place == at.end() || *place != patch)
                at.insert(place, patch);
        }
    }
    MeshSource edited{
        .positions = mesh.positions, .attributes = mesh.attributes, .indices = {}, .triangle_materials = {}};
    edited.indices.reserve(mesh.indices.size());
    edited.triangle_materials.reserve(mesh.triangle_materials.size());
    for (std::uint32_t id = first; id < end; ++id) {
        if (dropped[id]) {
            ++report.dropped_triangles;
            continue;
        }
        edited.triangle_materials.push_back(mesh.triangle_materials[id - first]);
        for (std::size_t c = 0; c < 3; ++c) {
            const std::uint32_t index = mesh.indices[3 * std::size_t{id - first} + c];
            const auto found = touches.find(bits_of(mesh.positions[index]));
            const DVec3 offset =
                found == touches.end() ? DVec3(0.0) : corner_offset(layers, found->second, layers.patch_of[id]);
            if (offset == DVec3(0.0)) {
                edited.indices.push_back(index);
                continue;
            }
            edited.indices.push_back(static_cast<std::uint32_t>(edited.positions.size()));
            edited.positions.push_back(Vec3(DVec3(mesh.positions[index]) + mesh_from_world * offset));
            edited.attributes.push_back(mesh.attributes[index]);
        }
    }
    return edited;
}

}  // namespace

std::uint64_t drop_repeated_placements(WorldSource& world) {
    const auto key = [&](std::uint32_t i) {
        const Placement& p = world.placements[i];
        const Mat3& m = p.world_from_mesh;
        return std::tie(p.mesh, p.position.x, p.position.y, p.position.z, m[0].x, m[0].y, m[0].z, m[1].x, m[1].y,
                        m[1].z, m[2].x, m[2].y, m[2].z);
    };
    std::vector<std::uint32_t> order;
    for (std::uint32_t i = 0; i < world.placements.size(); ++i)
        if (world.placements[i].kind != PlacementKind::dynamic) order.push_back(i);
    std::sort(order.begin(), order.end(),
              [&](std::uint32_t a, std::uint32_t b) { return std::tuple(key(a), a) < std::tuple(key(b), b); });
    std::vector<bool> repeated(world.placements.size(), false);
    std::uint64_t count = 0;
    for (std::size_t i = 1; i < order.size(); ++i) {
        if (key(order[i - 1]) != key(order[i])) continue;
        const std::vector<std::uint16_t>& used =
            world.meshes[world.placements[order[i]].mesh].geometry.triangle_materials;
        // Two layers of glass are darker than one.
        if (std::any_of(used.begin(), used.end(), [&](std::uint16_t material) {
                return (world.materials[material].flags & scene::kMaterialBlend) != 0;
            }))
            continue;
        repeated[order[i]] = true;
        ++count;
    }
    std::size_t at = 0;
    std::erase_if(world.placements, [&](const Placement&) { return repeated[at++]; });
    return count;
}

CoincidentReport resolve_coincident_surfaces(WorldSource& world, const std::vector<bool>& stays_whole) {
    CoincidentReport report;
    const PlacedTriangles triangles(world, choose_slots(world, stays_whole));
    const CoincidentPairs found = find_coincident_pairs(triangles);
    report.complete = found.complete;
    std::vector<bool> dropped(triangles.size(), false);
    const std::vector<CoincidentPair> pairs = drop_covered(world, triangles, found.pairs, dropped);
    const CoincidentLayers layers = order_coincident(triangles, world.materials, pairs);

    std::vector<bool> edited(triangles.slots().size(), false);
    for (std::uint32_t id = 0; id < triangles.size(); ++id)
        if (dropped[id] || layers.patch_of[id] != kNoPatch) edited[triangles.slot(id)] = true;
    std::vector<std::pair<std::uint32_t, MeshSource>> meshes;  // of slots; written when all have been read
    for (std::uint32_t slot = 0; slot < edited.size(); ++slot)
        if (edited[slot]) meshes.emplace_back(slot, edited_mesh(triangles, slot, layers, dropped, report));

    std::vector<std::uint32_t> uses(world.meshes.size(), 0);
    for (const Placement& placement : world.placements) ++uses[placement.mesh];
    for (auto& [index, mesh] : meshes) {
        const PlacementSlot& slot = triangles.slots()[index];
        Placement& placement = world.placements[slot.placement];
        if (slot.stays_whole || uses[placement.mesh] == 1) {
            world.meshes[placement.mesh].geometry = std::move(mesh);
        } else {
            --uses[placement.mesh];
            world.meshes.push_back({.name = world.meshes[placement.mesh].name, .geometry = std::move(mesh)});
            placement.mesh = static_cast<std::uint32_t>(world.meshes.size() - 1);
            uses.push_back(1);
        }
    }
    for (const CoincidentPatch& patch : layers.patches) {
        if (!patch.whole_instance || patch.offset == DVec3(0.0)) continue;
        world.placements[triangles.slots()[patch.slot].placement].position += patch.offset;
        ++report.moved_placements;
    }
    return report;
}

}  // namespace ff::cook
