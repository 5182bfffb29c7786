#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>

#include "engine/animation/model_limits.h"
#include "engine/animation/sample_clip.h"
#include "engine/animation/skin_vertices.h"
#include "tests/support/animated_worlds.h"

namespace ff::animation {
namespace {

JointColumns random_matrix(test::Random& random, float spread) {
    JointColumns m{};
    for (int c = 0; c < 4; ++c)
        for (int r = 0; r < 3; ++r) m.column[c][r] = float(random.in(-1.0, 1.0)) * spread + (c == r ? 1.0f : 0.0f);
    return m;
}

/// A skin of `count` random vertices.
SkinTables random_skin(test::Random& random, std::uint32_t count, std::uint32_t influences, std::uint32_t joints) {
    SkinTables skin{.vertex_count = count, .influences = influences};
    const std::size_t padded = (count + kSkinPadding - 1) / kSkinPadding * kSkinPadding;
    for (auto* array : {&skin.x, &skin.y, &skin.z, &skin.normal_x, &skin.normal_y, &skin.normal_z})
        array->resize(padded);
    for (std::size_t v = 0; v < count; ++v) {
        const Vec3 p = random.in_box(Vec3(-3), Vec3(3));
        const Vec3 n = glm::normalize(random.in_box(Vec3(-1), Vec3(1)) + Vec3(0.001f));
        skin.x[v] = p.x;
        skin.y[v] = p.y;
        skin.z[v] = p.z;
        skin.normal_x[v] = n.x;
        skin.normal_y[v] = n.y;
        skin.normal_z[v] = n.z;
        std::vector<float> weights(influences);
        float sum = 0.0f;
        for (float& w : weights) sum += w = float(random.unit()) * (random.below(3) == 0 ? 0.0f : 1.0f);
        weights[0] += 1e-3f;
        sum += 1e-3f;
        std::sort(weights.rbegin(), weights.rend());
        for (const float w : weights) {
            skin.weights.push_back(w / sum);
            skin.joints.push_back(std::uint16_t(random.below(joints)));
        }
    }
    return skin;
}

TEST(Skin, vertices_are_where_the_reference_in_double_puts_them) {
    for (std::uint32_t seed = 0; seed < 60; ++seed) {
        SCOPED_TRACE(seed);
        test::Random random(seed);
        const std::uint32_t count = 1 + random.below(200), influences = 1 + random.below(8);
        const SkinTables skin = random_skin(random, count, influences, 9);
        std::vector<JointColumns> matrices;
        for (int j = 0; j < 9; ++j) matrices.push_back(random_matrix(random, 0.4f));
        std::vector<Vec3> fast(count), plain(count);
        std::vector<scene::VertexAttributes> fast_attributes(count), plain_attributes(count);
        for (std::size_t v = 0; v < count; ++v) fast_attributes[v].uv = plain_attributes[v].uv = Vec2(float(v), 1.0f);
        skin_vertices(skin, matrices, fast.data(), fast_attributes.data());
        skin_vertices_reference(skin, matrices, plain.data(), plain_attributes.data());
        for (std::size_t v = 0; v < count; ++v) {
            EXPECT_LT(glm::length(fast[v] - plain[v]), 1e-5f) << v;
            const Vec3 a = scene::decode_normal(fast_attributes[v].normal_oct);
            const Vec3 b = scene::decode_normal(plain_attributes[v].normal_oct);
            EXPECT_LT(glm::length(a - b), 2e-3f) << v;
            EXPECT_EQ(fast_attributes[v].uv.x, float(v));
        }
    }
}

class WormTest : public testing::Test {
  protected:
    WormTest() : world(test::make_animated_world({.worms = 1, .carts = 0})) {}

