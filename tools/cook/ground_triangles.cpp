#include "tools/cook/ground_triangles.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <numeric>

#include "engine/core/jobs.h"

namespace ff::cook {
namespace {

constexpr std::uint32_t kPieceTriangles = 512;
constexpr double kFloorNormalY = 0.7;        // 45 degrees: steeper ground is climbed, not walked
constexpr double kLevelNormalY = 0.999;      // 2.5 degrees
constexpr double kMaskedFloorArea_m2 = 1.0;  // a masked texture on a large flat face is ground with holes, not leaves
constexpr std::uint32_t kAlwaysTriangles = 64;  // meshes up to here are always given whole

bool is_finite(const DVec3& v) {
    return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

}  // namespace

StaticTriangles::StaticTriangles(const WorldSource& world) : world_(world), chosen_(world.meshes.size()) {
    choose_large_triangles();
    cut_into_pieces();
    for (const TrianglePiece& piece : pieces_) bounds_.add(piece.bounds);
}

bool StaticTriangles::make(std::uint32_t placement_id, std::uint32_t triangle, WorldTriangle& out) const {
    const Placement& placement = world_.placements[placement_id];
    const scene::MeshSource& mesh = world_.meshes[placement.mesh].geometry;
    for (std::size_t c = 0; c < 3; ++c) {
        const Vec3 p = mesh.positions[mesh.indices[std::size_t(triangle) * 3 + c]];
        out.corners[c] = placement.position + DVec3(placement.world_from_mesh * p);
        if (!is_finite(out.corners[c])) return false;
    }
    DVec3 normal = glm::cross(out.corners[1] - out.corners[0], out.corners[2] - out.corners[0]);
    if (glm::determinant(placement.world_from_mesh) < 0.0f) normal = -normal;
    const double length = glm::length(normal);
    const std::uint32_t flags = world_.materials[mesh.triangle_materials[triangle]].flags;
    const double up = (flags & scene::kMaterialDoubleSided) != 0 ? std::abs(normal.y) : normal.y;
    out.is_level = std::abs(normal.y) >= kLevelNormalY * length;
    const bool is_flat = up > kFloorNormalY * length;
    const bool is_masked = (flags & (scene::kMaterialAlphaMask | scene::kMaterialBlend)) != 0;
    if (is_masked && !((flags & scene::kMaterialBlend) == 0 && is_flat && length * 0.5 > kMaskedFloorArea_m2))
        out.kind = SurfaceKind::foliage;
    else
        out.kind = is_flat ? SurfaceKind::floor : SurfaceKind::wall;
    return true;
}

void StaticTriangles::choose_large_triangles() {
    std::vector<std::uint64_t> uses(world_.meshes.size(), 0);
    for (const Placement& placement : world_.placements)
        if (placement.kind != PlacementKind::dynamic) ++uses[placement.mesh];
    std::uint64_t drawn = 0, repeated = 0;
    const auto size_of = [&](std::size_t m) { return world_.meshes[m].geometry.triangle_materials.size(); };
    const auto is_heavy = [&](std::size_t m) { return uses[m] > 8 && size_of(m) > kAlwaysTriangles; };
    for (std::size_t m = 0; m < uses.size(); ++m)
        (is_heavy(m) ? repeated : drawn) += uses[m] * world_.meshes[m].geometry.triangle_materials.size();
    if (repeated == 0 || drawn + repeated <= kMostDrawnTriangles) return;
    const double share = static_cast<double>(kMostDrawnTriangles) / static_cast<double>(repeated);
    parallel_for(world_.meshes.size(), [&](std::size_t m) {
        if (!is_heavy(m)) return;
        const scene::MeshSource& mesh = world_.meshes[m].geometry;
        const auto area = [&](std::uint32_t t) {
            const Vec3 &a = mesh.positions[mesh.indices[3 * std::size_t(t)]],
                       &b = mesh.positions[mesh.indices[3 * std::size_t(t) + 1]],
                       &c = mesh.positions[mesh.indices[3 * std::size_t(t) + 2]];
            const float length = glm::length(glm::cross(b - a, c - a));
            return std::isfinite(length) ? length : 0.0f;
        };
        std::vector<std::pair<float, std::uint32_t>> order(size_of(m));
        for (std::uint32_t t = 0; t < order.size(); ++t) order[t] = {-area(t), t};
        const auto kept =
            std::min(order.size(), std::max<std::size_t>(kAlwaysTriangles, std::size_t(double(order.size()) * share)));
        std::partial_sort(order.begin(), order.begin() + std::ptrdiff_t(kept), order.end());
        chosen_[m].resize(kept);
        for (std::size_t i = 0; i < kept; ++i) chosen_[m][i] = order[i].second;
        std::sort(chosen_[m].begin(), chosen_[m].end());
    });
}

void StaticTriangles::cut_into_pieces() {
    // Boxes of pieces in mesh space once a mesh; their turned boxes once a placement.
    std::vector<std::vector<Box3>> boxes(world_.meshes.size());
    parallel_for(world_.meshes.size(), [&](std::size_t m) {
        const scene::MeshSource& mesh = world_.meshes[m].geometry;
        const std::size_t count = chosen_[m].empty() ? mesh.triangle_materials.size() : chosen_[m].size();
        boxes[m].resize((count + kPieceTriangles - 1) / kPieceTriangles);
        for (std::size_t i = 0; i < count; ++i) {
            const std::size_t t = chosen_[m].empty() ? i : chosen_[m][i];
            for (std::size_t c = 0; c < 3; ++c) {
                const Vec3 p = mesh.positions[mesh.indices[t * 3 + c]];
                if (is_finite(DVec3(p))) boxes[m][i / kPieceTriangles].add(p);
            }
        }
    });
    for (std::uint32_t p = 0; p < world_.placements.size(); ++p) {
        const Placement& placement = world_.placements[p];
        if (placement.kind == PlacementKind::dynamic || !is_finite(placement.position)) continue;
        const std::size_t count = chosen_[placement.mesh].empty()
                                      ? world_.meshes[placement.mesh].geometry.triangle_materials.size()
                                      : chosen_[placement.mesh].size();
        for (std::size_t i = 0; i < boxes[placement.mesh].size(); ++i) {
            const Box3& box = boxes[placement.mesh][i];
            if (box.is_empty()) continue;
            TrianglePiece piece{.placement = p,
                                .first = static_cast<std::uint32_t>(i * kPieceTriangles),
                                .count = static_cast<std::uint32_t>(
                                    std::min<std::size_t>(kPieceTriangles, count - i * kPieceTriangles))};
            for (int corner = 0; corner < 8; ++corner) {
                const Vec3 q((corner & 1) != 0 ? box.high.x : box.low.x, (corner & 2) != 0 ? box.high.y : box.low.y,
                             (corner & 4) != 0 ? box.high.z : box.low.z);
                piece.bounds.add(placement.position + DVec3(placement.world_from_mesh * q));
            }
            if (is_finite(piece.bounds.low) && is_finite(piece.bounds.high)) pieces_.push_back(piece);
        }
    }
}

}  // namespace ff::cook
