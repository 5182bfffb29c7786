#include "engine/scene/load_world.h"

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <utility>
#include <vector>

#include "engine/assets/aligned_vector.h"
#include "engine/core/jobs.h"
#include "engine/scene/animation_chunk.h"
#include "engine/scene/check_animation.h"
#include "engine/scene/check_world.h"
#include "engine/scene/disk_records.h"
#include "engine/scene/leaf_blocks.h"

namespace ff::scene {
namespace {

constexpr std::uint64_t kMaxTableBytes = std::uint64_t(1) << 30;  // FlatBuffers end at 2 GiB

/// Cuts one piece of memory into arrays, each at a cache line, with a line to spare behind it: SIMD code may read a
/// little past the end. First everything is asked for, then allocated, then handed out.
class ArrayPlan {
  public:
    template <class T>
    void ask(std::span<T>& array, std::uint64_t count) {
        static_assert(alignof(T) <= kLine);
        pieces_.push_back({bytes_, [&array, count](std::byte* at) {
                               array = {reinterpret_cast<T*>(at), static_cast<std::size_t>(count)};
                           }});
        bytes_ += (count * sizeof(T) + kLine - 1) / kLine * kLine + kLine;
    }

    Result<assets::PageBuffer> allocate() {
        FF_ASSIGN(assets::PageBuffer buffer, assets::PageBuffer::allocate(bytes_));
        for (const Piece& piece : pieces_) piece.hand_out(buffer.bytes().data() + piece.offset);
        return buffer;
    }

  private:
    static constexpr std::uint64_t kLine = 64;
    struct Piece {
        std::uint64_t offset;
        std::function<void(std::byte*)> hand_out;
    };
    std::vector<Piece> pieces_;
    std::uint64_t bytes_ = 0;
};

/// The arrays while they are filled.
struct Arrays {
    std::span<Vec3> positions;
    std::span<VertexAttributes> attributes;
    std::span<std::uint32_t> indices;
    std::span<std::uint16_t> triangle_materials;
    std::span<std::uint32_t> prelit_colors;
    std::span<Mesh> meshes;
    std::span<Instance> instances;
    std::span<Cell> cells;
    std::span<Material> materials;
    std::span<Texture> textures;
    std::span<std::uint32_t> texels;
    std::span<BvhNode> mesh_nodes;
    std::span<BvhLeaf> mesh_leaves;
    std::span<BvhNode> instance_nodes;
    std::span<float> heights;
    std::span<std::uint16_t> sky_panorama;
};

/// What is read and then turned into something else.
struct Records {
    std::span<std::uint8_t> world;
    std::span<disk::Mesh> meshes;
    std::span<disk::Instance> instances;
    std::span<disk::Cell> cells;
    std::span<disk::Material> materials;
    std::span<disk::Texture> textures;
    std::span<std::uint8_t> leaf_sizes;
};

/// An array without the room behind it.
template <class T>
std::span<const T> stored(std::span<T> array, std::uint64_t room) {
    return array.first(array.size() - std::size_t(room));
}

template <class T, class Record>
void convert(std::span<const Record> records, std::span<T> out) {
    parallel_ranges(records.size(), 4096, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) out[i] = from_disk(records[i]);
    });
}

}  // namespace

class WorldLoader {
  public:
    explicit WorldLoader(const assets::PackReader& pack) : pack_(pack) {}

    Result<std::unique_ptr<World>> load() {
        FF_TRY(read_animation());
        FF_TRY(plan_arrays());
        FF_ASSIGN(world_->storage_, arrays_plan_.allocate());
        FF_ASSIGN(const assets::PageBuffer record_memory, records_plan_.allocate());
        FF_TRY(read_chunks());
        convert_records();
        FF_TRY(read_world_table());
        if (const auto problem = find_world_problem(world_->scene_, world_->info_, world_->scene_.mesh_leaves.size()))
            return error_of(*problem);
        if (const auto problem = make_leaf_blocks(world_->scene_, records_.leaf_sizes,
                                                  arrays_.mesh_leaves.first(world_->scene_.mesh_leaves.size())))
            return error_of(*problem);
        world_->count();
        make_pose_room();
        world_->statistics_.pack_bytes = pack_.file_bytes();
        world_->statistics_.pack_hash = pack_.content_hash();
        return std::move(world_);
    }

