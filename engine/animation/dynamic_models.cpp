#include "engine/animation/dynamic_models.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include "engine/animation/model_limits.h"
#include "engine/animation/pose_slots.h"
#include "engine/animation/seen_bounds.h"
#include "engine/animation/skin_vertices.h"
#include "engine/core/check.h"
#include "engine/core/jobs.h"
#include "engine/ecs/transform_hierarchy.h"
#include "engine/scene/instance_bounds.h"

namespace ff::animation {
namespace {

using scene::AnimatedModel;
using scene::Instance;

/// What is known of a model once and for all.
struct ModelTables {
    std::uint32_t first_skin = 0;              ///< of all skins
    float reach_m = 0.0f;                      ///< from the model's origin
    std::vector<float> clip_speeds;            ///< metres a second
    std::vector<std::uint32_t> skin_matrices;  ///< [skin]: first of its joints among the model's
    std::uint32_t matrix_count = 0;
};

/// A model that may matter to this frame, and room to find its pose in; kept from frame to frame.
struct Candidate {
    const ModelState* state = nullptr;
    Animator animator;  ///< at the time that is shown
    double distance_m = 0.0;
    Pose pose, fading, layer;
    std::vector<Mat4x3> joints;          ///< model_from_joint
    std::vector<JointColumns> matrices;  ///< of all its skins
    std::vector<Instance> parts;         ///< rigid ones, where they may be seen
    std::vector<bool> skin_matters;
    std::vector<DBox3> skin_bounds;
};

/// A skinned mesh of a candidate that is drawn.
struct SeenSkin {
    std::uint32_t candidate = 0, skin = 0;  ///< of the model
};

/// A bound of how much longer a matrix makes a vector, exact where its columns are at right angles: by Gershgorin's
/// circles of its square.
double greatest_scale(const Mat3& m) {
    const DMat3 square = glm::transpose(DMat3(m)) * DMat3(m);
    double most = 0.0;
    for (int c = 0; c < 3; ++c)
        most = std::max(most, std::fabs(square[c][0]) + std::fabs(square[c][1]) + std::fabs(square[c][2]));
    return std::sqrt(most);
}

/// World from a mesh that hangs in a model: the translation in double.
Instance placed(const ModelState& state, const Mat4x3& model_from_mesh, std::uint32_t mesh) {
    const Mat3 linear(model_from_mesh[0], model_from_mesh[1], model_from_mesh[2]);
    return {.position = state.position + DMat3(state.world_from_model) * DVec3(model_from_mesh[3]),
            .world_from_mesh = state.world_from_model * linear,
            .mesh = mesh};
}

bool is_flat(const Mat3& m) {
    const double volume = glm::determinant(DMat3(m));
    const double size = double(glm::length(m[0])) * glm::length(m[1]) * glm::length(m[2]);
    return !(std::fabs(volume) > 1e-9 * size) || !(size > 1e-30) || !std::isfinite(volume);
}

/// What numbers are too large to be drawn: packs may hold any that are finite, and hierarchies multiply them.
bool are_finite(std::span<const JointColumns> matrices) {
    float sum = 0.0f;
    for (const JointColumns& m : matrices)
        for (const auto& column : m.column) sum += 0.0f * column[0] + 0.0f * column[1] + 0.0f * column[2];
    return sum == 0.0f;
}

}  // namespace

struct DynamicModels::Impl {
    scene::World& world;
    const scene::AnimationSet& set;
    const scene::StaticScene& scene;
    scene::PoseRoom room;
    std::vector<ModelTables> models;
    std::vector<SkinTables> skins;  // of all models, in the order of room.slots
    std::vector<PoseSlotTable> slots;
    std::vector<std::vector<float>> masks;
    PoseStats stats;

    // Of the frame.
    std::vector<Candidate> candidates;
    std::size_t candidate_count = 0;
    std::vector<SeenSkin> seen;
    std::vector<std::vector<PoseRequest>> requests;  // [skin of all]; owners are numbers of `seen`
    std::vector<std::uint32_t> mesh_of_seen;
    struct Task {
        std::uint32_t candidate, skin, all_skin, mesh;
    };
    std::vector<Task> tasks;
    std::vector<Instance> instances;

