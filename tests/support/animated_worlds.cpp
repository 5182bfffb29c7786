#include "tests/support/animated_worlds.h"

#include <cmath>
#include <glm/geometric.hpp>
#include <string>

namespace ff::test {
namespace {

scene::Quat turn(const Vec3& axis, float angle) {
    const float s = std::sin(0.5f * angle);
    return {std::cos(0.5f * angle), axis.x * s, axis.y * s, axis.z * s};
}

void append_track(scene::Clip& clip, std::uint32_t joint, scene::TrackPath path, const std::vector<float>& times,
                  const std::vector<float>& values) {
    clip.tracks.push_back({.joint = joint,
                           .path = path,
                           .first_time = std::uint32_t(clip.times.size()),
                           .key_count = std::uint32_t(times.size()),
                           .first_value = std::uint32_t(clip.values.size())});
    clip.times.insert(clip.times.end(), times.begin(), times.end());
    clip.values.insert(clip.values.end(), values.begin(), values.end());
    clip.duration_s = std::max(clip.duration_s, times.back());
}

void append_joint(scene::Skeleton& skeleton, std::string name, std::uint32_t parent, const Vec3& translation) {
    skeleton.names.push_back(std::move(name));
    skeleton.parents.push_back(parent);
    skeleton.translations.push_back(translation);
    skeleton.rotations.emplace_back(1.0f, 0.0f, 0.0f, 0.0f);
    skeleton.scales.emplace_back(1.0f);
}

std::uint32_t add_box(scene::SceneData& scene, const Vec3& low, const Vec3& high) {
    scene::MeshSource mesh;
    append_box(mesh, low, high, 2, 0);
    return scene.add_mesh(scene::prepare_mesh(std::move(mesh), scene.materials));
}

}  // namespace

void append_random_track(Random& random, std::uint32_t joint, scene::TrackPath path, scene::Interpolation interpolation,
                         int keys, float duration_s, scene::Clip& clip) {
    std::vector<float> times;
    for (int k = 0; k < keys; ++k)
        times.push_back(duration_s * float((double(k) + 0.8 * random.unit()) / double(std::max(1, keys))));
    std::vector<float> values;
    const int numbers = int(scene::components_of(path));
    for (int k = 0; k < keys; ++k)
        for (int part = 0; part < (interpolation == scene::Interpolation::cubic ? 3 : 1); ++part) {
            const bool is_value = interpolation != scene::Interpolation::cubic || part == 1;
            float v[4], squared = 0.0f;
            for (int i = 0; i < numbers; ++i) {
                v[i] = float(random.in(-1.0, 1.0));
                squared += v[i] * v[i];
            }
            const bool is_rotation = path == scene::TrackPath::rotation && is_value;
            for (int i = 0; i < numbers; ++i)
                values.push_back(is_rotation                                   ? v[i] / std::sqrt(squared)
                                 : path == scene::TrackPath::scale && is_value ? 1.0f + 0.5f * v[i]
                                                                               : v[i]);
        }
    append_track(clip, joint, path, times, values);
    clip.tracks.back().interpolation = interpolation;
}

scene::AnimatedModel make_worm(scene::SceneData& scene, const WormSettings& worm) {
    constexpr float kGap = 0.5f;
    scene::AnimatedModel model{.name = "worm"};
    scene::Skin skin{.influences = 2};
    for (int j = 0; j < worm.joints; ++j) {
        append_joint(model.skeleton, "joint" + std::to_string(j), j == 0 ? scene::kNoJoint : std::uint32_t(j - 1),
                     Vec3(0.0f, j == 0 ? 0.0f : kGap, 0.0f));
        skin.joints.push_back(std::uint32_t(j));
        skin.joint_from_mesh.emplace_back(Vec3(1, 0, 0), Vec3(0, 1, 0), Vec3(0, 0, 1), Vec3(0, -kGap * float(j), 0));
    }
    scene::MeshSource mesh;
    const float height = kGap * float(worm.joints);
    for (int r = 0; r <= worm.rings; ++r)
        for (int s = 0; s < worm.sides; ++s) {
            const float angle = 2.0f * float(kPi) * float(s) / float(worm.sides);
            const Vec3 out(std::cos(angle), 0.0f, std::sin(angle));
            const float y = height * float(r) / float(worm.rings), radius = 0.3f - 0.2f * y / height;
            scene::VertexAttributes attributes{.color = 0xFF20A0E0u};
            scene::encode_normal(out, attributes.normal_oct);
            mesh.positions.push_back(radius * out + Vec3(0, y, 0));
            mesh.attributes.push_back(attributes);
        }
    const auto sides = std::uint32_t(worm.sides);
    for (std::uint32_t r = 0; r < std::uint32_t(worm.rings); ++r)
        for (std::uint32_t s = 0; s < sides; ++s) {
            const std::uint32_t a = r * sides + s, b = r * sides + (s + 1) % sides;
            for (const std::uint32_t i : {a, a + sides, b, b, a + sides, b + sides}) mesh.indices.push_back(i);
            mesh.triangle_materials.insert(mesh.triangle_materials.end(), 2, 0);
        }
    skin.mesh = scene.add_mesh(scene::prepare_mesh(std::move(mesh), scene.materials));
    // Preparing has put the vertices into another order: by their height.
    const scene::Mesh& stored = scene.meshes[skin.mesh];
    for (std::size_t v = 0; v < stored.vertex_count; ++v) {
        const float along = scene.positions[stored.first_vertex + v].y / kGap - 0.5f;
        const float first = std::min(std::max(std::floor(along), 0.0f), float(worm.joints - 1));
        const float second = std::min(first + 1.0f, float(worm.joints - 1));
        const float weight = std::min(std::max(along - first, 0.0f), 1.0f);
        const bool turned = weight > 0.5f;  // greatest first
        for (const float joint : {turned ? second : first, turned ? first : second})
            skin.vertex_joints.push_back(std::uint16_t(joint));
        skin.vertex_weights.push_back(turned ? weight : 1.0f - weight);
        skin.vertex_weights.push_back(turned ? 1.0f - weight : weight);
    }
    model.skins.push_back(std::move(skin));
    scene::Clip bend{.name = "bend"};
    for (std::uint32_t j = 0; j < model.skeleton.size(); ++j) {
        std::vector<float> times, values;
        for (int k = 0; k <= 8; ++k) {
            const float part = float(k) / 8.0f;
            const auto q = turn(Vec3(0, 0, 1), 0.3f * std::sin(2.0f * float(kPi) * (part + 0.1f * float(j))));
            times.push_back(worm.duration_s * part);
            for (const float number : {q.x, q.y, q.z, q.w}) values.push_back(number);
        }
        append_track(bend, j, scene::TrackPath::rotation, times, values);
    }
    scene::Clip stretch{.name = "stretch"};
    append_track(stretch, 0, scene::TrackPath::scale, {0.0f, 1.0f, 2.0f}, {1, 1, 1, 1, 1.5f, 1, 1, 1, 1});
    model.clips = {std::move(bend), std::move(stretch)};
    return model;
}

scene::AnimatedModel make_box_cart(scene::SceneData& scene) {
    scene::AnimatedModel model{.name = "cart"};
    append_joint(model.skeleton, "cart", scene::kNoJoint, Vec3(0.0f));
    append_joint(model.skeleton, "front", 0, Vec3(0.8f, 0.3f, 0.0f));
    append_joint(model.skeleton, "back", 0, Vec3(-0.8f, 0.3f, 0.0f));
    const std::uint32_t body = add_box(scene, {-1.2f, 0.5f, -0.5f}, {1.2f, 1.0f, 0.5f});
    const std::uint32_t wheel = add_box(scene, {-0.25f, -0.25f, -0.7f}, {0.25f, 0.25f, 0.7f});
    model.parts = {{.mesh = body, .joint = 0}, {.mesh = wheel, .joint = 1}, {.mesh = wheel, .joint = 2}};
    scene::Clip roll{.name = "roll"};
    append_track(roll, 0, scene::TrackPath::translation, {0, 2, 4}, {0, 0, 0, 4, 0, 0, 0, 0, 0});
    for (const std::uint32_t joint : {1u, 2u}) {
        std::vector<float> values;
        for (const float angle : {0.0f, -2.0f, 0.0f}) {
            const auto q = turn(Vec3(0, 0, 1), angle);
            for (const float number : {q.x, q.y, q.z, q.w}) values.push_back(number);
        }
        append_track(roll, joint, scene::TrackPath::rotation, {0, 2, 4}, values);
    }
    model.clips.push_back(std::move(roll));
    return model;
}

AnimatedSource make_animated_source(const AnimatedWorldSettings& settings) {
    AnimatedSource source;
    scene::SceneData& scene = source.scene;
    scene::WorldInfo& info = source.info;
    scene.materials.push_back(plain_material());
    scene::MeshSource ground;
    append_box(ground, {-100, -1, -100}, {100, 0, 100}, 20, 0);
    const std::uint32_t mesh = scene.add_mesh(scene::prepare_mesh(std::move(ground), scene.materials));
    scene.add_instance(mesh, settings.origin, Mat3(1.0f), 0);
    scene.environment.to_sun = glm::normalize(Vec3(0.4f, 0.7f, 0.3f));
    scene.environment.sun_shadows = true;
    info.name = "animated";
    info.animation.models.push_back(make_worm(scene, settings.worm));
    info.animation.models.push_back(make_box_cart(scene));
    const auto place = [&](std::uint32_t model, int i, double z) {
        info.animation.instances.push_back({.model = model,
                                            .position = settings.origin + DVec3(settings.spacing_m * i, 0.0, z),
                                            .world_from_model = turned_and_scaled(0.3 * i, Vec3(1.0f)),
                                            .clip = 0,
                                            .phase = 0.07 * double((i + 1400) % 14)});
    };
    for (int i = 0; i < settings.worms; ++i) place(0, i - settings.worms / 2, 0.0);
    for (int i = 0; i < settings.carts; ++i) place(1, i - settings.carts / 2, -settings.spacing_m);
    scene.finish(64);
    return source;
}

std::unique_ptr<scene::World> make_animated_world(const AnimatedWorldSettings& settings) {
    AnimatedSource source = make_animated_source(settings);
    return std::make_unique<scene::World>(std::move(source.scene), std::move(source.info));
}

}  // namespace ff::test
