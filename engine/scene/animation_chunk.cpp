#include "engine/scene/animation_chunk.h"

#include <algorithm>
#include <cstring>

#include "engine/assets/aligned_vector.h"
#include "engine/scene/animation_generated.h"

namespace ff::scene {
namespace {

using flatbuffers::FlatBufferBuilder;
using flatbuffers::Offset;

/// Arrays of vectors, quaternions and matrices are arrays of floats to the file.
template <class T>
Offset<flatbuffers::Vector<float>> floats(FlatBufferBuilder& builder, const std::vector<T>& values) {
    static_assert(sizeof(T) % sizeof(float) == 0);
    return builder.CreateVector(reinterpret_cast<const float*>(values.data()), values.size() * sizeof(T) / 4);
}

Offset<disk::Skeleton> to_disk(FlatBufferBuilder& builder, const Skeleton& skeleton) {
    const auto names = builder.CreateVectorOfStrings(skeleton.names);
    const auto parents = builder.CreateVector(skeleton.parents);
    const auto translations = floats(builder, skeleton.translations);
    const auto rotations = floats(builder, skeleton.rotations);
    const auto scales = floats(builder, skeleton.scales);
    return disk::CreateSkeleton(builder, names, parents, translations, rotations, scales);
}

Offset<disk::Clip> to_disk(FlatBufferBuilder& builder, const Clip& clip) {
    std::vector<disk::Track> tracks;
    for (const Track& t : clip.tracks)
        tracks.emplace_back(t.joint, t.first_time, t.key_count, t.first_value, std::uint8_t(t.path),
                            std::uint8_t(t.interpolation), std::uint8_t(t.even), std::uint8_t(0));
    const auto name = builder.CreateString(clip.name);
    const auto track_list = builder.CreateVectorOfStructs(tracks);
    const auto times = builder.CreateVector(clip.times);
    const auto values = builder.CreateVector(clip.values);
    return disk::CreateClip(builder, name, clip.duration_s, track_list, times, values);
}

Offset<disk::Skin> to_disk(FlatBufferBuilder& builder, const Skin& skin) {
    const auto joints = builder.CreateVector(skin.joints);
    const auto matrices = floats(builder, skin.joint_from_mesh);
    const auto vertex_joints = builder.CreateVector(skin.vertex_joints);
    const auto weights = builder.CreateVector(skin.vertex_weights);
    return disk::CreateSkin(builder, skin.mesh, joints, matrices, skin.influences, vertex_joints, weights);
}

Offset<disk::AnimatedModel> to_disk(FlatBufferBuilder& builder, const AnimatedModel& model) {
    std::vector<Offset<disk::Clip>> clips;
    for (const Clip& clip : model.clips) clips.push_back(to_disk(builder, clip));
    std::vector<Offset<disk::Skin>> skins;
    for (const Skin& skin : model.skins) skins.push_back(to_disk(builder, skin));
    std::vector<std::uint32_t> meshes, joints;
    std::vector<Mat4x3> transforms;
    for (const RigidPart& part : model.parts) {
        meshes.push_back(part.mesh);
        joints.push_back(part.joint);
        transforms.push_back(part.joint_from_mesh);
    }
    const auto name = builder.CreateString(model.name);
    const auto skeleton = to_disk(builder, model.skeleton);
    const auto clip_list = builder.CreateVector(clips);
    const auto part_meshes = builder.CreateVector(meshes);
    const auto part_joints = builder.CreateVector(joints);
    const auto part_transforms = floats(builder, transforms);
    const auto skin_list = builder.CreateVector(skins);
    return disk::CreateAnimatedModel(builder, name, skeleton, clip_list, part_meshes, part_joints, part_transforms,
                                     skin_list);
}

disk::Axis axis(const Vec3& v) {
    return {v.x, v.y, v.z};
}
Vec3 vec3(const disk::Axis& a) {
    return {a.x(), a.y(), a.z()};
}

/// Reads tables, and counts what they hold: several entries of a FlatBuffer may point to one table, so that a small
/// file could ask for any amount of memory.
class Reader {
  public:
    Reader(std::size_t file_bytes) : left_(file_bytes) {}

    void read(const disk::Animation& table, AnimationSet& set) {
        for (const disk::AnimatedModel* model : *table.models()) {
            if (!problem_.empty()) return;
            read(*model, set.models.emplace_back());
        }
        if (!assets::is_aligned(*table.instances())) {
            problem_ = "instances at an odd place; expected a multiple of 8";
            return;
        }
        for (const disk::AnimatedInstance* i : *table.instances())
            set.instances.push_back(
                {.model = i->model(),
                 .position = {i->x(), i->y(), i->z()},
                 .world_from_model = {vec3(i->column_x()), vec3(i->column_y()), vec3(i->column_z())},
                 .clip = i->clip(),
                 .phase = i->phase()});
    }
    [[nodiscard]] const std::string& problem() const { return problem_; }