    explicit Impl(scene::World& owner)
        : world(owner), set(owner.info().animation), scene(owner.scene()), room(owner.pose_room()) {
        for (const AnimatedModel& model : set.models) {
            ModelTables& tables = models.emplace_back();
            tables.first_skin = std::uint32_t(skins.size());
            for (const scene::Skin& skin : model.skins) {
                tables.skin_matrices.push_back(tables.matrix_count);
                tables.matrix_count += std::uint32_t(skin.joints.size());
                slots.emplace_back(room.slots[skins.size()].count);
                skins.push_back(make_skin_tables(scene, skin));
            }
            const auto of_model = std::span(skins).subspan(tables.first_skin);
            tables.reach_m = find_reach(model, scene.meshes, of_model);
            for (const scene::Clip& clip : model.clips)
                tables.clip_speeds.push_back(find_speed(model, clip, scene.meshes, of_model));
        }
        requests.resize(skins.size());
    }

    void fit(std::size_t state_count);
    void find_candidates(std::span<const ModelState> states, const PinholeView& view, const SeenBounds& seen_bounds,
                         const PoseSettings& settings);
    void sample(Candidate& candidate, const SeenBounds& seen_bounds) const;
    void sample_play(const AnimatedModel& model, const ClipPlay& play, Pose& out) const;
    void request_poses();
    void compute(const Task& task);
    void list_instances();
};

namespace {

/// The animator with its clip's time moved back to the last at which it would have been posed anyway.
Animator held_back(const Animator& animator, const ModelTables& model, const ModelState& state, double distance_m,
                   double pixel_angle, float max_shift_px) {
    Animator held = animator;
    if (held.fade_left_s <= 0.0f) {  // what has faded out no longer matters
        held.before = {};
        held.fade_s = held.fade_left_s = 0.0f;
    }
    if (!(held.layer_weight > 0.0f)) {
        held.layer = {};
        held.layer_mask = kNoMask;
    }
    const bool plays_one = held.fade_left_s <= 0.0f && !(held.layer_weight > 0.0f) && held.now.clip != scene::kNoClip;
    if (!plays_one || !(max_shift_px > 0.0f)) return held;
    const double scale = greatest_scale(state.world_from_model);
    const double nearest_m = distance_m - double(model.reach_m) * scale;
    if (!(nearest_m > 0.0)) return held;
    const double speed_px = double(model.clip_speeds[held.now.clip]) * scale / (nearest_m * pixel_angle);
    // Powers of two: neighbours at about the same distance change together and share poses.
    constexpr int kFinest = -7, kCoarsest = 2;
    const double longest_s = double(max_shift_px) / std::max(speed_px, 1e-9);
    const int exponent = std::min(int(std::floor(std::log2(longest_s))), kCoarsest);
    if (exponent < kFinest) return held;
    const double step_s = std::ldexp(1.0, exponent);
    held.now.time_s = std::floor(held.now.time_s / step_s) * step_s;
    return held;
}

/// Animators that show the same have the same key.
PoseKey key_of(const Animator& animator, const AnimatedModel& model) {
    PoseKey key{animator};
    for (ClipPlay* play : {&key.animator.now, &key.animator.before, &key.animator.layer}) {
        if (play->clip == scene::kNoClip) {
            *play = {};
        } else {  // played round, a clip shows the same again
            play->time_s = double(clip_time(model.clips[play->clip], play->time_s, play->mode));
            play->speed = 1.0f;
            play->mode = PlayMode::once;
        }
    }
    if (key.animator.fade_left_s > 0.0f) {  // only how far it is counts
        key.animator.fade_left_s = 1.0f - fade_weight(animator);
        key.animator.fade_s = 1.0f;
    }
    return key;
}

}  // namespace

/// Room for all of so many models to matter at once, whichever they are: later frames then allocate nothing.
void DynamicModels::Impl::fit(std::size_t state_count) {
    if (state_count <= candidates.size()) return;
    std::size_t most_joints = 0, most_matrices = 0, most_parts = 0, most_skins = 0;
    for (std::size_t i = 0; i < models.size(); ++i) {
        most_joints = std::max<std::size_t>(most_joints, set.models[i].skeleton.size());
        most_matrices = std::max<std::size_t>(most_matrices, models[i].matrix_count);
        most_parts = std::max(most_parts, set.models[i].parts.size());
        most_skins = std::max(most_skins, set.models[i].skins.size());
    }
    candidates.resize(state_count);
    for (Candidate& c : candidates) {
        for (Pose* pose : {&c.pose, &c.fading, &c.layer}) {
            pose->translations.reserve(most_joints);
            pose->rotations.reserve(most_joints);
            pose->scales.reserve(most_joints);
        }
        c.joints.reserve(most_joints);
        c.matrices.reserve(most_matrices);
        c.parts.reserve(most_parts);
        c.skin_matters.reserve(most_skins);
        c.skin_bounds.reserve(most_skins);
    }
    for (auto& list : requests) list.reserve(state_count);
    seen.reserve(state_count * most_skins);
    mesh_of_seen.reserve(state_count * most_skins);
    tasks.reserve(skins.size() * scene::kMostPoses);
    instances.reserve(state_count * (most_parts + most_skins));
}

void DynamicModels::Impl::find_candidates(std::span<const ModelState> states, const PinholeView& view,
                                          const SeenBounds& seen_bounds, const PoseSettings& settings) {
    candidate_count = 0;
    for (const ModelState& state : states) {
        FF_CHECK(state.animator.model < models.size(), "model {} of {}", state.animator.model, models.size());
        const ModelTables& model = models[state.animator.model];
        const double reach_m = double(model.reach_m) * greatest_scale(state.world_from_model);
        if (!seen_bounds.may_matter({state.position - reach_m, state.position + reach_m})) continue;
        Candidate& candidate = candidates[candidate_count++];
        candidate.state = &state;
        candidate.distance_m = glm::length(state.position - view.position);
        candidate.animator = held_back(state.animator, model, state, candidate.distance_m, double(view.pixel_angle()),
                                       settings.max_shift_px);
    }
}

void DynamicModels::Impl::sample_play(const AnimatedModel& model, const ClipPlay& play, Pose& out) const {
    out.set_rest(model.skeleton);
    if (play.clip == scene::kNoClip) return;
    FF_CHECK(play.clip < model.clips.size(), "clip {} of {}", play.clip, model.clips.size());
    const scene::Clip& clip = model.clips[play.clip];
    sample_clip(clip, clip_time(clip, play.time_s, play.mode), out);
}

/// The pose of a candidate, where that puts its parts and skins, and which of them may be seen.
void DynamicModels::Impl::sample(Candidate& c, const SeenBounds& seen_bounds) const {
    const AnimatedModel& model = set.models[c.animator.model];
    const ModelTables& tables = models[c.animator.model];
    sample_play(model, c.animator.now, c.pose);
    if (c.animator.fade_left_s > 0.0f) {
        sample_play(model, c.animator.before, c.fading);
        blend_onto(c.pose, c.fading, 1.0f - fade_weight(c.animator));
    }
    if (c.animator.layer_weight > 0.0f) {
        sample_play(model, c.animator.layer, c.layer);
        const std::uint32_t mask = c.animator.layer_mask;
        blend_onto(c.pose, c.layer, std::min(c.animator.layer_weight, 1.0f),
                   mask == kNoMask ? std::span<const float>() : masks[mask]);
    }
    c.joints.resize(model.skeleton.size());
    find_joint_matrices(model.skeleton, c.pose, c.joints);

    c.parts.clear();
    for (const scene::RigidPart& part : model.parts) {
        Instance instance = placed(*c.state, product(c.joints[part.joint], part.joint_from_mesh), part.mesh);
        if (is_flat(instance.world_from_mesh)) continue;  // scaled away
        instance.bounds = scene::world_box(instance, scene.meshes[part.mesh].bounds);
        if (seen_bounds.may_matter(instance.bounds)) c.parts.push_back(instance);
    }
    c.matrices.resize(tables.matrix_count);
    c.skin_matters.assign(model.skins.size(), false);
    c.skin_bounds.resize(model.skins.size());
    for (std::size_t s = 0; s < model.skins.size(); ++s) {
        const std::span<JointColumns> matrices =
            std::span(c.matrices).subspan(tables.skin_matrices[s], model.skins[s].joints.size());
        find_skin_matrices(model.skins[s], c.joints, matrices);
        const Instance whole{.position = c.state->position, .world_from_mesh = c.state->world_from_model};
        const Box3 box = posed_bounds(skins[tables.first_skin + s], matrices);
        if (box.is_empty() || !are_finite(matrices)) continue;
        c.skin_bounds[s] = scene::world_box(whole, box);
        c.skin_matters[s] = seen_bounds.may_matter(c.skin_bounds[s]);
    }
}

/// Gives every skin that may be seen a copy of its mesh, and lists what is to be computed.
void DynamicModels::Impl::request_poses() {
    seen.clear();
    tasks.clear();
    for (auto& list : requests) list.clear();
    for (std::uint32_t i = 0; i < candidate_count; ++i) {
        const Candidate& c = candidates[i];
        const PoseKey key = key_of(c.animator, set.models[c.animator.model]);
        for (std::uint32_t s = 0; s < c.skin_matters.size(); ++s) {
            if (!c.skin_matters[s]) continue;
            requests[models[c.animator.model].first_skin + s].push_back(
                {.key = key, .distance_m = c.distance_m, .owner = std::uint32_t(seen.size())});
            seen.push_back({i, s});
        }
    }
    mesh_of_seen.resize(seen.size());
    for (std::size_t all = 0; all < requests.size(); ++all) {
        slots[all].assign(requests[all]);
        for (const PoseRequest& request : requests[all]) {
            const SeenSkin& owner = seen[request.owner];
            const std::uint32_t mesh = room.slots[all].first + request.slot;
            mesh_of_seen[request.owner] = mesh;
            if (request.must_pose) tasks.push_back({owner.candidate, owner.skin, std::uint32_t(all), mesh});
            if (request.is_borrowed) ++stats.borrowed;
        }
    }
    stats.skins = std::uint32_t(seen.size());
    stats.posed = std::uint32_t(tasks.size());
    for (const Task& task : tasks) stats.vertices += skins[task.all_skin].vertex_count;
}

void DynamicModels::Impl::compute(const Task& task) {
    const Candidate& c = candidates[task.candidate];
    const ModelTables& tables = models[c.animator.model];
    const SkinTables& skin = skins[task.all_skin];
    scene::Mesh& mesh = room.meshes[task.mesh];
    Vec3* positions = room.positions.data() + mesh.first_vertex;
    skin_vertices(skin, std::span(c.matrices).subspan(tables.skin_matrices[task.skin]), positions,
                  room.attributes.data() + mesh.first_vertex);
    mesh.bounds = refit_mesh(skin, positions, room.leaves.subspan(mesh.first_leaf, mesh.leaf_count),
                             room.nodes.subspan(mesh.first_node, mesh.node_count));
}

void DynamicModels::Impl::list_instances() {
    instances.clear();
    std::size_t next = 0;
    for (std::uint32_t i = 0; i < candidate_count; ++i) {
        const Candidate& c = candidates[i];
        instances.insert(instances.end(), c.parts.begin(), c.parts.end());
        for (; next < seen.size() && seen[next].candidate == i; ++next) {
            Instance instance{.position = c.state->position,
                              .world_from_mesh = c.state->world_from_model,
                              .mesh = mesh_of_seen[next]};
            instance.bounds = scene::world_box(instance, scene.meshes[instance.mesh].bounds);
            instances.push_back(instance);
        }
    }
}

DynamicModels::DynamicModels(scene::World& world) : impl_(std::make_unique<Impl>(world)) {}
DynamicModels::~DynamicModels() = default;

std::uint32_t DynamicModels::add_mask(std::uint32_t model, std::string_view joint) {
    const scene::Skeleton& skeleton = impl_->set.models[model].skeleton;
    const std::uint32_t root = scene::find_joint(skeleton, joint);
    if (root == scene::kNoJoint) return kNoMask;
    impl_->masks.push_back(mask_below(skeleton, root));
    return std::uint32_t(impl_->masks.size() - 1);
}

std::span<const Instance> DynamicModels::pose(std::span<const ModelState> states, const PinholeView& view,
                                              const PoseSettings& settings) {
    Impl& m = *impl_;
    m.stats = {.models = std::uint32_t(states.size())};
    m.fit(states.size());
    const SeenBounds seen_bounds(m.scene, view);
    m.find_candidates(states, view, seen_bounds, settings);
    m.stats.sampled = std::uint32_t(m.candidate_count);
    parallel_for(m.candidate_count, [&](std::size_t i) { m.sample(m.candidates[i], seen_bounds); });
    m.request_poses();
    parallel_for(m.tasks.size(), [&](std::size_t i) { m.compute(m.tasks[i]); });
    m.list_instances();
    return m.instances;
}

const PoseStats& DynamicModels::stats() const {
    return impl_->stats;
}

std::vector<ModelState> initial_models(const scene::AnimationSet& set) {
    std::vector<ModelState> states;
    for (const scene::AnimatedInstance& instance : set.instances)
        states.push_back({.position = instance.position,
                          .world_from_model = instance.world_from_model,
                          .animator = {.model = instance.model, .now = {.clip = instance.clip}}});
    set_time(set, 0.0, states);
    return states;
}

void set_time(const scene::AnimationSet& set, double time_s, std::span<ModelState> states) {
    for (std::size_t i = 0; i < states.size(); ++i) {
        const scene::AnimatedInstance& instance = set.instances[i];
        if (instance.clip == scene::kNoClip) continue;
        const double duration_s = set.models[instance.model].clips[instance.clip].duration_s;
        states[i].animator.now.time_s = time_s + instance.phase * duration_s;
    }
}

void gather_models(ecs::Registry& registry, std::vector<ModelState>& out) {
    out.clear();
    registry.each<const ecs::WorldTransform, const Animator>(
        [&](const ecs::WorldTransform& transform, const Animator& animator) {
            out.push_back({transform.position, transform.linear, animator});
        });
}

}  // namespace ff::animation
