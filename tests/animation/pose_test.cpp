#include "engine/animation/pose.h"

#include <gtest/gtest.h>

#include <cmath>
#include <glm/gtc/quaternion.hpp>
#include <glm/mat4x4.hpp>

#include "tests/support/worlds.h"

namespace ff::animation {
namespace {

Quat random_rotation(test::Random& random) {
    const Quat q(float(random.in(-1, 1)), float(random.in(-1, 1)), float(random.in(-1, 1)), float(random.in(-1, 1)));
    return glm::normalize(q);
}

Pose random_pose(test::Random& random, std::size_t joints) {
    Pose pose;
    for (std::size_t j = 0; j < joints; ++j) {
        pose.translations.push_back(random.in_box(Vec3(-2), Vec3(2)));
        pose.rotations.push_back(random_rotation(random));
        pose.scales.push_back(random.in_box(Vec3(0.5f), Vec3(2)));
    }
    return pose;
}

float angle_between(const Quat& a, const Quat& b) {
    return 2.0f * std::acos(std::min(1.0f, std::fabs(glm::dot(a, b))));
}

scene::Skeleton random_skeleton(test::Random& random, std::uint32_t joints) {
    scene::Skeleton skeleton;
    for (std::uint32_t j = 0; j < joints; ++j) {
        skeleton.names.push_back(j == 2 ? "arm" : "");
        skeleton.parents.push_back(j == 0 ? scene::kNoJoint : random.below(j));
    }
    return skeleton;
}

TEST(Pose, a_blend_of_one_is_that_one_and_signs_do_not_matter) {
    test::Random random(1);
    const Pose a = random_pose(random, 8);
    Pose turned = a, out = a;
    for (Quat& q : turned.rotations) q = -q;  // the same rotations
    const WeightedPose poses[] = {{&a, 0.3f}, {&turned, 0.7f}};
    blend_poses(poses, out);
    for (std::size_t j = 0; j < 8; ++j) {
        EXPECT_LT(angle_between(out.rotations[j], a.rotations[j]), 2e-3f);
        EXPECT_NEAR(glm::length(out.rotations[j]), 1.0f, 1e-5f);
    }
    const WeightedPose nothing[] = {{&turned, 0.0f}};
    Pose kept = random_pose(random, 8);
    const Pose before = kept;
    blend_poses(nothing, kept);
    EXPECT_EQ(kept.translations, before.translations);
}

TEST(Pose, a_blend_of_two_is_the_fade_between_them) {
    test::Random random(2);
    const Pose a = random_pose(random, 12), b = random_pose(random, 12);
    for (const float w : {0.0f, 0.25f, 0.5f, 0.9f, 1.0f}) {
        Pose blended = a, faded = a;
        const WeightedPose poses[] = {{&a, 1.0f - w}, {&b, w}};
        blend_poses(poses, blended);
        blend_onto(faded, b, w);
        for (std::size_t j = 0; j < 12; ++j) {
            EXPECT_LT(angle_between(blended.rotations[j], faded.rotations[j]), 2e-3f);
            for (int c = 0; c < 3; ++c) {
                EXPECT_NEAR(blended.translations[j][c], faded.translations[j][c], 1e-5f);
                EXPECT_NEAR(blended.scales[j][c], faded.scales[j][c], 1e-5f);
            }
        }
        if (w == 1.0f) {
            EXPECT_LT(angle_between(faded.rotations[3], b.rotations[3]), 2e-3f);
        }
    }
}

TEST(Pose, a_mask_leaves_the_other_joints_alone) {
    test::Random random(3);
    const scene::Skeleton skeleton = random_skeleton(random, 20);
    const std::vector<float> mask = mask_below(skeleton, scene::find_joint(skeleton, "arm"));
    const Pose before = random_pose(random, 20), over = random_pose(random, 20);
    Pose pose = before;
    blend_onto(pose, over, 1.0f, mask);
    for (std::uint32_t j = 0; j < 20; ++j) {
        bool is_below = j == 2;
        for (std::uint32_t p = j; !is_below && skeleton.parents[p] != scene::kNoJoint;) {
            p = skeleton.parents[p];
            is_below = p == 2;
        }
        EXPECT_EQ(mask[j] > 0.0f, is_below) << j;
        const Vec3 expected = is_below ? over.translations[j] : before.translations[j];
        for (int c = 0; c < 3; ++c) EXPECT_NEAR(pose.translations[j][c], expected[c], 1e-6f) << j;
    }
    EXPECT_EQ(mask_below(skeleton, scene::kNoJoint), std::vector<float>(20, 0.0f));
}

TEST(Pose, joints_stand_where_the_product_of_their_ancestors_puts_them) {
    for (std::uint32_t seed = 0; seed < 30; ++seed) {
        test::Random random(seed);
        const scene::Skeleton skeleton = random_skeleton(random, 15);
        const Pose pose = random_pose(random, 15);
        std::vector<Mat4x3> found(15);
        find_joint_matrices(skeleton, pose, found);
        for (std::uint32_t j = 0; j < 15; ++j) {
            glm::dmat4 expected(1.0);
            for (std::uint32_t p = j; p != scene::kNoJoint; p = skeleton.parents[p]) {
                glm::dmat4 local = glm::mat4_cast(glm::dquat(pose.rotations[p]));
                for (int c = 0; c < 3; ++c) local[c] *= double(pose.scales[p][c]);
                local[3] = glm::dvec4(DVec3(pose.translations[p]), 1.0);
                expected = local * expected;
            }
            for (int c = 0; c < 4; ++c)
                for (int r = 0; r < 3; ++r)
                    EXPECT_NEAR(double(found[j][c][r]), expected[c][r], 1e-4 * (1.0 + std::fabs(expected[c][r])));
        }
    }
}

}  // namespace
}  // namespace ff::animation
