// Writing and opening a pack of many triangles: seconds and MB/s of each step.
//   bench_pack [--triangles N] [--file PATH] [--keep]

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "engine/assets/pack_reader.h"
#include "engine/core/jobs.h"
#include "engine/core/stopwatch.h"
#include "engine/scene/check_world.h"
#include "engine/scene/leaf_blocks.h"
#include "engine/scene/load_world.h"
#include "engine/scene/save_world.h"
#include "tests/bench/bench_world.h"

namespace {

using namespace ff;

/// Cells of hilly ground with enough quads for `triangles` in all: each a prepared mesh of its own.
scene::SceneData make_ground(std::uint64_t triangles) {
    constexpr int kQuads = 256;
    const int cells = std::max(1, int(std::lround(std::sqrt(double(triangles) / (2.0 * kQuads * kQuads)))));
    scene::SceneData data;
    data.materials.emplace_back();
    std::vector<std::uint32_t> texels(1024 * 1024);
    for (std::size_t i = 0; i < texels.size(); ++i) texels[i] = 0xFF000000u | std::uint32_t(i * 2654435761u >> 8);
    data.materials[0].base_color_texture =
        data.add_texture(texels, 1024, 1024, scene::Wrap::repeat, scene::Wrap::repeat);
    for (int cell = 0; cell < cells * cells; ++cell) {
        const double x0 = 512.0 * (cell % cells - cells / 2), z0 = 512.0 * (cell / cells - cells / 2);
        scene::MeshSource mesh;
        for (int j = 0; j <= kQuads; ++j)
            for (int i = 0; i <= kQuads; ++i) {
                const float x = 512.0f * float(i) / kQuads, z = 512.0f * float(j) / kQuads;
                const float wx = float(x0) + x, wz = float(z0) + z;
                const float y = bench::town_height(wx, wz) + 0.3f * std::sin(wx * 1.7f) * std::sin(wz * 2.3f);
                mesh.positions.push_back({x, y, z});
                scene::VertexAttributes a{};
                scene::encode_normal(Vec3(std::sin(wx * 0.3f) * 0.2f, 0.95f, std::sin(wz * 0.2f) * 0.2f), a.normal_oct);
                a.uv = Vec2(x, z) / 12.0f;
                a.color = 0xFFFFFFFFu;
                mesh.attributes.push_back(a);
            }
        for (std::uint32_t j = 0; j < kQuads; ++j)
            for (std::uint32_t i = 0; i < kQuads; ++i) {
                const std::uint32_t a = j * (kQuads + 1) + i, b = a + kQuads + 1;
                for (const std::uint32_t v : {a, b, a + 1, a + 1, b, b + 1}) mesh.indices.push_back(v);
                mesh.triangle_materials.insert(mesh.triangle_materials.end(), 2, std::uint16_t(0));
            }
        const std::uint32_t id = data.add_mesh(scene::prepare_mesh(std::move(mesh), data.materials));
        data.add_instance(id, WorldPos(x0, 0, z0), Mat3(1.0f), std::uint32_t(cell));
    }
    data.finish(1024);
    return data;
}

/// Wall time and the processor time of all threads: on a busy machine only the second says what the work costs.
class StepTimer {
  public:
    void restart() {
        watch_.restart();
        cpu_start_ = std::clock();
    }
    void print(std::string_view name, std::uint64_t bytes) const {
        const double wall = watch_.seconds(), cpu = double(std::clock() - cpu_start_) / CLOCKS_PER_SEC;
        fmt::print("{:<36} {:7.3f} s wall {:7.3f} s cpu {:7.0f} MB/s wall {:7.0f} MB/s a core\n", name, wall, cpu,
                   double(bytes) / wall * 1e-6, double(bytes) / cpu * 1e-6);
    }