  private:
    /// Each chunk that a world has, and where it goes; more or fewer chunks are an error.
    Status plan_arrays() {
        FF_TRY(plan("world", records_plan_, records_.world));
        FF_TRY(plan("meshes", records_plan_, records_.meshes));
        FF_TRY(plan("instances", records_plan_, records_.instances));
        FF_TRY(plan("cells", records_plan_, records_.cells));
        FF_TRY(plan("materials", records_plan_, records_.materials));
        FF_TRY(plan("textures", records_plan_, records_.textures));
        FF_TRY(plan("mesh_leaves", records_plan_, records_.leaf_sizes));
        FF_TRY(plan("positions", arrays_plan_, arrays_.positions, pose_room_.vertices));
        FF_TRY(plan("attributes", arrays_plan_, arrays_.attributes, pose_room_.vertices));
        FF_TRY(plan("indices", arrays_plan_, arrays_.indices));
        FF_TRY(plan("triangle_materials", arrays_plan_, arrays_.triangle_materials));
        FF_TRY(plan("prelit_colors", arrays_plan_, arrays_.prelit_colors));
        FF_TRY(plan("texels", arrays_plan_, arrays_.texels));
        FF_TRY(plan("mesh_nodes", arrays_plan_, arrays_.mesh_nodes, pose_room_.nodes));
        FF_TRY(plan("instance_nodes", arrays_plan_, arrays_.instance_nodes));
        FF_TRY(plan("heights", arrays_plan_, arrays_.heights));
        FF_TRY(plan("sky_panorama", arrays_plan_, arrays_.sky_panorama));
        for (const assets::PackReader::Chunk& chunk : pack_.chunks())
            if (std::find(known_.begin(), known_.end(), chunk.name) == known_.end())
                return pack_.error_in(chunk, "unknown to a world; expected one of its arrays");
        arrays_plan_.ask(arrays_.meshes, pack_.find("meshes")->element_count + pose_room_.meshes);
        arrays_plan_.ask(arrays_.instances, pack_.find("instances")->element_count);
        arrays_plan_.ask(arrays_.cells, pack_.find("cells")->element_count);
        arrays_plan_.ask(arrays_.materials, pack_.find("materials")->element_count);
        arrays_plan_.ask(arrays_.textures, pack_.find("textures")->element_count);
        arrays_plan_.ask(arrays_.mesh_leaves, pack_.find("mesh_leaves")->element_count + pose_room_.leaves);
        return {};
    }

    template <class T>
    Status plan(std::string_view name, ArrayPlan& plan, std::span<T>& array, std::uint64_t room = 0) {
        FF_ASSIGN(const std::uint64_t count, elements_of(name, sizeof(T)));
        known_.push_back(name);
        plan.ask(array, count + room);
        fill_.push_back([&array, name, count] {
            return assets::PackReader::Target{name, std::as_writable_bytes(array.first(std::size_t(count)))};
        });
        return {};
    }

    Result<std::uint64_t> elements_of(std::string_view name, std::size_t element_bytes) const {
        const assets::PackReader::Chunk* chunk = pack_.find(name);
        if (!chunk)
            return bad_input(fmt::format("{}: no chunk {}; expected a world; cook it again", pack_.file_name(), name));
        if (chunk->element_bytes != element_bytes)
            return pack_.error_in(
                *chunk, fmt::format("elements of {} bytes; expected {}", chunk->element_bytes, element_bytes));
        return chunk->element_count;
    }

    /// What moves of itself, where the pack has any, ahead of everything else: it says how much room poses take.
    Status read_animation() {
        const assets::PackReader::Chunk* chunk = pack_.find("animation");
        if (!chunk) return {};
        known_.push_back("animation");
        std::span<std::uint8_t> bytes;
        std::span<disk::Mesh> records;
        ArrayPlan plan;
        FF_ASSIGN(const std::uint64_t byte_count, elements_of("animation", 1));
        FF_ASSIGN(const std::uint64_t mesh_count, elements_of("meshes", sizeof(disk::Mesh)));
        if (byte_count > kMaxTableBytes)
            return pack_.error_in(*chunk, fmt::format("{} bytes; expected at most {}", byte_count, kMaxTableBytes));
        plan.ask(bytes, byte_count);
        plan.ask(records, mesh_count);
        FF_ASSIGN(const assets::PageBuffer memory, plan.allocate());
        const assets::PackReader::Target targets[] = {{"animation", std::as_writable_bytes(bytes)},
                                                      {"meshes", std::as_writable_bytes(records)}};
        FF_TRY(pack_.read(targets));
        AnimationSet& set = world_->info_.animation;
        if (std::string problem = animation_from_bytes(bytes, set); !problem.empty())
            return pack_.error_in(*chunk, problem);
        std::vector<Mesh> meshes(records.size());
        convert<Mesh, disk::Mesh>(records, meshes);
        if (const auto problem = find_animation_problem(set, meshes)) return error_of(*problem);
        pose_room_ = pose_room_size(set, meshes);
        return check_pose_room();
    }

