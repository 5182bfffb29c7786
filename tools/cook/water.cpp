#include "tools/cook/water.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <limits>

#include "tools/cook/mesh_builder.h"

namespace ff::cook {
namespace {

constexpr double kShoreM = 45.0;  ///< from the outline to the full depth, at most
constexpr double kRiseM = 70.0;   ///< and outwards, until the ground is as it was

double smooth(double t) {
    t = std::clamp(t, 0.0, 1.0);
    return t * t * (3.0 - 2.0 * t);
}

/// Metres to the outline, positive inside.
double inside_m(const std::vector<DVec2>& outline, const DVec2& p) {
    double nearest2 = std::numeric_limits<double>::infinity();
    bool inside = false;
    for (std::size_t i = 0, j = outline.size() - 1; i < outline.size(); j = i++) {
        const DVec2 &a = outline[j], &b = outline[i];
        const DVec2 edge = b - a;
        const double t = std::clamp(glm::dot(p - a, edge) / std::max(glm::dot(edge, edge), 1e-12), 0.0, 1.0);
        const DVec2 off = p - (a + t * edge);
        nearest2 = std::min(nearest2, glm::dot(off, off));
        if ((a.y > p.y) != (b.y > p.y) && p.x < a.x + (p.y - a.y) / (b.y - a.y) * (b.x - a.x)) inside = !inside;
    }
    return inside ? std::sqrt(nearest2) : -std::sqrt(nearest2);
}

/// Columns and rows of samples in reach of an outline.
struct Window {
    int first_column = 0, end_column = 0, first_row = 0, end_row = 0;
};
Window window_of(const WaterDescription& water, const HeightField& field, double margin_m) {
    if (water.outline.empty()) return {0, field.columns, 0, field.rows};
    DVec2 low(std::numeric_limits<double>::infinity()), high = -low;
    for (const DVec2& p : water.outline) {
        low = glm::min(low, p);
        high = glm::max(high, p);
    }
    const auto column = [&](double x) {
        return std::clamp((x - field.low_x) / field.spacing_x, 0.0, double(field.columns));
    };
    const auto row = [&](double z) { return std::clamp((z - field.low_z) / field.spacing_z, 0.0, double(field.rows)); };
    return {int(column(low.x - margin_m)), std::min(field.columns, int(column(high.x + margin_m)) + 2),
            int(row(low.y - margin_m)), std::min(field.rows, int(row(high.y + margin_m)) + 2)};
}

}  // namespace

double water_level_near(std::span<const WaterDescription> waters, double x, double z) {
    double level = -1e6;
    for (const WaterDescription& water : waters)
        if (water.level_m > level && (water.outline.empty() || inside_m(water.outline, {x, z}) > -kRiseM))
            level = water.level_m;
    return level;
}

void dig_bed(const WaterDescription& water, HeightField& field) {
    if (!water.depth_m || water.outline.empty()) return;
    const Window window = window_of(water, field, kRiseM);
    for (int j = window.first_row; j < window.end_row; ++j)
        for (int i = window.first_column; i < window.end_column; ++i) {
            const double inside =
                inside_m(water.outline, {field.low_x + i * field.spacing_x, field.low_z + j * field.spacing_z});
            float& height = field.heights[std::size_t(j) * std::size_t(field.columns) + std::size_t(i)];
            if (inside > 0.0)
                height = float(water.level_m - *water.depth_m * smooth(inside / kShoreM));
            else
                height = float(std::lerp(water.level_m + 0.3, double(height), smooth(-inside / kRiseM)));
        }
}

scene::Material water_material(const WaterDescription& water) {
    scene::Material material;
    material.base_color = Vec4(glm::max(water.bed_color, water.color), 1.0f);
    material.roughness = 0.12f;
    material.alpha_cutoff = float(water.wave_height_m);
    material.flags = scene::kMaterialSpecular | scene::kMaterialWater;
    return material;
}

void add_water_sheet(const WaterDescription& water, const HeightField& field, std::uint32_t material,
                     WorldSource& world) {
    constexpr int kBlock = 16;  // samples; blocks of deep water are one quad
    const Vec3 whole = glm::max(water.bed_color, water.color);
    const double deep_m = 2.0 * water.clarity_m;
    const auto depth_at = [&](int i, int j) { return water.level_m - double(field.at(i, j)); };
    const auto color_at = [&](int i, int j) {
        const double clear = std::exp(-std::log(10.0) * std::max(depth_at(i, j), 0.0) / water.clarity_m);
        return pack_color(glm::mix(water.color, water.bed_color, float(clear)) / glm::max(whole, Vec3(1e-6f)));
    };
    const Window window = window_of(water, field, std::max(field.spacing_x, field.spacing_z));
    MeshBuilder mesh("water", {0, water.level_m, 0});
    const auto add_quad = [&](int i0, int j0, int i1, int j1) {
        const auto corner = [&](int i, int j) {
            return mesh.vertex({field.low_x + i * field.spacing_x, water.level_m, field.low_z + j * field.spacing_z},
                               Vec3(0, 1, 0), Vec2(0.0f), color_at(i, j));
        };
        const std::uint32_t a = corner(i0, j1), b = corner(i1, j1), c = corner(i1, j0), d = corner(i0, j0);
        mesh.triangle(a, b, c, material);
        mesh.triangle(a, c, d, material);
    };
    for (int j0 = window.first_row; j0 + 1 < window.end_row; j0 += kBlock)
        for (int i0 = window.first_column; i0 + 1 < window.end_column; i0 += kBlock) {
            const int i1 = std::min(i0 + kBlock, window.end_column - 1), j1 = std::min(j0 + kBlock, window.end_row - 1);
            double least = std::numeric_limits<double>::infinity(), most = -least;
            for (int j = j0; j <= j1; ++j)
                for (int i = i0; i <= i1; ++i) {
                    least = std::min(least, depth_at(i, j));
                    most = std::max(most, depth_at(i, j));
                }
            if (!(most > 0.0)) continue;
            if (least > deep_m) {
                add_quad(i0, j0, i1, j1);
                continue;
            }
            for (int j = j0; j < j1; ++j)
                for (int i = i0; i < i1; ++i)
                    if (std::max({depth_at(i, j), depth_at(i + 1, j), depth_at(i, j + 1), depth_at(i + 1, j + 1)}) >
                        0.0)
                        add_quad(i, j, i + 1, j + 1);
        }
    add_static_mesh(world, std::move(mesh));
}

}  // namespace ff::cook
