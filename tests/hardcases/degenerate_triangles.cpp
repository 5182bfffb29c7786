// Triangles that hardly are any: slivers, without area, twice the same, huge beside tiny.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <optional>

#include "engine/core/jobs.h"
#include "tests/hardcases/cases.h"
#include "tests/hardcases/exact_pixels.h"
#include "tests/support/worlds.h"

namespace ff::hardcases {
namespace {

using farfield::kSkyInstance;
using farfield::VisibilityBuffer;

constexpr int kSize = 64;
constexpr float kWallM = 16.0f;

/// Looks along -z from the origin; pixel centres are exact in float32.
PinholeView exact_view() {
    PinholeView view;
    view.width = view.height = kSize;
    view.u_step = 2.0f / kSize;
    view.u_first = -1.0f;
    view.v_step = -2.0f / kSize;
    view.v_first = 1.0f;
    return view;
}

Vec3 at_pixel(const PinholeView& view, double x, double y, float depth) {
    return depth * Vec3(float((x + 0.5) * double(view.u_step) + double(view.u_first)),
                        float((y + 0.5) * double(view.v_step) + double(view.v_first)), -1.0f);
}

void append_wall(scene::MeshSource& mesh) {
    const float r = 4.0f * kWallM;
    test::append_quad(mesh, Vec3(-r, -r, -kWallM), Vec3(r, -r, -kWallM), Vec3(r, r, -kWallM), Vec3(-r, r, -kWallM), 0);
}

/// A sliver from the centre of one pixel to that of another; the line is all there is of it.
using DVec2 = glm::dvec2;

struct Sliver {
    DVec2 from, to;  ///< pixels
    double inverse_from, inverse_to;
};

/// Appends a triangle on that line; its vertices carry the sliver's number in their colour.
/// @param aspect  height by length
Sliver append_sliver(test::Random& random, const PinholeView& view, double aspect, std::uint32_t number,
                     scene::MeshSource& mesh) {
    const auto pixel = [&] { return DVec2(double(random.below(kSize)), double(random.below(kSize))); };
    const DVec2 from = pixel();
    DVec2 to = pixel();
    if (random.below(3) == 0) to.y = from.y;
    if (random.below(3) == 0) to.x = from.x;
    if (from == to) to.x += 5.0;
    const float near = 1.0f + float(random.below(112)) / 16.0f, far = 1.0f + float(random.below(112)) / 16.0f;
    const Vec3 a = at_pixel(view, from.x, from.y, near), b = at_pixel(view, to.x, to.y, far);
    const Vec3 aside = random.in_box(Vec3(-1.0f), Vec3(1.0f)) * float(aspect) * glm::length(b - a);
    test::append_triangle(mesh, a, b, a + (b - a) * float(random.unit()) + aside, 0);
    for (auto vertex = mesh.attributes.end() - 3; vertex != mesh.attributes.end(); ++vertex) vertex->color = number;
    return {from, to, 1.0 / double(near), 1.0 / double(far)};
}

/// What is wrong where a pixel shows a sliver at a depth: it must be on its line, at its line's depth there.
std::string sliver_problem(const Sliver& sliver, const DVec2& pixel, double depth, double& error) {
    const DVec2 along = sliver.to - sliver.from, q = pixel - sliver.from;
    const double s = std::clamp(glm::dot(q, along) / glm::dot(along, along), 0.0, 1.0);
    if (glm::length(q - s * along) > 1e-3) return fmt::format("a sliver {} pixels away", glm::length(q - s * along));
    error = std::fabs(depth * (sliver.inverse_from + s * (sliver.inverse_to - sliver.inverse_from)) - 1.0);
    return {};
}

}  // namespace

template <Subject kSubject>
void slivers(Trial& trial) {
    constexpr std::uint32_t kSlivers = 40;
    const PinholeView view = exact_view();
    const auto tiles = all_tiles(view);
    VisibilityBuffer seen, easy;
    seen.resize(kSize, kSize);
    easy.resize(kSize, kSize);
    while (!trial.done()) {
        test::Random random(trial.next_seed());
        scene::MeshSource mesh, easy_mesh;
        std::vector<Sliver> drawn;
        append_wall(mesh);
        append_wall(easy_mesh);
        for (std::uint32_t i = 0; i < kSlivers; ++i) {
            drawn.push_back(append_sliver(random, view, 1e-7, i, mesh));
            append_sliver(random, view, 1e-2, i, easy_mesh);
        }
        const scene::SceneData data = scene_of(mesh, WorldPos(0.0)), easy_data = scene_of(easy_mesh, WorldPos(0.0));
        const scene::StaticScene scene = data.view(), easy_scene = easy_data.view();
        const auto caster = make_caster(kSubject, scene), easy_caster = make_caster(kSubject, easy_scene);
        trial.time_hard([&] { caster->cast_tiles(view, tiles, seen); });
        trial.time_easy([&] { easy_caster->cast_tiles(view, tiles, easy); });
        for (int y = 0; y < kSize; ++y)
            for (int x = 0; x < kSize; ++x) {
                const std::size_t at = seen.index(x, y);
                double error = 0.0;
                std::string problem = "sky";
                if (seen.instance[at] == 0) {
                    const std::uint32_t number =
                        scene.attributes[scene.indices[3 * std::size_t(seen.triangle[at])]].color;
                    const auto depth = double(seen.depth[at]);
                    problem = number < drawn.size() ? sliver_problem(drawn[number], DVec2(x, y), depth, error) : "";
                    if (number >= drawn.size()) error = std::fabs(depth / double(kWallM) - 1.0);
                }
                trial.count(problem.empty(), error, [&] { return fmt::format("pixel {}, {}: {}", x, y, problem); });
            }
        trial.report();
    }
}
template void slivers<Subject::beam>(Trial&);
template void slivers<Subject::embree>(Trial&);
template void slivers<Subject::grid>(Trial&);

namespace {

/// Ordinary triangles, some of them several times, and some without any area.
scene::MeshSource make_duplicates(test::Random& random, bool with_duplicates) {
    const PinholeView view = exact_view();
    scene::MeshSource mesh;
    append_wall(mesh);
    for (int i = 0; i < 12; ++i) {
        Vec3 p[3];
        for (Vec3& corner : p)
            corner = at_pixel(view, random.in(0, kSize), random.in(0, kSize), float(random.in(2.0, 12.0)));
        const std::uint32_t times = with_duplicates ? 1 + random.below(4) : 5;  // as many in all
        for (std::uint32_t n = 0; n < times; ++n) {
            const std::uint32_t first = with_duplicates ? random.below(3) : 0;  // the same, begun at another corner
            const float aside = with_duplicates ? 0.0f : 0.3f * float(n);
            test::append_triangle(mesh, p[first] + aside, p[(first + 1) % 3] + aside, p[(first + 2) % 3] + aside, 0);
        }
        if (!with_duplicates) continue;
        test::append_triangle(mesh, p[0] * 0.5f, p[1] * 0.5f, p[1] * 0.5f, 0);
        test::append_triangle(mesh, p[2] * 0.5f, p[2] * 0.5f, p[2] * 0.5f, 0);
        test::append_triangle(mesh, p[0] * 0.5f, p[1] * 0.5f, (p[0] + p[1]) * 0.25f, 0);
    }
    return mesh;
}

/// Two of the same mesh in the same place.
scene::SceneData twice(scene::MeshSource mesh) {
    scene::SceneData data;
    data.materials.push_back(test::plain_material());
    const std::uint32_t id = data.add_mesh(scene::prepare_mesh(std::move(mesh), data.materials));
    for (int i = 0; i < 2; ++i) data.add_instance(id, WorldPos(0.0), Mat3(1.0f), 0);
    data.finish(16);
    return data;
}

}  // namespace

template <Subject kSubject>
void duplicates(Trial& trial) {
    const PinholeView view = exact_view();
    const auto tiles = all_tiles(view);
    VisibilityBuffer seen, easy;
    seen.resize(kSize, kSize);
    easy.resize(kSize, kSize);
    while (!trial.done()) {
        test::Random random(trial.next_seed());
        const scene::SceneData data = twice(make_duplicates(random, true));
        const scene::SceneData easy_data = twice(make_duplicates(random, false));
        const scene::StaticScene scene = data.view(), easy_scene = easy_data.view();
        const auto caster = make_caster(kSubject, scene), easy_caster = make_caster(kSubject, easy_scene);
        trial.time_hard([&] { caster->cast_tiles(view, tiles, seen); });
        trial.time_easy([&] { easy_caster->cast_tiles(view, tiles, easy); });
        ExactPixels(scene, view, {}).count(seen, trial);
        trial.report();
    }
}
template void duplicates<Subject::beam>(Trial&);
template void duplicates<Subject::embree>(Trial&);
template void duplicates<Subject::grid>(Trial&);

template <Subject kSubject>
void coincident_winner(Trial& trial) {
    const PinholeView view = exact_view();
    const auto tiles = all_tiles(view);
    VisibilityBuffer seen[2];
    for (VisibilityBuffer& buffer : seen) buffer.resize(kSize, kSize);
    while (!trial.done()) {
        test::Random random(trial.next_seed());
        const scene::SceneData data = twice(make_duplicates(random, true));
        const scene::StaticScene scene = data.view();
        for (int workers = 1; workers <= 2; ++workers) {
            const WorkerLimit limit(workers);
            make_caster(kSubject, scene)->cast_tiles(view, tiles, seen[workers - 1]);
        }
        for (int y = 0; y < kSize; ++y)
            for (int x = 0; x < kSize; ++x) {
                const std::size_t at = seen[0].index(x, y);
                const bool is_same = seen[0].instance[at] == seen[1].instance[at] &&
                                     seen[0].triangle[at] == seen[1].triangle[at] &&
                                     seen[0].depth[at] == seen[1].depth[at];
                // Both instances hold the very same triangles: beams promise the smaller id.
                const bool is_smaller = kSubject != Subject::beam || seen[0].instance[at] == 0;
                trial.count(is_same && is_smaller, 0.0, [&] { return fmt::format("pixel {}, {}", x, y); });
            }
        trial.report();
    }
}
template void coincident_winner<Subject::beam>(Trial&);
template void coincident_winner<Subject::embree>(Trial&);
template void coincident_winner<Subject::grid>(Trial&);

namespace {

/// Ground of four triangles that meet near the viewer, and chips of a millimetre over it, all in one mesh.
scene::MeshSource make_ground_with_chips(test::Random& random, float ground_m) {
    scene::MeshSource mesh;
    const Vec3 middle(float(random.in(-1.0, 1.0)), 0.0f, float(random.in(-1.0, 1.0)));
    const float r = ground_m;
    const Vec3 rim[4] = {Vec3(-r, 0, -r), Vec3(-r, 0, r), Vec3(r, 0, r), Vec3(r, 0, -r)};
    for (int i = 0; i < 4; ++i) test::append_triangle(mesh, middle, rim[i], rim[(i + 1) % 4], 0);
    for (int i = 0; i < 60; ++i) {
        const Vec3 at = random.in_box(Vec3(-0.02f, 0.001f, -0.02f), Vec3(0.02f, 0.01f, 0.02f));
        Vec3 p[3];
        for (Vec3& corner : p) corner = at + random.in_box(Vec3(-5e-4f), Vec3(5e-4f));
        test::append_triangle(mesh, p[0], p[1], p[2], 0);
    }
    return mesh;
}

}  // namespace

template <Subject kSubject>
void huge_beside_tiny(Trial& trial) {
    VisibilityBuffer seen, easy;
    while (!trial.done()) {
        test::Random random(trial.next_seed());
        const WorldPos at(random.in(-1e4, 1e4), random.in(-100.0, 100.0), random.in(-1e4, 1e4));
        const scene::SceneData data = scene_of(make_ground_with_chips(random, 5e6f), at);
        const scene::SceneData easy_data = scene_of(make_ground_with_chips(random, 50.0f), at);
        const scene::StaticScene scene = data.view(), easy_scene = easy_data.view();
        const auto caster = make_caster(kSubject, scene), easy_caster = make_caster(kSubject, easy_scene);
        Camera camera{.pitch = -random.in(0.3, 1.2), .roll = random.in(-3.0, 3.0), .vertical_fov = 0.8};
        camera.yaw = random.in(-kPi, kPi);
        camera.position = at - world_from_camera(camera) * DVec3(0, 0, -0.06);
        const PinholeView view = make_view(camera, 96, 80);
        seen.resize(view.width, view.height);
        easy.resize(view.width, view.height);
        const auto tiles = all_tiles(view);
        trial.time_hard([&] { caster->cast_tiles(view, tiles, seen); });
        trial.time_easy([&] { easy_caster->cast_tiles(view, tiles, easy); });
        // Embree's robust tests round corners 5,000 km away to half a metre: neighbours in the plane swap places.
        ExactPixels(scene, view, {.any_of_plane = kSubject == Subject::embree}).count(seen, trial);
        trial.report();
    }
}
template void huge_beside_tiny<Subject::beam>(Trial&);
template void huge_beside_tiny<Subject::embree>(Trial&);
template void huge_beside_tiny<Subject::grid>(Trial&);

}  // namespace ff::hardcases
