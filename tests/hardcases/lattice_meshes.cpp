#include "tests/hardcases/lattice_meshes.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <utility>

namespace ff::hardcases {
namespace {

constexpr float kStep = 1.0f / 64.0f;

float snapped(double v) {
    return float(std::round(v / double(kStep))) * kStep;
}

std::uint32_t add_vertex(scene::MeshSource& mesh, const Vec3& p) {
    mesh.positions.push_back(p);
    mesh.attributes.push_back({.normal_oct = {0, 0}, .uv = Vec2(0.0f), .color = 0xFFFFFFFFu});
    return std::uint32_t(mesh.positions.size() - 1);
}

void add_triangle(scene::MeshSource& mesh, std::uint32_t a, std::uint32_t b, std::uint32_t c) {
    mesh.indices.insert(mesh.indices.end(), {a, b, c});
    mesh.triangle_materials.push_back(0);
}

}  // namespace

LatticeBall make_lattice_ball(test::Random& random) {
    LatticeBall ball;
    const int rings = 4 + int(random.below(14)), columns = 3 + int(random.below(2 * std::uint32_t(rings)));
    const double radius = random.in(4.0, 20.0), bump = random.in(0.0, 0.25);
    const auto put = [&](double theta, double phi) {
        const double r = radius * (1.0 + bump * random.in(-1.0, 1.0));
        add_vertex(ball.mesh, Vec3(snapped(r * std::sin(theta) * std::cos(phi)), snapped(r * std::cos(theta)),
                                   snapped(r * std::sin(theta) * std::sin(phi))));
    };
    put(0.0, 0.0);
    put(kPi, 0.0);
    for (int ring = 1; ring < rings; ++ring)
        for (int column = 0; column < columns; ++column) put(kPi * ring / rings, 2.0 * kPi * column / columns);
    const auto vertex = [&](int ring, int column) {
        if (ring == 0) return 0u;
        if (ring == rings) return 1u;
        return std::uint32_t(2 + (ring - 1) * columns + column % columns);
    };
    for (int ring = 0; ring < rings; ++ring)
        for (int column = 0; column < columns; ++column) {
            const std::uint32_t a = vertex(ring, column), b = vertex(ring, column + 1);
            const std::uint32_t c = vertex(ring + 1, column), d = vertex(ring + 1, column + 1);
            if (ring > 0) add_triangle(ball.mesh, a, b, c);
            if (ring < rings - 1) add_triangle(ball.mesh, b, d, c);
        }
    // Faces of a triangle of columns come nearest to the axis: half of the radius.
    ball.inner_radius_m = float(radius * (1.0 - bump) * 0.25);
    return ball;
}

std::vector<std::uint32_t> edges_turned_away(const LatticeBall& ball, const DVec3& point) {
    const scene::MeshSource& mesh = ball.mesh;
    std::vector<bool> is_turned_away(mesh.positions.size(), true);
    const auto relative = [&](std::size_t i) { return DVec3(mesh.positions[mesh.indices[i]]) - point; };
    for (std::size_t i = 0; i < mesh.indices.size(); i += 3) {
        // Multiples of 2^-18 below 2^18: exact in double.
        const double volume = glm::dot(relative(i), glm::cross(relative(i + 1), relative(i + 2)));
        if (volume > 0.0) continue;
        for (std::size_t k = 0; k < 3; ++k) is_turned_away[mesh.indices[i + k]] = false;
    }
    std::vector<std::uint32_t> edges;
    for (std::size_t i = 0; i < mesh.indices.size(); i += 3)
        for (std::size_t k = 0; k < 3; ++k) {
            const std::uint32_t a = mesh.indices[i + k], b = mesh.indices[i + (k + 1) % 3];
            if (a < b && is_turned_away[a] && is_turned_away[b]) edges.insert(edges.end(), {a, b});
        }
    return edges;
}

Mat3 random_lattice_turn(test::Random& random, bool may_mirror) {
    int axis[3] = {0, 1, 2};
    std::swap(axis[0], axis[random.below(3)]);
    std::swap(axis[1], axis[1 + random.below(2)]);
    Mat3 turn(0.0f);
    for (int i = 0; i < 3; ++i) turn[i][axis[i]] = random.below(2) == 0 ? 1.0f : -1.0f;
    if (!may_mirror && glm::determinant(turn) < 0.0f) turn[0] = -turn[0];
    return turn;
}

PixelLattice make_pixel_lattice(test::Random& random) {
    constexpr int kSize = 64;
    PixelLattice lattice;
    PinholeView& view = lattice.view;
    view.position = DVec3(double(random.below(4096)), double(random.below(4096)), double(random.below(4096))) / 64.0;
    view.world_from_camera = random_lattice_turn(random, false);
    view.width = view.height = kSize;
    view.u_step = 2.0f / kSize;
    view.u_first = -1.0f;
    view.v_step = -2.0f / kSize;
    view.v_first = 1.0f;
    lattice.eye_inside = random.below(2) == 0;

    // Lines of pixels that carry vertices, the same in rows and columns.
    std::vector<int> lines;
    int line = lattice.eye_inside ? -1 - int(random.below(4)) : int(random.below(12));
    const int end = lattice.eye_inside ? kSize : kSize - int(random.below(12));
    const std::uint32_t widest = 1 + random.below(9);
    lines.push_back(line);
    while (line < end && (lattice.eye_inside || line < kSize - 10))
        lines.push_back(line += 1 + int(random.below(widest)));
    lattice.low = lines.front();
    lattice.high = lines.back();

    scene::MeshSource& mesh = lattice.mesh;
    const auto count = std::uint32_t(lines.size());
    for (const int y : lines)
        for (const int x : lines) {
            // The outline lies behind all else, so that the cone does, too.
            const bool is_rim = x == lattice.low || x == lattice.high || y == lattice.low || y == lattice.high;
            const float depth = is_rim && !lattice.eye_inside ? 2.0f : 1.0f + float(random.below(64)) / 64.0f;
            add_vertex(mesh,
                       view.world_from_camera * (depth * Vec3((float(x) + 0.5f) * view.u_step + view.u_first,
                                                              (float(y) + 0.5f) * view.v_step + view.v_first, -1.0f)));
        }
    for (std::uint32_t j = 0; j + 1 < count; ++j)
        for (std::uint32_t i = 0; i + 1 < count; ++i) {
            const std::uint32_t a = j * count + i, b = a + 1, c = a + count, d = c + 1;
            if (random.below(2) == 0) {
                add_triangle(mesh, a, c, d);
                add_triangle(mesh, a, d, b);
            } else {
                add_triangle(mesh, a, c, b);
                add_triangle(mesh, b, c, d);
            }
        }
    // Closed by a cone over the outline.
    const std::uint32_t apex =
        add_vertex(mesh, view.world_from_camera * Vec3(0, 0, lattice.eye_inside ? 4.0f : -16.0f));
    for (std::uint32_t i = 0; i + 1 < count; ++i) {
        const std::uint32_t last = count - 1;
        add_triangle(mesh, i, i + 1, apex);
        add_triangle(mesh, last * count + i + 1, last * count + i, apex);
        add_triangle(mesh, (i + 1) * count, i * count, apex);
        add_triangle(mesh, i * count + last, (i + 1) * count + last, apex);
    }
    return lattice;
}

}  // namespace ff::hardcases
