// Rays along the planes that casters cut space by: axis-parallel ones with zeros of either sign and denormals, from
// cell faces, edges and corners, within planes; and rays from very far outside.

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>

#include "engine/farfield/grid_structure.h"
#include "tests/hardcases/cases.h"
#include "tests/support/worlds.h"

namespace ff::hardcases {
namespace {

using farfield::kSkyInstance;
using farfield::Ray;
using farfield::RayHit;

constexpr double kInf = std::numeric_limits<double>::infinity();
constexpr int kWorldM = 32;  ///< side of the cube in which boxes stand

/// Boxes whose corners are whole metres, a mesh or two of them.
struct BoxWorld {
    scene::SceneData data;
    std::vector<DBox3> boxes;
};

BoxWorld make_box_world(test::Random& random) {
    BoxWorld world;
    world.data.materials.push_back(test::plain_material());
    for (std::uint32_t m = 0; m < 1 + random.below(3); ++m) {
        scene::MeshSource mesh;
        const DVec3 at(double(random.below(9)), double(random.below(9)), double(random.below(9)));
        for (std::uint32_t b = 0; b < 2 + random.below(8); ++b) {
            Vec3 low, high;
            for (int axis = 0; axis < 3; ++axis) {
                low[axis] = float(random.below(kWorldM - 16));
                high[axis] = low[axis] + float(1 + random.below(8));
            }
            test::append_box(mesh, low, high, 1 + int(random.below(3)), 0);
            world.boxes.push_back({at + DVec3(low), at + DVec3(high)});
        }
        const std::uint32_t id = world.data.add_mesh(scene::prepare_mesh(std::move(mesh), world.data.materials));
        world.data.add_instance(id, at, Mat3(1.0f), 0);
    }
    world.data.finish(16);
    return world;
}

/// Where a ray is within a box that is grown by `grow` metres; nullopt: nowhere beyond t = 0.
struct Span {
    double enter, leave;
};
std::optional<Span> span_in(const DBox3& box, double grow, const DVec3& origin, const DVec3& direction) {
    Span span{-kInf, kInf};
    for (int axis = 0; axis < 3; ++axis) {
        const double low = box.low[axis] - grow - origin[axis], high = box.high[axis] + grow - origin[axis];
        if (direction[axis] == 0.0) {
            if (low > 0.0 || high < 0.0) return std::nullopt;
            continue;
        }
        const double a = low / direction[axis], b = high / direction[axis];
        span.enter = std::max(span.enter, std::min(a, b));
        span.leave = std::min(span.leave, std::max(a, b));
    }
    if (!(span.enter <= span.leave) || span.leave < 0.0) return std::nullopt;
    return span;
}

/// The t's between which the first hit must lie: not before the ray comes within `slack` of any box's surface, and not
/// after it has certainly passed through one. deadline = inf: it may be sky.
struct Bracket {
    double first = kInf, deadline = kInf;
};
Bracket first_hit(const std::vector<DBox3>& boxes, const DVec3& origin, const DVec3& direction, double slack) {
    Bracket bracket;
    for (const DBox3& box : boxes) {
        const auto grown = span_in(box, slack, origin, direction);
        if (!grown) continue;
        const auto shrunk = span_in(box, -slack, origin, direction);
        const bool starts_inside = shrunk && shrunk->enter<0.0, starts_outside = grown->enter> 0.0;
        bracket.first = std::min(bracket.first, starts_inside ? shrunk->leave : std::max(0.0, grown->enter));
        if (shrunk) bracket.deadline = std::min(bracket.deadline, starts_outside ? shrunk->enter : grown->leave);
    }
    return bracket;
}

/// A component that is as good as zero.
float near_zero(test::Random& random) {
    constexpr std::array<float, 6> kZeros{0.0f, -0.0f, 1e-40f, -1e-40f, 1.4e-45f, -1.1e-38f};
    return kZeros[random.below(kZeros.size())];
}

Vec3 axis_direction(test::Random& random) {
    Vec3 direction(near_zero(random), near_zero(random), near_zero(random));
    const auto axis = int(random.below(3));
    const float length = float(std::ldexp(1.0, int(random.below(9)) - 4));
    direction[axis] = random.below(2) == 0 ? length : -length;
    if (random.below(3) == 0) direction[(axis + 1) % 3] = direction[axis];  // along a diagonal of the planes
    return direction;
}

/// On whole and half metres: in the planes of faces, on edges and corners, outside and inside.
DVec3 lattice_origin(test::Random& random) {
    DVec3 origin;
    for (int axis = 0; axis < 3; ++axis) origin[axis] = 0.5 * (double(random.below(2 * kWorldM + 16)) - 8.0);
    return origin;
}

/// On planes, edges or corners of the cells of a grid caster's own grid.
DVec3 cell_origin(const farfield::grid::Grid& grid, const WorldPos& at, test::Random& random) {
    Vec3 origin;
    for (int axis = 0; axis < 3; ++axis) {
        const double cells =
            random.below(3) == 0 ? random.in(0.0, grid.count[axis]) : random.below(std::uint32_t(grid.count[axis] + 1));
        origin[axis] = grid.low[axis] + float(cells) / grid.cells_per_m[axis];
    }
    return at + DVec3(origin);
}

void count_hit(Trial& trial, const BoxWorld& world, const Ray& ray, const RayHit& hit, double slack) {
    const DVec3 direction(ray.direction);
    const Bracket bracket = first_hit(world.boxes, ray.origin, direction, slack);
    const double tolerance = slack / glm::length(direction) + 1e-6 * (std::isfinite(bracket.first) ? bracket.first : 0);
    const auto t = double(hit.t);
    const bool is_right = hit.instance == kSkyInstance
                              ? bracket.deadline == kInf
                              : t >= bracket.first - tolerance && t <= bracket.deadline + tolerance;
    trial.count(is_right, 0.0, [&] {
        return fmt::format("origin ({}, {}, {}), direction ({:g}, {:g}, {:g}): t = {}, expected {} to {}", ray.origin.x,
                           ray.origin.y, ray.origin.z, ray.direction.x, ray.direction.y, ray.direction.z, t,
                           bracket.first, bracket.deadline);
    });
}

Ray ordinary_ray(test::Random& random) {
    const Vec3 to = random.in_box(Vec3(0.0f), Vec3(float(kWorldM)));
    const Vec3 from = random.in_box(Vec3(-8.0f), Vec3(kWorldM + 8.0f));
    return {DVec3(from), to - from};
}

/// Casts batches of rays of `make_ray` and of ordinary ones.
template <Subject kSubject, class MakeRay>
void cast_and_count(Trial& trial, double slack, MakeRay&& make_ray) {
    constexpr std::size_t kRays = 4096;
    std::vector<Ray> rays(kRays), easy_rays(kRays);
    std::vector<RayHit> hits(kRays), easy_hits(kRays);
    while (!trial.done()) {
        test::Random random(trial.next_seed());
        const BoxWorld world = make_box_world(random);
        const scene::StaticScene scene = world.data.view();
        const auto caster = make_caster(kSubject, scene);
        const farfield::grid::Grid grid =
            farfield::grid::make_mesh_grid(scene, scene.meshes[0], farfield::kUsualGridCellsPerItem);
        for (std::size_t i = 0; i < kRays; ++i) {
            rays[i] = make_ray(random, grid, scene);
            easy_rays[i] = ordinary_ray(random);
        }
        trial.time_hard([&] { caster->cast_rays(rays, hits); });
        trial.time_easy([&] { caster->cast_rays(easy_rays, easy_hits); });
        for (std::size_t i = 0; i < kRays; ++i) count_hit(trial, world, rays[i], hits[i], slack);
        trial.report();
    }
}

}  // namespace

template <Subject kSubject>
void axis_parallel_rays(Trial& trial) {
    constexpr double kSlackM = 2e-5;  // a few units in the last place of the coordinates
    cast_and_count<kSubject>(
        trial, kSlackM,
        [](test::Random& random, const farfield::grid::Grid& grid, const scene::StaticScene& scene) -> Ray {
            const bool on_cells = random.below(2) == 0;
            return {on_cells ? cell_origin(grid, scene.instances[0].position, random) : lattice_origin(random),
                    axis_direction(random)};
        });
}
template void axis_parallel_rays<Subject::beam>(Trial&);
template void axis_parallel_rays<Subject::embree>(Trial&);
template void axis_parallel_rays<Subject::grid>(Trial&);

template <Subject kSubject>
void rays_from_far_outside(Trial& trial) {
    constexpr double kSlackM = 1e-3, kFarM = 1e7;
    cast_and_count<kSubject>(trial, kSlackM,
                             [](test::Random& random, const farfield::grid::Grid&, const scene::StaticScene&) -> Ray {
                                 const DVec3 target(random.in_box(Vec3(0.0f), Vec3(float(kWorldM))));
                                 DVec3 away(random.in_box(Vec3(-1.0f), Vec3(1.0f)));
                                 if (random.below(4) == 0) away = DVec3(axis_direction(random));
                                 const Vec3 direction(-glm::normalize(away));
                                 // The float's own ray through the target.
                                 return {target - kFarM * DVec3(direction), direction};
                             });
}
template void rays_from_far_outside<Subject::beam>(Trial&);
template void rays_from_far_outside<Subject::embree>(Trial&);
template void rays_from_far_outside<Subject::grid>(Trial&);

}  // namespace ff::hardcases
