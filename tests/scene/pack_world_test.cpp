#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <limits>
#include <string>
#include <vector>

#include "engine/core/jobs.h"
#include "engine/scene/load_world.h"
#include "engine/scene/save_world.h"
#include "tests/fuzz/pack_surgery.h"
#include "tests/fuzz/touch_world.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/worlds.h"

namespace ff::scene {
namespace {

using Bytes = std::vector<std::byte>;

/// A file that goes with its test.
class TempPack {
  public:
    [[nodiscard]] std::filesystem::path path() const { return folder_ / "w.ffpack"; }
    [[nodiscard]] Bytes bytes() const {
        std::ifstream in(path(), std::ios::binary);
        const std::string text{std::istreambuf_iterator<char>(in), {}};
        Bytes bytes(text.size());
        std::memcpy(bytes.data(), text.data(), text.size());
        return bytes;
    }

  private:
    test::TemporaryFolder folder_;
};

WorldInfo make_info() {
    WorldInfo info;
    info.name = "harbour";
    info.spawn_position = WorldPos(1, 2, 3);
    info.spawn_yaw = 0.5;
    info.source_bytes = 12345;
    info.dynamic_instances.push_back({0, WorldPos(10, 0, -4), test::turned_and_scaled(1.0, Vec3(2))});
    info.walks.push_back({"street", 60.0, 30.0, {{WorldPos(0, 1.7, 0), 10, -5, 1}, {WorldPos(1, 1.7, 0), 11, -5, 1}}});
    info.walks.push_back({"turn", 70.0, 30.0, {{WorldPos(0, 1.7, 0), 0, 0, 0}}});
    info.flocks = {{{.position = {5, 30, 5}, .first_instance = 0, .instance_count = 1}, 12, 40.0f}};
    info.loose_bodies = {{{.position = {10, 0, -4}, .yaw = 0.5, .first_instance = 0, .instance_count = 1}, 3.5f}};
    info.sounds.clips = {{.name = "hum", .rate_hz = 11025, .samples = {0, 5, -7, 32767, -32768}},
                         {.name = "tick", .rate_hz = 8000, .samples = {1}}};
    info.sounds.sources = {{.position = {1.0, 2.0, -3.0}, .clip = 1, .reference_m = 7.0f, .gain = 0.25f}};
    return info;
}

/// All kinds of arrays in few bytes: two masked soups, a texture, a panorama.
SceneData make_small_world(int triangles = 20) {
    SceneData data =
        test::make_triangle_soup({.triangles = triangles, .meshes = 2, .masked = true}, {.height_grid_size = 16});
    data.sky_panorama.assign(4 * 4 * 2, 0x3C00);
    data.environment.panorama_width = 4;
    data.environment.panorama_height = 2;
    data.environment.atmosphere = {2.5f, 0.9f};
    data.environment.weather = {0.25f, 0.5f, {3.0f, -4.0f}};
    data.lamps.push_back({.position = {1.0, 4.0, -2.0}, .color = Vec3(1.0f, 0.5f, 0.25f), .lumens = 800.0f});
    return data;
}

Bytes pack_of(const SceneData& data, const WorldInfo& info,
              assets::Compression compression = assets::Compression::zstd) {
    const TempPack pack;
    const auto size = write_world(pack.path(), data, info, compression);
    EXPECT_TRUE(size) << size.error().message;
    return pack.bytes();
}

Result<std::unique_ptr<World>> load_bytes(const Bytes& bytes) {
    FF_ASSIGN(const assets::PackReader reader, assets::PackReader::from_bytes("w.ffpack", bytes));
    return load_world(reader);
}

template <class T>
::testing::AssertionResult same_bytes(std::span<const T> a, std::span<const T> b) {
    if (a.size() != b.size()) return ::testing::AssertionFailure() << a.size() << " and " << b.size() << " elements";
    if (!a.empty() && std::memcmp(a.data(), b.data(), a.size_bytes()) != 0)
        return ::testing::AssertionFailure() << "contents differ";
    return ::testing::AssertionSuccess();
}

void expect_equal(const StaticScene& a, const StaticScene& b) {
    EXPECT_EQ(a.origin, b.origin);
    EXPECT_EQ(a.bounds.low, b.bounds.low);
    EXPECT_EQ(a.bounds.high, b.bounds.high);
    EXPECT_TRUE(same_bytes(a.positions, b.positions));
    EXPECT_TRUE(same_bytes(a.attributes, b.attributes));
    EXPECT_TRUE(same_bytes(a.indices, b.indices));
    EXPECT_TRUE(same_bytes(a.triangle_materials, b.triangle_materials));
    EXPECT_TRUE(same_bytes(a.prelit_colors, b.prelit_colors));
    EXPECT_TRUE(same_bytes(a.meshes, b.meshes));
    EXPECT_TRUE(same_bytes(a.cells, b.cells));
    EXPECT_TRUE(same_bytes(a.materials, b.materials));
    EXPECT_TRUE(same_bytes(a.texels, b.texels));
    EXPECT_TRUE(same_bytes(a.mesh_nodes, b.mesh_nodes));
    EXPECT_TRUE(same_bytes(a.mesh_leaves, b.mesh_leaves));
    EXPECT_TRUE(same_bytes(a.instance_nodes, b.instance_nodes));
    EXPECT_TRUE(same_bytes(a.height_grid.heights, b.height_grid.heights));
    EXPECT_EQ(a.height_grid.size, b.height_grid.size);
    EXPECT_EQ(a.height_grid.low_x, b.height_grid.low_x);
    EXPECT_EQ(a.height_grid.low_z, b.height_grid.low_z);
    EXPECT_EQ(a.height_grid.square_m, b.height_grid.square_m);
    EXPECT_EQ(a.height_grid.base_y, b.height_grid.base_y);
    EXPECT_TRUE(same_bytes(a.environment.panorama, b.environment.panorama));
    EXPECT_EQ(a.environment.panorama_width, b.environment.panorama_width);
    EXPECT_EQ(a.environment.to_sun, b.environment.to_sun);
    EXPECT_EQ(a.environment.ground_bounce, b.environment.ground_bounce);
    EXPECT_EQ(a.environment.fog_density_per_m, b.environment.fog_density_per_m);
    EXPECT_EQ(a.environment.atmosphere, b.environment.atmosphere);
    EXPECT_EQ(a.environment.weather, b.environment.weather);
    EXPECT_TRUE(std::equal(a.lamps.begin(), a.lamps.end(), b.lamps.begin(), b.lamps.end()));
    // With padding, so by field.
    ASSERT_EQ(a.instances.size(), b.instances.size());
    for (std::size_t i = 0; i < a.instances.size(); ++i) {
        EXPECT_EQ(a.instances[i].position, b.instances[i].position);
        EXPECT_EQ(a.instances[i].world_from_mesh, b.instances[i].world_from_mesh);
        EXPECT_EQ(a.instances[i].mesh, b.instances[i].mesh);
        EXPECT_EQ(a.instances[i].cell, b.instances[i].cell);
        EXPECT_EQ(a.instances[i].bounds.low, b.instances[i].bounds.low);
        EXPECT_EQ(a.instances[i].bounds.high, b.instances[i].bounds.high);
    }
    ASSERT_EQ(a.textures.size(), b.textures.size());
    for (std::size_t i = 0; i < a.textures.size(); ++i) {
        EXPECT_EQ(a.textures[i].width, b.textures[i].width);
        EXPECT_EQ(a.textures[i].height, b.textures[i].height);
        EXPECT_EQ(a.textures[i].level_count, b.textures[i].level_count);
        EXPECT_EQ(a.textures[i].wrap_u, b.textures[i].wrap_u);
        EXPECT_EQ(a.textures[i].wrap_v, b.textures[i].wrap_v);
        EXPECT_EQ(a.textures[i].first_texel, b.textures[i].first_texel);
    }
}

TEST(WorldPack, gives_back_every_array_of_every_kind_of_world) {
    for (const auto& make : std::vector<std::function<SceneData()>>{
             [] { return test::make_city(); }, [] { return test::make_terrain(); }, [] { return test::make_forest(); },
             [] { return test::make_triangle_soup({.triangles = 3000, .masked = true}); },
             [] { return test::make_single_triangle(Vec3(0), Vec3(1, 0, 0), Vec3(0, 1, 0)); },
             [] { return make_small_world(); }}) {
        const SceneData data = make();
        const Bytes bytes = pack_of(data, make_info());
        const auto world = load_bytes(bytes);
        ASSERT_TRUE(world) << world.error().message;
        expect_equal((*world)->scene(), data.view());
        test::touch_world(**world);
    }
}

TEST(WorldPack, of_an_empty_world_is_an_empty_world) {
    WorldInfo info = make_info();
    info.dynamic_instances.clear();
    info.flocks.clear();
    info.loose_bodies.clear();
    const Bytes bytes = pack_of(test::make_empty_world(), info);
    const auto world = load_bytes(bytes);
    ASSERT_TRUE(world) << world.error().message;
    EXPECT_EQ((*world)->statistics().triangles, 0u);
    test::touch_world(**world);
}

TEST(WorldPack, gives_back_what_goes_with_the_scene) {
    const WorldInfo info = make_info();
    const SceneData data = make_small_world();
    const Bytes bytes = pack_of(data, info);
    const auto world = load_bytes(bytes);
    ASSERT_TRUE(world) << world.error().message;
    const WorldInfo& loaded = (*world)->info();
    EXPECT_EQ(loaded.name, info.name);
    EXPECT_EQ(loaded.spawn_position, info.spawn_position);
    EXPECT_EQ(loaded.sounds, info.sounds);
    EXPECT_EQ(loaded.spawn_yaw, info.spawn_yaw);
    EXPECT_EQ(loaded.source_bytes, info.source_bytes);
    EXPECT_EQ(loaded.dynamic_instances, info.dynamic_instances);
    EXPECT_EQ(loaded.flocks, info.flocks);
    EXPECT_EQ(loaded.loose_bodies, info.loose_bodies);
    EXPECT_EQ(loaded.walks, info.walks);
    ASSERT_NE((*world)->find_walk("turn"), nullptr);
    EXPECT_EQ((*world)->find_walk("turn")->fov_deg, 70.0);
    EXPECT_EQ((*world)->find_walk("moon"), nullptr);
    const WorldStatistics& statistics = (*world)->statistics();
    EXPECT_EQ(statistics.triangles, data.triangle_materials.size());
    std::uint64_t drawn = data.meshes[0].triangle_count;  // the dynamic one
    for (const Instance& instance : data.instances) drawn += data.meshes[instance.mesh].triangle_count;
    EXPECT_EQ(statistics.instanced_triangles, drawn);
    EXPECT_EQ(statistics.pack_bytes, bytes.size());
}

TEST(World, made_from_arrays_is_the_same_as_from_a_pack) {
    const SceneData data = make_small_world();
    const World world(data, make_info());
    expect_equal(world.scene(), data.view());
    test::touch_world(world);
}

TEST(WorldPack, is_the_same_for_one_and_two_workers_written_and_read) {
    const SceneData data = test::make_city({.cells = 4, .subdivisions = 4});
    Bytes bytes[2];
    for (const int workers : {1, 2}) {
        const WorkerLimit limit(workers);
        bytes[workers - 1] = pack_of(data, make_info());
    }
    EXPECT_TRUE(bytes[0] == bytes[1]);
    for (const int workers : {1, 2}) {
        const WorkerLimit limit(workers);
        const auto world = load_bytes(bytes[0]);
        ASSERT_TRUE(world) << world.error().message;
        expect_equal((*world)->scene(), data.view());
    }
}

TEST(WorldPack, cut_at_any_byte_or_with_any_byte_flipped_is_refused_with_file_and_offset) {
    const Bytes whole = pack_of(make_small_world(4), make_info());
    const auto refused = [](const Bytes& bytes) {
        const auto world = load_bytes(bytes);
        return !world && world.error().kind == ErrorKind::bad_input && world.error().message.starts_with("w.ffpack@") &&
               world.error().message.find("expected") != std::string::npos;
    };
    for (std::size_t size = 0; size < whole.size(); ++size)
        ASSERT_TRUE(refused(Bytes(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size)))) << size;
    Bytes bytes = whole;
    for (std::size_t i = 0; i < bytes.size(); ++i) {
        if (i >= 8 && i < 12) continue;  // the version has a message of its own, see tests/assets
        bytes[i] ^= std::byte{0x10};
        ASSERT_TRUE(refused(bytes)) << i;
        bytes[i] ^= std::byte{0x10};
    }
    bytes.push_back(std::byte{0});
    EXPECT_TRUE(refused(bytes));
}

TEST(WorldPack, whose_hashes_are_right_but_whose_words_are_wrong_is_refused_or_harmless) {
    // Every 4-byte word of every array in turn becomes something evil. What loads all the same must be safe to walk.
    const Bytes whole = pack_of(make_small_world(), make_info(), assets::Compression::none);
    const auto reader = assets::PackReader::from_bytes("w.ffpack", whole);
    ASSERT_TRUE(reader);
    const std::size_t texels = reader->find("texels")->offset;  // any texel is a good one: the first few will do
    const std::size_t texels_end = texels + reader->find("texels")->raw_bytes();
    const WorkerLimit one(1);
    std::size_t loaded = 0, refused = 0;
    for (std::size_t at = 64; at + 4 <= whole.size(); at += at > texels + 64 && at < texels_end - 64 ? 512 : 4)
        for (const std::uint32_t evil : {0xFFFFFFFFu, 0u, 0x7FC00000u, 0x80000000u, 0x7F7FFFFFu, 1u, 0x80000001u}) {
            Bytes bytes = whole;
            std::memcpy(bytes.data() + at, &evil, sizeof evil);
            test::fix_hashes(bytes);
            const auto world = load_bytes(bytes);
            if (world) {
                test::touch_world(**world);
                ++loaded;
            } else {
                ASSERT_EQ(world.error().kind, ErrorKind::bad_input) << world.error().message;
                ++refused;
            }
        }
    EXPECT_GT(loaded, 1000u);
    EXPECT_GT(refused, 1000u);
}

/// What is said about a world that breaks one promise.
std::string message_for(const std::function<void(SceneData&, WorldInfo&)>& spoil) {
    SceneData data = make_small_world();
    WorldInfo info = make_info();
    spoil(data, info);
    const TempPack pack;
    const auto size = write_world(pack.path(), data, info);
    EXPECT_FALSE(std::filesystem::exists(pack.path()));
    return size ? "was written" : size.error().message;
}

TEST(WorldPack, is_not_written_where_the_cooker_broke_a_promise) {
    const auto expect = [](const std::string& message, const std::string& part) {
        EXPECT_NE(message.find(part), std::string::npos) << message;
    };
    constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
    expect(message_for([](SceneData& d, WorldInfo&) { d.indices[4] = 1u << 20; }), "indices[4]: vertex 1048576");
    expect(message_for([](SceneData& d, WorldInfo&) { d.positions[3].y = kNan; }), "positions[3]: ");
    expect(message_for([](SceneData& d, WorldInfo&) { d.attributes[2].uv.x = kNan; }), "attributes[2]: ");
    expect(message_for([](SceneData& d, WorldInfo&) { d.triangle_materials[1] = 999; }), "triangle_materials[1]: ");
    expect(message_for([](SceneData& d, WorldInfo&) { d.materials[0].base_color_texture = 77; }), "materials[0]: ");
    expect(message_for([](SceneData& d, WorldInfo&) { d.textures[0].width = 3; }), "textures[0]: 3 x ");
    expect(message_for([](SceneData& d, WorldInfo&) { d.texels.push_back(0); }), "texels[");
    expect(message_for([](SceneData& d, WorldInfo&) { d.meshes[1].first_vertex += 1; }), "meshes[1]: ");
    expect(message_for([](SceneData& d, WorldInfo&) { d.instances[0].world_from_mesh = Mat3(0.0f); }),
           "instances[0]: ");
    expect(message_for([](SceneData& d, WorldInfo&) { d.cells[0].instance_count += 1; }), "cells[1]: ");
    expect(message_for([](SceneData& d, WorldInfo&) { d.mesh_nodes[0].child[0] = 0; }), "mesh_nodes[0]: lane 0");
    expect(message_for([](SceneData& d, WorldInfo&) { d.mesh_leaves[0].x[0] += 1; }), "mesh_leaves[0]: ");
    expect(message_for([](SceneData& d, WorldInfo&) { d.instance_nodes[0].child[0] = kBvhLeafBit | 500; }),
           "instance_nodes[0]: lane 0");
    expect(message_for([](SceneData& d, WorldInfo&) { d.heights[5] = kNan; }), "heights[5]: ");
    expect(message_for([](SceneData& d, WorldInfo&) { d.environment.to_sun = Vec3(0); }), "environment[0]: ");
    expect(message_for([](SceneData& d, WorldInfo&) { d.environment.atmosphere.turbidity = 0.5f; }),
           "environment[0]: ");
    expect(message_for([](SceneData& d, WorldInfo&) { d.environment.weather.snow = 2.0f; }), "environment[0]: ");
    expect(message_for([](SceneData& d, WorldInfo&) { d.lamps[0].radius_m = 0.0f; }), "lamps[0]: ");
    expect(message_for([](SceneData& d, WorldInfo&) { d.sky_panorama.pop_back(); }), "sky_panorama[");
    expect(message_for([](SceneData&, WorldInfo& i) { i.dynamic_instances[0].mesh = 9; }), "dynamic_instances[0]: ");
    expect(message_for([](SceneData&, WorldInfo& i) { i.flocks[0].birds = kMostBirds + 1; }), "flocks[0]: 257 birds");
    expect(
        message_for([](SceneData&, WorldInfo& i) { i.flocks[0].radius_m = std::numeric_limits<float>::quiet_NaN(); }),
        "flocks[0]: 12 birds within nan m");
    expect(message_for([](SceneData&, WorldInfo& i) { i.flocks[0].model.instance_count = 2; }), "flocks[0]: ");
    expect(message_for([](SceneData&, WorldInfo& i) { i.loose_bodies[0].mass_kg = 0.0f; }), "loose_bodies[0]: 0 kg");
    expect(message_for([](SceneData&, WorldInfo& i) { i.loose_bodies[0].model.animated_count = 1; }),
           "loose_bodies[0]: ");
    expect(message_for([](SceneData&, WorldInfo& i) { i.sounds.sources[0].clip = 2; }), "sound_sources[0]: ");
    expect(message_for([](SceneData&, WorldInfo& i) { i.sounds.clips[1].rate_hz = 0; }), "sound_clips[1]: ");
    expect(message_for([](SceneData&, WorldInfo& i) { i.sounds.clips[1].name = "hum"; }), "two are called");
    expect(message_for([](SceneData&, WorldInfo& i) { i.walks[1].fov_deg = 0; }), "walks[1]: fov_deg: 0");
    expect(message_for([](SceneData&, WorldInfo& i) { i.walks[1].name = "street"; }), "two walks are called");
}

TEST(WorldPack, that_is_a_pack_of_something_else_is_refused) {
    const TempPack pack;
    auto writer = assets::PackWriter::create(pack.path());
    ASSERT_TRUE(writer);
    const std::vector<float> numbers(10);
    ASSERT_TRUE(writer->add("numbers", std::span<const float>(numbers)));
    ASSERT_TRUE(writer->finish());
    const auto world = load_world(pack.path());
    ASSERT_FALSE(world);
    EXPECT_EQ(world.error().kind, ErrorKind::bad_input);
    EXPECT_NE(world.error().message.find("no chunk world"), std::string::npos) << world.error().message;
}

}  // namespace
}  // namespace ff::scene
