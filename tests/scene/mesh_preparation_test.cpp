#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <limits>
#include <map>
#include <vector>

#include "engine/core/jobs.h"
#include "engine/scene/scene_data.h"
#include "tests/support/worlds.h"

namespace ff::scene {
namespace {

using Corners = std::array<float, 9>;

Corners corners_of(const MeshSource& mesh, std::size_t triangle) {
    Corners out;
    for (std::size_t k = 0; k < 3; ++k) {
        const Vec3& p = mesh.positions[mesh.indices[3 * triangle + k]];
        out[3 * k] = p.x, out[3 * k + 1] = p.y, out[3 * k + 2] = p.z;
    }
    return out;
}

MeshSource random_mesh(std::uint32_t seed, int triangles) {
    test::Random random(seed);
    MeshSource mesh;
    for (int i = 0; i < triangles; ++i) {
        const Vec3 at = random.in_box(Vec3(-50.0f), Vec3(50.0f));
        if (random.below(3) == 0)
            test::append_box(mesh, at, at + random.in_box(Vec3(0.1f), Vec3(3.0f)), 1 + int(random.below(3)), 0);
        else
            test::append_triangle(mesh, at, at + random.in_box(Vec3(-2.0f), Vec3(2.0f)),
                                  at + random.in_box(Vec3(-2.0f), Vec3(2.0f)), std::uint16_t(random.below(2)));
    }
    return mesh;
}

const std::vector<Material>& materials() {
    static const std::vector<Material> two = {test::plain_material(), {.flags = kMaterialAlphaMask}};
    return two;
}

// Visits every leaf below a node and checks that its box encloses it; returns the leaves in order.
void check_node(const PreparedMesh& mesh, std::uint32_t node_id, const Box3& outer,
                std::vector<std::uint32_t>& leaves) {
    const BvhNode& node = mesh.nodes[node_id];
    for (int lane = 0; lane < kBvhWidth; ++lane) {
        const Box3 box{Vec3(node.low_x[lane], node.low_y[lane], node.low_z[lane]),
                       Vec3(node.high_x[lane], node.high_y[lane], node.high_z[lane])};
        if (node.child[lane] == kBvhEmpty) {
            EXPECT_EQ(box.low.x, std::numeric_limits<float>::infinity());
            EXPECT_EQ(box.high.z, -std::numeric_limits<float>::infinity());
            continue;
        }
        for (int axis = 0; axis < 3; ++axis) {
            EXPECT_LE(outer.low[axis], box.low[axis]);
            EXPECT_GE(outer.high[axis], box.high[axis]);
        }
        if (!(node.child[lane] & kBvhLeafBit)) {
            ASSERT_GT(node.child[lane], node_id);
            check_node(mesh, node.child[lane], box, leaves);
            continue;
        }
        const BvhLeaf& leaf = mesh.leaves[node.child[lane] & ~kBvhLeafBit];
        leaves.push_back(node.child[lane] & ~kBvhLeafBit);
        for (int v = 0; v < leaf.vertex_count; ++v) {
            EXPECT_LE(box.low.x, leaf.x[v]);
            EXPECT_GE(box.high.x, leaf.x[v]);
            EXPECT_LE(box.low.y, leaf.y[v]);
            EXPECT_GE(box.high.y, leaf.y[v]);
            EXPECT_LE(box.low.z, leaf.z[v]);
            EXPECT_GE(box.high.z, leaf.z[v]);
        }
    }
}

TEST(PrepareMesh, KeepsEveryTriangleWithItsMaterialAndAttributes) {
    for (std::uint32_t seed = 0; seed < 30; ++seed) {
        const MeshSource source = random_mesh(seed, 1 + int(seed) * 10);
        const PreparedMesh mesh = prepare_mesh(source, materials());
        ASSERT_EQ(mesh.geometry.indices.size(), source.indices.size());
        EXPECT_LE(mesh.geometry.positions.size(), source.positions.size());
        std::multimap<Corners, std::uint16_t> before, after;
        for (std::size_t t = 0; t < source.triangle_materials.size(); ++t) {
            before.emplace(corners_of(source, t), source.triangle_materials[t]);
            after.emplace(corners_of(mesh.geometry, t), mesh.geometry.triangle_materials[t]);
        }
        EXPECT_EQ(before, after) << "seed " << seed;
    }
}

TEST(PrepareMesh, LeavesHoldConsecutiveTrianglesInBoxesThatEncloseThem) {
    for (std::uint32_t seed = 0; seed < 30; ++seed) {
        const PreparedMesh mesh = prepare_mesh(random_mesh(seed, 1 + int(seed * seed)), materials());
        std::vector<std::uint32_t> order;
        check_node(mesh, 0, mesh.bounds, order);
        ASSERT_EQ(order.size(), mesh.leaves.size());
        std::uint32_t next = 0;
        for (std::size_t i = 0; i < order.size(); ++i) {
            ASSERT_EQ(order[i], i);  // depth first
            const BvhLeaf& leaf = mesh.leaves[i];
            ASSERT_EQ(leaf.first_triangle, next);
            next += leaf.triangle_count;
            ASSERT_GE(leaf.triangle_count, 1);
            ASSERT_LE(leaf.triangle_count, BvhLeaf::kMaxTriangles);
            ASSERT_LE(leaf.vertex_count, BvhLeaf::kMaxVertices);
            for (int t = 0; t < leaf.triangle_count; ++t) {
                const Corners corners = corners_of(mesh.geometry, leaf.first_triangle + std::size_t(t));
                for (std::size_t k = 0; k < 3; ++k) {
                    const int v = leaf.corner[k][t];
                    ASSERT_LT(v, leaf.vertex_count);
                    EXPECT_EQ(leaf.x[v], corners[3 * k]);
                    EXPECT_EQ(leaf.y[v], corners[3 * k + 1]);
                    EXPECT_EQ(leaf.z[v], corners[3 * k + 2]);
                }
                const bool see_through = mesh.geometry.triangle_materials[leaf.first_triangle + std::size_t(t)] == 1;
                EXPECT_EQ((leaf.alpha_triangles >> t) & 1, see_through ? 1 : 0);
            }
        }
        EXPECT_EQ(next, mesh.geometry.triangle_materials.size());
    }
}

TEST(PrepareMesh, GivesTheSameBytesForOneAndTwoWorkers) {
    const MeshSource source = random_mesh(7, 20000);
    PreparedMesh meshes[2];
    for (int i = 0; i < 2; ++i) {
        const WorkerLimit limit(i + 1);
        meshes[i] = prepare_mesh(source, materials());
    }
    ASSERT_EQ(meshes[0].nodes.size(), meshes[1].nodes.size());
    ASSERT_EQ(meshes[0].leaves.size(), meshes[1].leaves.size());
    EXPECT_EQ(std::memcmp(meshes[0].nodes.data(), meshes[1].nodes.data(), meshes[0].nodes.size() * sizeof(BvhNode)), 0);
    EXPECT_EQ(std::memcmp(meshes[0].leaves.data(), meshes[1].leaves.data(), meshes[0].leaves.size() * sizeof(BvhLeaf)),
              0);
    EXPECT_EQ(meshes[0].geometry.indices, meshes[1].geometry.indices);
}

TEST(PrepareMesh, TakesEmptyDegenerateAndIdenticalTriangles) {
    EXPECT_TRUE(prepare_mesh({}, materials()).nodes.empty());
    MeshSource same, points;
    for (int i = 0; i < 1000; ++i) {
        test::append_triangle(same, Vec3(0.0f), Vec3(1.0f, 0.0f, 0.0f), Vec3(0.0f, 1.0f, 0.0f), 0);
        test::append_triangle(points, Vec3(2.0f), Vec3(2.0f), Vec3(2.0f), 0);
    }
    for (const MeshSource& source : {same, points}) {
        const PreparedMesh mesh = prepare_mesh(source, materials());
        std::vector<std::uint32_t> order;
        check_node(mesh, 0, mesh.bounds, order);
        EXPECT_EQ(order.size(), mesh.leaves.size());
        EXPECT_EQ(mesh.geometry.positions.size(),
                  source.positions.data() == same.positions.data() ? 3u : mesh.geometry.positions.size());
    }
}

TEST(PrepareMesh, SurvivesPositionsThatSpanAllMagnitudes) {
    MeshSource mesh;
    for (int i = -120; i < 120; ++i) {
        const float size = std::ldexp(1.0f, i);
        test::append_triangle(mesh, Vec3(size), Vec3(size, 0.0f, 0.0f), Vec3(0.0f, size, 0.0f), 0);
    }
    const PreparedMesh prepared = prepare_mesh(mesh, materials());
    std::vector<std::uint32_t> order;
    check_node(prepared, 0, prepared.bounds, order);
    EXPECT_EQ(order.size(), prepared.leaves.size());
}

}  // namespace
}  // namespace ff::scene