  private:
    bool takes(std::size_t bytes) {
        if (bytes <= left_) {
            left_ -= bytes;
            return true;
        }
        problem_ = "tables that hold more than the chunk; expected each once";
        left_ = 0;
        return false;
    }
    template <class T, class Element>
    void read(const flatbuffers::Vector<Element>& from, std::vector<T>& to) {
        const std::size_t bytes = from.size() * sizeof(Element);
        if (!takes(bytes)) return;
        if (bytes % sizeof(T) != 0) {
            problem_ = "an array of numbers that is no array of vectors; expected whole ones";
            return;
        }
        to.resize(bytes / sizeof(T));
        if (bytes > 0) std::memcpy(static_cast<void*>(to.data()), from.Data(), bytes);
    }
    std::string text(const flatbuffers::String& from) { return takes(from.size()) ? from.str() : std::string(); }

    void read(const disk::AnimatedModel& from, AnimatedModel& model) {
        model.name = text(*from.name());
        const disk::Skeleton& skeleton = *from.skeleton();
        for (const flatbuffers::String* name : *skeleton.names()) {
            if (!takes(4)) return;
            model.skeleton.names.push_back(text(*name));
        }
        read(*skeleton.parents(), model.skeleton.parents);
        read(*skeleton.translations(), model.skeleton.translations);
        read(*skeleton.rotations(), model.skeleton.rotations);
        read(*skeleton.scales(), model.skeleton.scales);
        for (const disk::Clip* clip : *from.clips()) {
            if (!takes(4)) return;
            read(*clip, model.clips.emplace_back());
        }
        read_parts(from, model.parts);
        for (const disk::Skin* skin : *from.skins()) {
            if (!takes(4)) return;
            Skin& out = model.skins.emplace_back();
            out.mesh = skin->mesh();
            out.influences = skin->influences();
            read(*skin->joints(), out.joints);
            read(*skin->joint_from_mesh(), out.joint_from_mesh);
            read(*skin->vertex_joints(), out.vertex_joints);
            read(*skin->vertex_weights(), out.vertex_weights);
        }
    }

    void read(const disk::Clip& from, Clip& clip) {
        clip.name = text(*from.name());
        clip.duration_s = from.duration_s();
        if (!takes(from.tracks()->size() * sizeof(disk::Track))) return;
        for (const disk::Track* t : *from.tracks())
            clip.tracks.push_back({.joint = t->joint(),
                                   .path = TrackPath(t->path()),
                                   .interpolation = Interpolation(t->interpolation()),
                                   .even = t->even() != 0,
                                   .first_time = t->first_time(),
                                   .key_count = t->key_count(),
                                   .first_value = t->first_value()});
        read(*from.times(), clip.times);
        read(*from.values(), clip.values);
    }

    void read_parts(const disk::AnimatedModel& from, std::vector<RigidPart>& parts) {
        std::vector<std::uint32_t> meshes, joints;
        std::vector<Mat4x3> transforms;
        read(*from.part_meshes(), meshes);
        read(*from.part_joints(), joints);
        read(*from.part_transforms(), transforms);
        if (joints.size() != meshes.size() || transforms.size() != meshes.size()) {
            problem_ = "parts whose arrays differ in length; expected a mesh, a joint and a transform each";
            return;
        }
        for (std::size_t i = 0; i < meshes.size(); ++i) parts.push_back({meshes[i], joints[i], transforms[i]});
    }

    std::size_t left_;
    std::string problem_;
};

}  // namespace

std::vector<std::uint8_t> animation_to_bytes(const AnimationSet& set) {
    FlatBufferBuilder builder;
    std::vector<Offset<disk::AnimatedModel>> models;
    for (const AnimatedModel& model : set.models) models.push_back(to_disk(builder, model));
    std::vector<disk::AnimatedInstance> instances;
    for (const AnimatedInstance& i : set.instances)
        instances.emplace_back(i.position.x, i.position.y, i.position.z, i.phase, axis(i.world_from_model[0]),
                               axis(i.world_from_model[1]), axis(i.world_from_model[2]), i.model, i.clip, 0u);
    const auto model_list = builder.CreateVector(models);
    const auto instance_list = builder.CreateVectorOfStructs(instances);
    disk::FinishAnimationBuffer(builder, disk::CreateAnimation(builder, model_list, instance_list));
    return {builder.GetBufferPointer(), builder.GetBufferPointer() + builder.GetSize()};
}

std::string animation_from_bytes(std::span<const std::uint8_t> bytes, AnimationSet& set) {
    flatbuffers::Verifier verifier(bytes.data(), bytes.size());
    if (!disk::VerifyAnimationBuffer(verifier)) return "malformed; expected a FlatBuffer of animation.fbs";
    Reader reader(bytes.size());
    reader.read(*disk::GetAnimation(bytes.data()), set);
    return reader.problem();
}

}  // namespace ff::scene
