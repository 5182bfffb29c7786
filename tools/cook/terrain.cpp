#include "tools/cook/terrain.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <unordered_map>

#include "engine/core/jobs.h"
#include "tools/cook/mesh_builder.h"

namespace ff::cook {

double HeightField::sample(double x, double z) const {
    const double u = std::clamp((x - low_x) / spacing_x, 0.0, double(columns - 1));
    const double v = std::clamp((z - low_z) / spacing_z, 0.0, double(rows - 1));
    const int i = std::min(int(u), columns - 2), j = std::min(int(v), rows - 2);
    const double fu = u - i, fv = v - j;
    const double north = at(i, j) + fu * (at(i + 1, j) - at(i, j));
    const double south = at(i, j + 1) + fu * (at(i + 1, j + 1) - at(i, j + 1));
    return north + fv * (south - north);
}

Vec3 HeightField::normal_at(int column, int row) const {
    const int w = std::max(column - 1, 0), e = std::min(column + 1, columns - 1);
    const int n = std::max(row - 1, 0), s = std::min(row + 1, rows - 1);
    const double dx = (at(e, row) - at(w, row)) / ((e - w) * spacing_x);
    const double dz = (at(column, s) - at(column, n)) / ((s - n) * spacing_z);
    return Vec3(glm::normalize(DVec3(-dx, 1.0, -dz)));
}

Terrain::Terrain(HeightField field, double max_error_m, std::vector<float> errors)
    : field_(std::move(field)), max_error_(float(max_error_m)), errors_(std::move(errors)) {
    int squares = 2;
    while (squares + 1 < std::max(field_.columns, field_.rows)) squares *= 2;
    side_ = squares + 1;
    errors_.resize(std::size_t(side_) * std::size_t(side_));
}

Terrain::Terrain(HeightField field, double max_error_m, const std::vector<RectXZ>& exact)
    : Terrain(std::move(field), max_error_m, std::vector<float>()) {
    compute_errors(exact);
}

bool Terrain::covers(double x, double z) const {
    return x >= field_.low_x && z >= field_.low_z && x <= field_.high_x() && z <= field_.high_z();
}

DVec3 Terrain::position(Corner c) const {
    c = {std::min(c.x, field_.columns - 1), std::min(c.z, field_.rows - 1)};
    return {field_.low_x + c.x * field_.spacing_x, field_.at(c.x, c.z), field_.low_z + c.z * field_.spacing_z};
}

// The error of a midpoint m: the most that the mesh is off, at any sample, where the two triangles that share the
// hypotenuse through m are not split. It is made at least that of the diamonds inside, so that whoever keeps a small
// diamond's midpoint keeps all larger ones around it, which is what leaves no cracks.
//
// Step s = 1, 2, 4, ..: first the midpoints of axis-aligned hypotenuses of length 2 s, then of diagonals across squares
// of side 2 s; each looks at the four midpoints of the step before it. Every step visits every sample: n log n.
void Terrain::compute_errors(const std::vector<RectXZ>& exact) {
    struct SampleRect {
        int x0, z0, x1, z1;
    };
    std::vector<SampleRect> exact_samples;
    for (const RectXZ& r : exact) {
        const auto column = [&](double x) { return int(std::clamp((x - field_.low_x) / field_.spacing_x, -1e6, 1e6)); };
        const auto row = [&](double z) { return int(std::clamp((z - field_.low_z) / field_.spacing_z, -1e6, 1e6)); };
        exact_samples.push_back({column(r.x0) - 1, row(r.z0) - 1, column(r.x1) + 2, row(r.z1) + 2});
    }
    const auto is_exact = [&](int x, int z, int s) {
        return std::any_of(exact_samples.begin(), exact_samples.end(), [&](const SampleRect& r) {
            return x + s > r.x0 && x - s < r.x1 && z + s > r.z0 && z - s < r.z1;
        });
    };
    const auto known = [&](int x, int z) { return x < 0 || z < 0 || x >= side_ || z >= side_ ? 0.0f : error_at(x, z); };
    const float infinite = std::numeric_limits<float>::infinity();

    for (int s = 1; 2 * s < side_; s *= 2) {
        const std::size_t row_count = std::size_t((side_ - 1) / s + 1);
        parallel_ranges(row_count, 4, [&](std::size_t begin, std::size_t end) {
            for (std::size_t r = begin; r < end; ++r) {
                const int z = int(r) * s, q = s / 2;
                const bool upright = r % 2 == 1;  // the hypotenuse runs along z
                for (int x = upright ? 0 : s; x < side_; x += 2 * s) {
                    const int dx = upright ? 0 : s, dz = s - dx;
                    float error = is_exact(x, z, s) ? infinite : 0.0f;
                    for (const int side : {-1, 1}) {
                        const Corner apex{x + side * dz, z + side * dx};
                        if (apex.x < 0 || apex.z < 0 || apex.x >= side_ || apex.z >= side_) continue;
                        error = std::max(error, deviation({x - dx, z - dz}, {x + dx, z + dz}, apex));
                    }
                    if (s > 1)
                        error = std::max({error, known(x - q, z - q), known(x + q, z - q), known(x - q, z + q),
                                          known(x + q, z + q)});
                    errors_[std::size_t(z) * side_ + x] = error;
                }
            }
        });
        // The diagonal of a square runs through the centre of the square of twice the size.
        parallel_ranges(row_count / 2, 4, [&](std::size_t begin, std::size_t end) {
            for (std::size_t r = begin; r < end; ++r) {
                const int z = int(2 * r + 1) * s;
                for (int x = s; x < side_; x += 2 * s) {
                    const int turn = ((x / (2 * s)) + int(r)) % 2 == 0 ? s : -s;
                    const Corner a{x - s, z - turn}, b{x + s, z + turn};
                    float error = is_exact(x, z, s) ? infinite : 0.0f;
                    error = std::max({error, deviation(a, b, {a.x, b.z}), deviation(a, b, {b.x, a.z}),
                                      error_at(x - s, z), error_at(x + s, z), error_at(x, z - s), error_at(x, z + s)});
                    errors_[std::size_t(z) * side_ + x] = error;
                }
            }
        });
    }
}

float Terrain::deviation(Corner a, Corner b, Corner apex) const {
    if (is_outside(a, b, apex)) return 0.0f;
    const int x0 = std::min({a.x, b.x, apex.x}), x1 = std::max({a.x, b.x, apex.x});
    const int z0 = std::min({a.z, b.z, apex.z}), z1 = std::max({a.z, b.z, apex.z});
    if (x1 >= field_.columns || z1 >= field_.rows)
        return std::numeric_limits<float>::infinity();  // straddles the border
    const auto twice_area = [](Corner p, Corner q, int x, int z) {
        return (q.x - p.x) * (z - p.z) - (q.z - p.z) * (x - p.x);
    };
    if (twice_area(a, b, apex.x, apex.z) < 0) std::swap(a, b);
    const float total = float(twice_area(a, b, apex.x, apex.z));
    const float ha = field_.at(a.x, a.z), hb = field_.at(b.x, b.z), hc = field_.at(apex.x, apex.z);
    float worst = 0;
    for (int z = z0; z <= z1; ++z) {
        // Weights change by whole numbers along a row.
        int wa = twice_area(b, apex, x0, z), wb = twice_area(apex, a, x0, z), wc = twice_area(a, b, x0, z);
        const float* heights = &field_.heights[std::size_t(z) * std::size_t(field_.columns)];
        for (int x = x0; x <= x1; ++x) {
            if ((wa | wb | wc) >= 0)
                worst =
                    std::max(worst, std::abs((float(wa) * ha + float(wb) * hb + float(wc) * hc) / total - heights[x]));
            wa -= apex.z - b.z, wb -= a.z - apex.z, wc -= b.z - a.z;
        }
    }
    return worst;
}

bool Terrain::is_split(Corner a, Corner b, Corner apex) const {
    if (std::abs(a.x - apex.x) + std::abs(a.z - apex.z) <= 1) return false;  // legs of one sample: nothing in between
    return error_at((a.x + b.x) / 2, (a.z + b.z) / 2) > max_error_;
}

bool Terrain::is_outside(Corner a, Corner b, Corner c) const {
    return std::min({a.x, b.x, c.x}) >= field_.columns - 1 || std::min({a.z, b.z, c.z}) >= field_.rows - 1;
}

template <class Visit>
void Terrain::visit_triangles(Corner a, Corner b, Corner apex, const Visit& visit) const {
    if (is_outside(a, b, apex)) return;
    if (!is_split(a, b, apex)) {
        visit(a, b, apex);
        return;
    }
    const Corner middle{(a.x + b.x) / 2, (a.z + b.z) / 2};
    visit_triangles(apex, a, middle, visit);
    visit_triangles(b, apex, middle, visit);
}

std::optional<double> Terrain::height_at(double x, double z) const {
    if (!covers(x, z)) return std::nullopt;
    const double u = (x - field_.low_x) / field_.spacing_x, v = (z - field_.low_z) / field_.spacing_z;
    // Twice the signed area of (p, q, (u, v)).
    const auto side_of = [&](Corner p, Corner q) { return (q.x - p.x) * (v - p.z) - (q.z - p.z) * (u - p.x); };
    const int n = side_ - 1;
    Corner a{0, 0}, b{n, n}, apex{n, 0};
    if (v > u) {
        std::swap(a, b);
        apex = {0, n};
    }
    while (is_split(a, b, apex)) {
        const Corner middle{(a.x + b.x) / 2, (a.z + b.z) / 2};
        const bool on_side_of_a = (side_of(apex, middle) >= 0) ==
                                  ((middle.x - apex.x) * (a.z - apex.z) - (middle.z - apex.z) * (a.x - apex.x) >= 0);
        if (on_side_of_a) {
            b = a;
            a = apex;
        } else {
            a = b;
            b = apex;
        }
        apex = middle;
    }
    const double total = double(b.x - a.x) * (apex.z - a.z) - double(b.z - a.z) * (apex.x - a.x);
    const double wa = side_of(b, apex) / total, wb = side_of(apex, a) / total;
    return wa * position(a).y + wb * position(b).y + (1.0 - wa - wb) * position(apex).y;
}

void Terrain::add_to(WorldSource& world, const Look& look, int chunk_samples) const {
    // The tops of the chunks: triangles of the hierarchy of about the asked size, or larger ones that are not split.
    struct Triangle {
        Corner a, b, apex;
    };
    std::vector<Triangle> tops;
    const auto collect = [&](auto&& self, Corner a, Corner b, Corner apex) -> void {
        if (is_outside(a, b, apex)) return;
        const int hypotenuse = std::max(std::abs(a.x - b.x), std::abs(a.z - b.z));
        if (hypotenuse <= chunk_samples || !is_split(a, b, apex)) {
            tops.push_back({a, b, apex});
            return;
        }
        const Corner middle{(a.x + b.x) / 2, (a.z + b.z) / 2};
        self(self, apex, a, middle);
        self(self, b, apex, middle);
    };
    const int n = side_ - 1;
    collect(collect, {0, 0}, {n, n}, {n, 0});
    collect(collect, {n, n}, {0, 0}, {0, n});

    std::vector<SourceMesh> meshes(tops.size());
    std::vector<DVec3> origins(tops.size());
    parallel_for(tops.size(), [&](std::size_t t) {
        const Triangle& top = tops[t];
        const DVec3 origin = glm::floor(position({(top.a.x + top.b.x) / 2, (top.a.z + top.b.z) / 2}));
        // Texture coordinates count from a whole number of tiles near the chunk, to keep their digits.
        const double tile_x = std::floor(origin.x / look.texture_size_m),
                     tile_z = std::floor(origin.z / look.texture_size_m);
        MeshBuilder builder(fmt::format("terrain {}", t), origin);
        std::unordered_map<std::uint64_t, std::uint32_t> vertices;
        const auto vertex = [&](Corner c) {
            const auto [place, is_new] = vertices.try_emplace(std::uint64_t(c.z) << 32 | std::uint32_t(c.x), 0u);
            if (is_new) {
                const DVec3 p = position(c);
                const Vec3 normal = field_.normal_at(c.x, c.z);
                const Vec2 uv(p.x / look.texture_size_m - tile_x, p.z / look.texture_size_m - tile_z);
                place->second = builder.vertex(p, normal, uv, look.color ? look.color(p.x, p.y, p.z, normal) : kWhite);
            }
            return place->second;
        };
        visit_triangles(top.a, top.b, top.apex, [&](Corner a, Corner b, Corner apex) {
            const DVec3 pa = position(a), pb = position(b), pc = position(apex);
            const DVec3 normal = glm::normalize(glm::cross(pb - pa, pc - pa));
            const bool steep = std::abs(normal.y) < look.steep_cos;
            const std::uint32_t material = steep ? look.steep_material : look.material;
            if (normal.y >= 0)
                builder.triangle(vertex(a), vertex(b), vertex(apex), material);
            else
                builder.triangle(vertex(b), vertex(a), vertex(apex), material);
        });
        origins[t] = origin;
        meshes[t] = builder.take();
    });
    for (std::size_t t = 0; t < tops.size(); ++t) {
        if (meshes[t].geometry.indices.empty()) continue;
        Placement placement;
        placement.mesh = std::uint32_t(world.meshes.size());
        placement.position = origins[t];
        placement.stands_clear = true;
        world.meshes.push_back(std::move(meshes[t]));
        world.placements.push_back(placement);
    }
}

}  // namespace ff::cook