  private:
    Stopwatch watch_;
    std::clock_t cpu_start_ = std::clock();
};

int fail(const Error& error) {
    fmt::print(stderr, "{}\n", error.message);
    return 1;
}

int run(std::uint64_t triangles, const std::filesystem::path& path) {
    StepTimer watch;
    const Stopwatch making;
    std::uint64_t raw = 0;
    {
        const scene::SceneData data = make_ground(triangles);
        fmt::print("{} triangles made in {:.1f} s, {} workers\n", data.triangle_materials.size(), making.seconds(),
                   worker_count());
        const scene::StaticScene view = data.view();
        raw = view.positions.size_bytes() + view.attributes.size_bytes() + view.indices.size_bytes() +
              view.triangle_materials.size_bytes() + view.prelit_colors.size_bytes() + view.texels.size_bytes() +
              view.mesh_nodes.size_bytes() + view.mesh_leaves.size_bytes() + view.height_grid.heights.size_bytes();
        watch.restart();
        const auto written = scene::write_world(path, data, {.name = "ground"});
        if (!written) return fail(written.error());
        watch.print("write_world (and fsync)", raw);
        fmt::print("{:.0f} MB of arrays in a pack of {:.0f} MB\n", double(raw) * 1e-6, double(*written) * 1e-6);
    }
    const auto pack = assets::PackReader::open(path);
    if (!pack) return fail(pack.error());
    for (const auto& chunk : pack->chunks()) {
        auto buffer = assets::PageBuffer::allocate(chunk.raw_bytes());
        if (!buffer) return fail(buffer.error());
        if (chunk.raw_bytes() < 1'000'000) continue;
        watch.restart();
        if (const Status status = pack->read(std::vector<assets::PackReader::Target>{{chunk.name, buffer->bytes()}});
            !status)
            return fail(status.error());
        watch.print(fmt::format("  {} ({:.0f} of {:.0f} MB)", chunk.name, double(chunk.stored_bytes) * 1e-6,
                                double(chunk.raw_bytes()) * 1e-6),
                    chunk.raw_bytes());
    }
    for (int lap = 0; lap < 3; ++lap) {
        watch.restart();
        const auto world = scene::load_world(path);
        if (!world) return fail(world.error());
        watch.print("load_world", raw);
        if (lap < 2) continue;
        // Its last two steps again, alone, and what reading the leaves instead of making them would cost: a copy.
        const scene::StaticScene& s = (*world)->scene();
        watch.restart();
        if (scene::find_world_problem(s, (*world)->info(), s.mesh_leaves.size())) return 1;
        watch.print("  find_world_problem", raw);
        std::vector<std::uint8_t> sizes(s.mesh_leaves.size());
        std::transform(s.mesh_leaves.begin(), s.mesh_leaves.end(), sizes.begin(),
                       [](const scene::BvhLeaf& leaf) { return std::uint8_t(leaf.triangle_count); });
        auto buffer = assets::PageBuffer::allocate(s.mesh_leaves.size_bytes());
        if (!buffer) return fail(buffer.error());
        const std::span leaves(reinterpret_cast<scene::BvhLeaf*>(buffer->bytes().data()), s.mesh_leaves.size());
        watch.restart();
        if (scene::make_leaf_blocks(s, sizes, leaves)) return 1;
        watch.print("  make_leaf_blocks", s.mesh_leaves.size_bytes());
        const auto leaf_path = path.string() + ".leaves";
        auto writer = assets::PackWriter::create(leaf_path);
        if (!writer || !writer->add("leaves", s.mesh_leaves) || !writer->finish()) return 1;
        const auto leaf_pack = assets::PackReader::open(leaf_path);
        auto target = assets::PageBuffer::allocate(s.mesh_leaves.size_bytes());
        if (!leaf_pack || !target) return 1;
        watch.restart();
        if (!leaf_pack->read(std::vector<assets::PackReader::Target>{{"leaves", target->bytes()}})) return 1;
        watch.print(fmt::format("  reading leaves instead ({:.0f} MB)", double(leaf_pack->file_bytes()) * 1e-6),
                    s.mesh_leaves.size_bytes());
        std::filesystem::remove(leaf_path);
    }
    return 0;
}

}  // namespace

int main(int argc, char** argv) {
    std::uint64_t triangles = 20'000'000;
    std::filesystem::path path = std::filesystem::temp_directory_path() / "bench_pack.ffpack";
    bool keep = false;
    for (int i = 1; i < argc; ++i) {
        const std::string_view option = argv[i];
        if (option == "--triangles" && i + 1 < argc) {
            triangles = std::strtoull(argv[++i], nullptr, 10);
        } else if (option == "--file" && i + 1 < argc) {
            path = argv[++i];
        } else if (option == "--keep") {
            keep = true;
        } else {
            fmt::print(stderr, "usage: bench_pack [--triangles N] [--file PATH] [--keep]\n");
            return 2;
        }
    }
    const int code = run(triangles, path);
    if (!keep) std::filesystem::remove(path);
    return code;
}
