// What posing costs: one mesh's vertices, its hierarchy, and a frame with 200 models of which some 20 are seen.

#include <benchmark/benchmark.h>

#include "engine/animation/dynamic_models.h"
#include "engine/animation/model_limits.h"
#include "engine/animation/skin_vertices.h"
#include "tests/support/animated_worlds.h"

namespace ff::animation {
namespace {

constexpr test::WormSettings kWorm{.joints = 20, .rings = 60, .sides = 16};  // 976 vertices, 1920 triangles

/// A worm's skin in the middle of its clip.
struct Posed {
    std::unique_ptr<scene::World> world = test::make_animated_world({.worms = 1, .carts = 0, .worm = kWorm});
    const scene::AnimatedModel& model = world->info().animation.models[0];
    SkinTables skin = make_skin_tables(world->scene(), model.skins[0]);
    std::vector<JointColumns> matrices = std::vector<JointColumns>(model.skins[0].joints.size());
    scene::Mesh mesh = world->pose_room().meshes[world->pose_room().slots[0].first];
    Vec3* positions = world->pose_room().positions.data() + mesh.first_vertex;
    scene::VertexAttributes* attributes = world->pose_room().attributes.data() + mesh.first_vertex;

    Posed() {
        Pose pose;
        pose.set_rest(model.skeleton);
        sample_clip(model.clips[0], 0.7f, pose);
        std::vector<Mat4x3> joints(model.skeleton.size());
        find_joint_matrices(model.skeleton, pose, joints);
        find_skin_matrices(model.skins[0], joints, matrices);
    }
};

void sample_a_pose(benchmark::State& state) {
    const Posed posed;
    Pose pose;
    std::vector<Mat4x3> joints(posed.model.skeleton.size());
    float time = 0.0f;
    for (auto _ : state) {
        pose.set_rest(posed.model.skeleton);
        sample_clip(posed.model.clips[0], time, pose);
        find_joint_matrices(posed.model.skeleton, pose, joints);
        benchmark::DoNotOptimize(joints.data());
        time = time < 1.9f ? time + 0.013f : 0.0f;
    }
    state.counters["joints"] = double(joints.size());
}
BENCHMARK(sample_a_pose);

void skin_a_mesh(benchmark::State& state) {
    const Posed posed;
    for (auto _ : state) skin_vertices(posed.skin, posed.matrices, posed.positions, posed.attributes);
    state.SetItemsProcessed(state.iterations() * posed.skin.vertex_count);
}
BENCHMARK(skin_a_mesh);

void skin_a_mesh_reference(benchmark::State& state) {
    const Posed posed;
    for (auto _ : state) skin_vertices_reference(posed.skin, posed.matrices, posed.positions, posed.attributes);
    state.SetItemsProcessed(state.iterations() * posed.skin.vertex_count);
}
BENCHMARK(skin_a_mesh_reference);

void refit_a_mesh(benchmark::State& state) {
    Posed posed;
    const scene::PoseRoom& room = posed.world->pose_room();
    for (auto _ : state)
        benchmark::DoNotOptimize(refit_mesh(posed.skin, posed.positions,
                                            room.leaves.subspan(posed.mesh.first_leaf, posed.mesh.leaf_count),
                                            room.nodes.subspan(posed.mesh.first_node, posed.mesh.node_count)));
    state.SetItemsProcessed(state.iterations() * posed.mesh.triangle_count);
}
BENCHMARK(refit_a_mesh);

/// Every frame at a time of its own.
void pose_200_models(benchmark::State& state) {
    const auto world = test::make_animated_world({.worms = 200, .carts = 0, .spacing_m = 2.0, .worm = kWorm});
    DynamicModels models(*world);
    auto states = initial_models(world->info().animation);
    for (std::size_t i = 0; i < states.size(); ++i) states[i].animator.now.time_s = 0.011 * double(i);
    const Camera camera{.position = {0.0, 3.0, 25.0}};
    for (auto _ : state) {
        for (ModelState& model : states) advance(model.animator, 1.0 / 60.0);
        benchmark::DoNotOptimize(models.pose(states, make_view(camera, 640, 480)).data());
    }
    state.counters["skins"] = models.stats().skins;
    state.counters["posed"] = models.stats().posed;
    state.counters["vertices"] = double(models.stats().vertices);
}
BENCHMARK(pose_200_models)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace ff::animation