    /// The matrices of the worm's skin at a time of a clip.
    std::vector<JointColumns> matrices_at(std::size_t clip, float time) const {
        const scene::AnimatedModel& model = world->info().animation.models[0];
        Pose pose;
        pose.set_rest(model.skeleton);
        sample_clip(model.clips[clip], time, pose);
        std::vector<Mat4x3> joints(model.skeleton.size());
        find_joint_matrices(model.skeleton, pose, joints);
        std::vector<JointColumns> matrices(model.skins[0].joints.size());
        find_skin_matrices(model.skins[0], joints, matrices);
        return matrices;
    }
    std::unique_ptr<scene::World> world;
};

TEST_F(WormTest, a_refitted_hierarchy_holds_every_triangle_and_no_more) {
    const scene::PoseRoom& room = world->pose_room();
    const SkinTables skin = make_skin_tables(world->scene(), world->info().animation.models[0].skins[0]);
    scene::Mesh& mesh = room.meshes[room.slots[0].first];
    Vec3* positions = room.positions.data() + mesh.first_vertex;
    const auto leaves = room.leaves.subspan(mesh.first_leaf, mesh.leaf_count);
    const auto nodes = room.nodes.subspan(mesh.first_node, mesh.node_count);
    for (const float time : {0.0f, 0.4f, 1.1f, 1.9f}) {
        const auto matrices = matrices_at(0, time);
        skin_vertices(skin, matrices, positions, room.attributes.data() + mesh.first_vertex);
        const Box3 bounds = refit_mesh(skin, positions, leaves, nodes);
        Box3 exact;
        for (std::size_t v = 0; v < mesh.vertex_count; ++v) exact.add(positions[v]);
        EXPECT_EQ(bounds.low, exact.low);
        EXPECT_EQ(bounds.high, exact.high);
        // Of the bound that poses nothing, too.
        const Box3 guess = posed_bounds(skin, matrices);
        for (int c = 0; c < 3; ++c) {
            EXPECT_LE(guess.low[c], exact.low[c] + 1e-5f);
            EXPECT_GE(guess.high[c], exact.high[c] - 1e-5f);
        }
        for (const scene::BvhLeaf& leaf : leaves)
            for (int i = 0; i < leaf.triangle_count; ++i)
                for (int corner = 0; corner < 3; ++corner) {
                    const int slot = leaf.corner[corner][i];
                    const std::size_t triangle =
                        mesh.first_triangle + std::size_t(leaf.first_triangle) + std::size_t(i);
                    const Vec3 p = positions[world->scene().indices[3 * triangle + std::size_t(corner)]];
                    EXPECT_EQ(Vec3(leaf.x[slot], leaf.y[slot], leaf.z[slot]), p);
                }
        for (const scene::BvhNode& node : nodes)
            for (int lane = 0; lane < scene::kBvhWidth; ++lane) {
                if (node.child[lane] == scene::kBvhEmpty || (node.child[lane] & scene::kBvhLeafBit) == 0) continue;
                const scene::BvhLeaf& leaf = leaves[node.child[lane] & ~scene::kBvhLeafBit];
                Box3 box;
                for (int i = 0; i < leaf.vertex_count; ++i) box.add(Vec3(leaf.x[i], leaf.y[i], leaf.z[i]));
                EXPECT_EQ(Vec3(node.low_x[lane], node.low_y[lane], node.low_z[lane]), box.low);
                EXPECT_EQ(Vec3(node.high_x[lane], node.high_y[lane], node.high_z[lane]), box.high);
            }
    }
}

TEST_F(WormTest, reach_and_speed_bound_what_clips_do) {
    const scene::AnimatedModel& model = world->info().animation.models[0];
    const SkinTables skin = make_skin_tables(world->scene(), model.skins[0]);
    const float reach = find_reach(model, world->scene().meshes, std::span(&skin, 1));
    const float speed = find_speed(model, model.clips[0], world->scene().meshes, std::span(&skin, 1));
    std::vector<Vec3> before(skin.vertex_count), now(skin.vertex_count);
    std::vector<scene::VertexAttributes> attributes(skin.vertex_count);
    constexpr float kStep = 1.0f / 200.0f;
    float fastest = 0.0f;
    for (int i = 0; i < 400; ++i) {
        skin_vertices(skin, matrices_at(0, kStep * float(i)), now.data(), attributes.data());
        for (std::size_t v = 0; v < now.size(); ++v) {
            EXPECT_LE(glm::length(now[v]), reach);
            if (i > 0) fastest = std::max(fastest, glm::length(now[v] - before[v]) / kStep);
        }
        before = now;
    }
    EXPECT_LE(fastest, speed);
    EXPECT_LE(speed, 3.0f * fastest) << "so loose that nothing is held back";
    EXPECT_LE(reach, 3.0f * 3.0f * 1.5f);
}

}  // namespace
}  // namespace ff::animation
