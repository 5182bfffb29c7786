// Makes the fuzzers' seeds: fuzz_seeds FOLDER. Small worlds, their blocks stored as they are so that a changed byte is
// a changed number, and one compressed; walks as documented.

#include <fmt/core.h>

#include <filesystem>
#include <string>

#include "engine/core/write_file.h"
#include "engine/scene/save_world.h"
#include "tests/support/animated_worlds.h"
#include "tests/support/worlds.h"

namespace {

using namespace ff;

scene::WorldInfo seed_info(bool with_dynamic) {
    scene::WorldInfo info;
    info.name = "seed";
    if (with_dynamic) info.dynamic_instances.push_back({0, WorldPos(1), Mat3(1.0f)});
    info.walks.push_back({"turn", 60.0, 30.0, {{WorldPos(0, 1.7, 0), 0, 0, 0}}});
    return info;
}

/// A texture of 4 x 4 with a masked material, which every second triangle of the soup gets.
scene::SceneData textured_soup() {
    scene::SceneData data;
    data.materials.push_back(test::plain_material());
    test::add_leaf_material(data, 4);
    scene::MeshSource mesh;
    test::Random random(3);
    for (int i = 0; i < 12; ++i)
        test::append_triangle(mesh, random.in_box(Vec3(-5), Vec3(5)), random.in_box(Vec3(-5), Vec3(5)),
                              random.in_box(Vec3(-5), Vec3(5)), std::uint16_t(i % 2));
    const std::uint32_t id = data.add_mesh(scene::prepare_mesh(std::move(mesh), data.materials));
    data.add_instance(id, WorldPos(0), Mat3(1.0f), 0);
    data.add_instance(id, WorldPos(20, 0, 0), Mat3(2.0f), 1);
    data.sky_panorama.assign(4 * 2 * 1, 0x3800);
    data.environment.panorama_width = 2;
    data.environment.panorama_height = 1;
    data.finish(16);
    return data;
}

int report(const Error& error) {
    fmt::print(stderr, "{}\n", error.message);
    return 1;
}

int make_seeds(const std::filesystem::path& folder) {
    std::filesystem::create_directories(folder / "pack");
    std::filesystem::create_directories(folder / "walk");
    struct Seed {
        const char* name;
        scene::SceneData data;
        assets::Compression compression;
    };
    const test::WorldSettings small{.height_grid_size = 16};
    const Seed seeds[] = {
        {"textured", textured_soup(), assets::Compression::none},
        {"compressed", textured_soup(), assets::Compression::zstd},
        {"soup", test::make_triangle_soup({.triangles = 40, .meshes = 3}, small), assets::Compression::none},
        {"triangle", test::make_single_triangle(Vec3(0), Vec3(1, 0, 0), Vec3(0, 1, 0), small),
         assets::Compression::none},
        {"empty", test::make_empty_world(), assets::Compression::none},
    };
    for (const Seed& seed : seeds) {
        const auto written = scene::write_world(folder / "pack" / seed.name, seed.data,
                                                seed_info(!seed.data.meshes.empty()), seed.compression);
        if (!written) return report(written.error());
    }
    const test::AnimatedSource animated =
        test::make_animated_source({.worms = 2, .carts = 1, .worm = {.joints = 3, .rings = 3, .sides = 4}});
    for (const auto& [name, compression] : {std::pair("animated", assets::Compression::none),
                                            std::pair("animated_compressed", assets::Compression::zstd)}) {
        const auto written = scene::write_world(folder / "pack" / name, animated.scene, animated.info, compression);
        if (!written) return report(written.error());
    }
    const scene::Walk walk{.name = "w",
                           .frames = {{WorldPos(1, 2, 3), 10, -5, 0.5}, {WorldPos(-1e5, 2, 3e-7), 0, 0, 0}}};
    if (const Status status = write_file_whole(folder / "walk" / "two_frames", scene::walk_to_json(walk)); !status)
        return report(status.error());
    if (const Status status =
            write_file_whole(folder / "walk" / "unknown_key",
                             std::string_view("{\"format\": 1, \"fov\": 60, \"frames\": [{\"p\": []}]}"));
        !status)
        return report(status.error());
    return 0;
}

}  // namespace

int main(int argc, char** argv) {
    if (argc != 2) {
        fmt::print(stderr, "usage: fuzz_seeds FOLDER\n");
        return 2;
    }
    return make_seeds(argv[1]);
}