    /// The meshes themselves are checked only when all is read: until then no more room is given than a mesh could
    /// fill that has all of the pack's vertices and a few copies.
    Status check_pose_room() const {
        for (const auto& [name, room] :
             {std::pair("positions", pose_room_.vertices), std::pair("mesh_nodes", pose_room_.nodes),
              std::pair("mesh_leaves", pose_room_.leaves)}) {
            const assets::PackReader::Chunk* chunk = pack_.find(name);
            if (chunk && (room > kMostPoses * chunk->element_count || chunk->element_count + room > 0xFFFFFFFFu))
                return pack_.error_in(*chunk, fmt::format("skins of more than its {} elements; expected meshes inside",
                                                          chunk->element_count));
        }
        return {};
    }

    /// Everything has been checked and counted: the scene grows by the poses.
    void make_pose_room() {
        StaticScene& scene = world_->scene_;
        const PoseRoomSize used{scene.meshes.size(), scene.positions.size(), scene.mesh_nodes.size(),
                                scene.mesh_leaves.size()};
        world_->pose_room_ = {.slots = {},
                              .meshes = arrays_.meshes,
                              .positions = arrays_.positions,
                              .attributes = arrays_.attributes,
                              .nodes = arrays_.mesh_nodes,
                              .leaves = arrays_.mesh_leaves};
        fill_pose_room(world_->info_.animation, used, world_->pose_room_);
        scene.meshes = arrays_.meshes;
        scene.posed_mesh_count = std::uint32_t(pose_room_.meshes);
        scene.positions = arrays_.positions;
        scene.attributes = arrays_.attributes;
        scene.mesh_nodes = arrays_.mesh_nodes;
        scene.mesh_leaves = arrays_.mesh_leaves;
    }

    Status read_chunks() {
        std::vector<assets::PackReader::Target> targets;
        for (const auto& target : fill_) targets.push_back(target());
        return pack_.read(targets);
    }

    void convert_records() {
        convert<Mesh, disk::Mesh>(records_.meshes, arrays_.meshes);
        convert<Instance, disk::Instance>(records_.instances, arrays_.instances);
        convert<Cell, disk::Cell>(records_.cells, arrays_.cells);
        convert<Material, disk::Material>(records_.materials, arrays_.materials);
        convert<Texture, disk::Texture>(records_.textures, arrays_.textures);
    }

