// Rays exactly through what triangles share. A closed mesh lets none of them pass.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <glm/matrix.hpp>
#include <limits>

#include "tests/hardcases/cases.h"
#include "tests/hardcases/lattice_meshes.h"

namespace ff::hardcases {
namespace {

using farfield::kSkyInstance;
using farfield::Ray;
using farfield::RayHit;
using farfield::VisibilityBuffer;

/// A point within a ball, and what a ray through it may be aimed at.
struct Inside {
    DVec3 center{0.0};
    std::vector<std::uint32_t> edges;
};

Inside point_inside(const LatticeBall& ball, test::Random& random) {
    Inside inside;
    const float reach = 0.5f * ball.inner_radius_m;
    while (inside.edges.empty()) {
        inside.center = glm::round(DVec3(random.in_box(Vec3(-reach), Vec3(reach))) * 64.0) / 64.0;
        inside.edges = edges_turned_away(ball, inside.center);
    }
    return inside;
}

DVec3 point_on_edge(const LatticeBall& ball, const Inside& inside, test::Random& random) {
    const std::size_t edge = 2 * random.below(std::uint32_t(inside.edges.size() / 2));
    const DVec3 a(ball.mesh.positions[inside.edges[edge]]), b(ball.mesh.positions[inside.edges[edge + 1]]);
    return a + (b - a) * (double(random.below(9)) / 8.0);
}

DVec3 point_on_face(const LatticeBall& ball, test::Random& random) {
    const std::size_t i = 3 * random.below(std::uint32_t(ball.mesh.triangle_materials.size()));
    const auto corner = [&](std::size_t k) { return DVec3(ball.mesh.positions[ball.mesh.indices[i + k]]); };
    return corner(0) + random.in(0.1, 0.4) * (corner(1) - corner(0)) + random.in(0.1, 0.4) * (corner(2) - corner(0));
}

/// A ball somewhere in the world.
struct Placed {
    Mat3 turn;
    WorldPos at;
};

/// A ray through `center` and `point`, from the one or from beyond the other; exact in float32 where both are.
Ray ray_through(const Placed& placed, const DVec3& center, const DVec3& point, test::Random& random,
                double& t_of_point) {
    const DVec3 outward = point - center;
    const double scale = std::ldexp(1.0, int(random.below(9)) - 4);
    const bool from_inside = random.below(2) == 0;
    const double steps = from_inside ? 1.0 : double(1u << random.below(5));
    t_of_point = steps / scale;
    const DVec3 origin = from_inside ? center : point + steps * outward;
    return {placed.at + DMat3(placed.turn) * origin, placed.turn * Vec3(outward * (from_inside ? scale : -scale))};
}

}  // namespace

template <Subject kSubject>
void rays_through_edges(Trial& trial) {
    constexpr std::size_t kRays = 4096;
    std::vector<Ray> rays(kRays), easy_rays(kRays);
    std::vector<RayHit> hits(kRays), easy_hits(kRays);
    std::vector<double> expected(kRays);
    while (!trial.done()) {
        test::Random random(trial.next_seed());
        const LatticeBall ball = make_lattice_ball(random);
        const Placed placed{random_lattice_turn(random, true),
                            {random.below(2) == 0 ? 0.0 : 4096.0, 0.0, double(random.below(512)) - 256.0}};
        const scene::SceneData data = scene_of(ball.mesh, placed.at, placed.turn);
        const scene::StaticScene scene = data.view();
        const auto caster = make_caster(kSubject, scene);
        double unused = 0.0;
        Inside inside;
        for (std::size_t i = 0; i < kRays; ++i) {
            if (i % 256 == 0) inside = point_inside(ball, random);
            rays[i] = ray_through(placed, inside.center, point_on_edge(ball, inside, random), random, expected[i]);
            easy_rays[i] = ray_through(placed, inside.center, point_on_face(ball, random), random, unused);
        }
        trial.time_hard([&] { caster->cast_rays(rays, hits); });
        trial.time_easy([&] { caster->cast_rays(easy_rays, easy_hits); });
        for (std::size_t i = 0; i < kRays; ++i) {
            // The point lies on the surface, so what is seen is it or something nearer.
            const double beyond = double(hits[i].t) / expected[i] - 1.0;
            const bool is_hit = hits[i].instance != kSkyInstance && beyond < 1e-4;
            trial.count(is_hit, std::max(0.0, beyond), [&] {
                return fmt::format("ray {} at {} of the distance of its edge", i, double(hits[i].t) / expected[i]);
            });
        }
        trial.report();
    }
}
template void rays_through_edges<Subject::beam>(Trial&);
template void rays_through_edges<Subject::embree>(Trial&);
template void rays_through_edges<Subject::embree_fast>(Trial&);
template void rays_through_edges<Subject::grid>(Trial&);

namespace {

/// Triangle of the front as its three pixels, in whole numbers.
struct PixelTriangle {
    std::int64_t x[3], y[3];
    double inverse_depth[3];
    bool is_front = true;  ///< all corners before the eye
};

PixelTriangle pixel_triangle(const scene::StaticScene& scene, const PinholeView& view, std::uint32_t triangle) {
    PixelTriangle out;
    const scene::Mesh& mesh = scene.meshes[0];
    for (std::size_t k = 0; k < 3; ++k) {
        const Vec3& p = scene.positions[mesh.first_vertex + scene.indices[3 * std::size_t(triangle) + k]];
        const DVec3 camera = glm::transpose(DMat3(view.world_from_camera)) * DVec3(p);
        out.is_front = out.is_front && camera.z < 0.0;
        const double u = camera.x / -camera.z, v = camera.y / -camera.z;  // exact: vertices are (u, v, -1) times depth
        out.x[k] = std::llround((u - double(view.u_first)) / double(view.u_step) - 0.5);
        out.y[k] = std::llround((v - double(view.v_first)) / double(view.v_step) - 0.5);
        out.inverse_depth[k] = -1.0 / camera.z;
    }
    return out;
}

/// Depth of the triangle's plane at a pixel that it covers, borders included; NaN: it does not cover it.
double depth_at(const PixelTriangle& t, std::int64_t x, std::int64_t y) {
    std::int64_t e[3];
    for (std::size_t k = 0; k < 3; ++k) {
        const std::size_t p = (k + 1) % 3, q = (k + 2) % 3;
        e[k] = (t.x[q] - t.x[p]) * (y - t.y[p]) - (t.y[q] - t.y[p]) * (x - t.x[p]);
    }
    const bool all_up = e[0] >= 0 && e[1] >= 0 && e[2] >= 0, all_down = e[0] <= 0 && e[1] <= 0 && e[2] <= 0;
    const std::int64_t area = e[0] + e[1] + e[2];
    if (!t.is_front || area == 0 || !(all_up || all_down)) return std::numeric_limits<double>::quiet_NaN();
    double inverse = 0.0;
    for (std::size_t k = 0; k < 3; ++k) inverse += double(e[k]) / double(area) * t.inverse_depth[k];
    return 1.0 / inverse;
}

/// The lattice seen a little from aside: an ordinary picture of the same mesh.
PinholeView ordinary_view(const PinholeView& view) {
    PinholeView out = view;
    out.u_first += 0.37f * view.u_step;
    out.v_first += 0.29f * view.v_step;
    return out;
}

/// What is wrong with a pixel of the lattice; empty: nothing.
std::string pixel_problem(const scene::StaticScene& scene, const PixelLattice& lattice, int x, int y,
                          const VisibilityBuffer& seen, double& error) {
    const std::size_t at = seen.index(x, y);
    const bool is_inside = std::min(x, y) > lattice.low && std::max(x, y) < lattice.high;
    const bool is_outside = std::min(x, y) < lattice.low || std::max(x, y) > lattice.high;
    if (seen.instance[at] != 0) {
        if (is_inside) return fmt::format("pixel {}, {}: a leak", x, y);
        return seen.instance[at] == kSkyInstance ? "" : fmt::format("pixel {}, {}: not answered", x, y);
    }
    if (is_outside) return fmt::format("pixel {}, {}: covered by nothing, but hit", x, y);
    const double depth = depth_at(pixel_triangle(scene, lattice.view, seen.triangle[at]), x, y);
    if (std::isnan(depth) && !is_inside) return "";  // on the outline the cone behind may show
    if (std::isnan(depth)) return fmt::format("pixel {}, {}: triangle {} is not there", x, y, seen.triangle[at]);
    error = std::fabs(double(seen.depth[at]) / depth - 1.0);
    return "";
}

}  // namespace

template <Subject kSubject>
void pixels_on_edges(Trial& trial) {
    VisibilityBuffer seen, easy;
    while (!trial.done()) {
        test::Random random(trial.next_seed());
        const PixelLattice lattice = make_pixel_lattice(random);
        const PinholeView& view = lattice.view;
        const scene::SceneData data = scene_of(lattice.mesh, view.position);
        const scene::StaticScene scene = data.view();
        const auto caster = make_caster(kSubject, scene);
        seen.resize(view.width, view.height);
        easy.resize(view.width, view.height);
        const auto tiles = all_tiles(view);
        trial.time_hard([&] { caster->cast_tiles(view, tiles, seen); });
        trial.time_easy([&] { caster->cast_tiles(ordinary_view(view), tiles, easy); });
        for (int y = 0; y < view.height; ++y)
            for (int x = 0; x < view.width; ++x) {
                double error = 0.0;
                const std::string problem = pixel_problem(scene, lattice, x, y, seen, error);
                trial.count(problem.empty(), error, [&] { return problem; });
            }
        trial.report();
    }
}
template void pixels_on_edges<Subject::beam>(Trial&);
template void pixels_on_edges<Subject::embree>(Trial&);
template void pixels_on_edges<Subject::embree_fast>(Trial&);
template void pixels_on_edges<Subject::grid>(Trial&);

void pixels_of_tiles(Trial& trial) {
    VisibilityBuffer whole, pieces;
    while (!trial.done()) {
        test::Random random(trial.next_seed());
        const PixelLattice lattice = make_pixel_lattice(random);
        const PinholeView& view = lattice.view;
        const scene::SceneData data = scene_of(lattice.mesh, view.position);
        const scene::StaticScene scene = data.view();
        const auto caster = make_caster(Subject::beam, scene);
        whole.resize(view.width, view.height);
        pieces.resize(view.width, view.height);
        const auto tiles = all_tiles(view);
        // Each tile in two requests that share no pixel: whoever answers a pixel of the other's claims it twice.
        auto first = tiles, second = tiles;
        for (std::size_t i = 0; i < tiles.size(); ++i)
            for (int row = 0; row < farfield::kTileSize; ++row) {
                first[i].rows[row] = std::uint16_t(random.below(65536));
                second[i].rows[row] = std::uint16_t(~first[i].rows[row]);
            }
        caster->cast_tiles(view, tiles, whole);
        caster->cast_tiles(view, first, pieces);
        std::vector<bool> touched(pieces.instance.size());
        for (std::size_t at = 0; at < touched.size(); ++at) touched[at] = pieces.instance[at] != farfield::kUnresolved;
        caster->cast_tiles(view, second, pieces);
        for (int y = 0; y < view.height; ++y)
            for (int x = 0; x < view.width; ++x) {
                const std::size_t at = whole.index(x, y);
                const auto tile =
                    std::size_t(y / farfield::kTileSize * (view.width / farfield::kTileSize) + x / farfield::kTileSize);
                const bool asked_first = (first[tile].rows[y % farfield::kTileSize] >> (x % farfield::kTileSize)) & 1;
                const bool is_same = pieces.instance[at] == whole.instance[at] &&
                                     pieces.triangle[at] == whole.triangle[at] && pieces.depth[at] == whole.depth[at];
                trial.count(is_same && touched[at] == asked_first, 0.0,
                            [&] { return fmt::format("pixel {}, {}", x, y); });
            }
        trial.report();
    }
}

}  // namespace ff::hardcases