    Status read_world_table() {
        const assets::PackReader::Chunk& chunk = *pack_.find("world");
        if (records_.world.size() > kMaxTableBytes)
            return pack_.error_in(chunk,
                                  fmt::format("{} bytes; expected at most {}", records_.world.size(), kMaxTableBytes));
        flatbuffers::Verifier verifier(records_.world.data(), records_.world.size());
        if (!disk::VerifyWorldBuffer(verifier))
            return pack_.error_in(chunk, "malformed; expected a FlatBuffer of world.fbs");
        const disk::World& table = *disk::GetWorld(records_.world.data());

        StaticScene& scene = world_->scene_;
        scene = {.origin = from_disk(*table.origin()),
                 .bounds = from_disk(*table.bounds()),
                 .positions = stored(arrays_.positions, pose_room_.vertices),
                 .attributes = stored(arrays_.attributes, pose_room_.vertices),
                 .indices = arrays_.indices,
                 .triangle_materials = arrays_.triangle_materials,
                 .prelit_colors = arrays_.prelit_colors,
                 .meshes = stored(arrays_.meshes, pose_room_.meshes),
                 .instances = arrays_.instances,
                 .cells = arrays_.cells,
                 .materials = arrays_.materials,
                 .textures = arrays_.textures,
                 .texels = arrays_.texels,
                 .mesh_nodes = stored(arrays_.mesh_nodes, pose_room_.nodes),
                 .mesh_leaves = stored(arrays_.mesh_leaves, pose_room_.leaves),
                 .instance_nodes = arrays_.instance_nodes,
                 .height_grid = from_disk(*table.height_grid()),
                 .environment = from_disk(*table.environment())};
        scene.height_grid.heights = arrays_.heights;
        scene.environment.panorama = arrays_.sky_panorama;
        scene.environment.sun_shadows = table.sun_shadows();
        scene.environment.atmosphere = {table.atmosphere_turbidity(), table.atmosphere_brightness()};

        scene.environment.weather = {table.rain(), table.snow(), {table.wind_x_m_s(), table.wind_z_m_s()}};
        if (table.lamps() != nullptr) {
            if (!assets::is_aligned(*table.lamps()))
                return pack_.error_in(chunk, "lamps at an odd place; expected a multiple of 8");
            for (const disk::Lamp* lamp : *table.lamps()) world_->lamps_.push_back(from_disk(*lamp));
            scene.lamps = world_->lamps_;
        }

        WorldInfo& info = world_->info_;
        info.name = table.name()->str();
        info.spawn_position = from_disk(*table.spawn_position());
        info.spawn_yaw = table.spawn_yaw();
        info.source_bytes = table.source_bytes();
        if (!assets::is_aligned(*table.dynamic_instances()))
            return pack_.error_in(chunk, "dynamic instances at an odd place; expected a multiple of 8");
        for (const disk::DynamicInstance* instance : *table.dynamic_instances())
            info.dynamic_instances.push_back(from_disk(*instance));
        if (table.places() != nullptr) {
            std::uint64_t name_bytes = 0;
            for (const disk::NamedPlace* stored : *table.places()) {
                name_bytes += stored->name()->size() + sizeof(NamedPlace);
                if (name_bytes > records_.world.size() * sizeof(NamedPlace))
                    return pack_.error_in(chunk, "places of more bytes than the table has room for");
                info.places.push_back({{.position = from_disk(*stored->position()),
                                        .yaw = stored->yaw(),
                                        .first_instance = stored->first_instance(),
                                        .instance_count = stored->instance_count(),
                                        .first_animated = stored->first_animated(),
                                        .animated_count = stored->animated_count()},
                                       stored->name()->str()});
            }
        }
        if (table.sound_clips() != nullptr) {
            std::uint64_t clip_bytes = 0;
            for (const disk::SoundClip* stored : *table.sound_clips()) {
                clip_bytes += stored->name()->size() + 2 * std::uint64_t(stored->samples()->size());
                if (clip_bytes > records_.world.size())
                    return pack_.error_in(chunk, "sounds of more bytes than the table has");
                info.sounds.clips.push_back({.name = stored->name()->str(),
                                             .rate_hz = stored->rate_hz(),
                                             .samples = {stored->samples()->begin(), stored->samples()->end()}});
            }
        }
        if (table.sound_sources() != nullptr) {
            if (!assets::is_aligned(*table.sound_sources()))
                return pack_.error_in(chunk, "sound sources at an odd place; expected a multiple of 8");
            for (const disk::SoundSource* source : *table.sound_sources())
                info.sounds.sources.push_back(from_disk(*source));
        }
        if (table.flocks() != nullptr) {
            if (!assets::is_aligned(*table.flocks()))
                return pack_.error_in(chunk, "flocks at an odd place; expected a multiple of 8");
            for (const disk::Flock* flock : *table.flocks()) info.flocks.push_back(from_disk(*flock));
        }
        if (table.loose_bodies() != nullptr) {
            if (!assets::is_aligned(*table.loose_bodies()))
                return pack_.error_in(chunk, "loose bodies at an odd place; expected a multiple of 8");
            for (const disk::LooseBody* body : *table.loose_bodies()) info.loose_bodies.push_back(from_disk(*body));
        }
        // Several entries of a FlatBuffer may point to one table: what it holds in all is held against its size.
        std::uint64_t bytes = 0;
        for (const disk::Walk* stored : *table.walks()) {
            if (!assets::is_aligned(*stored->frames()))
                return pack_.error_in(chunk, "a walk's frames at an odd place; expected a multiple of 8");
            bytes += stored->name()->size() + stored->frames()->size() * sizeof(disk::WalkFrame);
            if (bytes > records_.world.size())
                return pack_.error_in(chunk, fmt::format("walks of more than {} bytes; expected at most the table's {}",
                                                         bytes, records_.world.size()));
            Walk walk{.name = stored->name()->str(),
                      .fov_deg = stored->fov_deg(),
                      .rate_hz = stored->rate_hz(),
                      .frames = {}};
            walk.frames.reserve(stored->frames()->size());
            for (const disk::WalkFrame* frame : *stored->frames()) walk.frames.push_back(from_disk(*frame));
            info.walks.push_back(std::move(walk));
        }
        return {};
    }

    Error error_of(const WorldProblem& problem) const {
        const assets::PackReader::Chunk* chunk = pack_.find(problem.array);
        return pack_.error_in(chunk ? *chunk : *pack_.find("world"),
                              fmt::format("{}[{}]: {}", problem.array, problem.element, problem.what));
    }

    const assets::PackReader& pack_;
    std::unique_ptr<World> world_{new World};
    ArrayPlan arrays_plan_, records_plan_;
    Arrays arrays_;
    Records records_;
    PoseRoomSize pose_room_;
    std::vector<std::string_view> known_;
    std::vector<std::function<assets::PackReader::Target()>> fill_;
};

Result<std::unique_ptr<World>> load_world(const assets::PackReader& reader) {
    return WorldLoader(reader).load();
}

Result<std::unique_ptr<World>> load_world(const std::filesystem::path& path) {
    FF_ASSIGN(const assets::PackReader reader, assets::PackReader::open(path));
    return load_world(reader);
}

}  // namespace ff::scene
