#include "tools/cook/city_block.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>

namespace ff::cook::city {
namespace {

constexpr double kPiece = 10.0;  // m

Vec2 ground_uv(const DVec2& p) {
    return Vec2(p.x / kGroundTile, -p.y / kGroundTile);
}

}  // namespace

void BlockWriter::prop(CityProp::Kind kind, const DVec2& p, const DVec2& facing, double lift) {
    props.push_back({kind, on_ground(p, lift), glm::degrees(std::atan2(facing.x, facing.y))});
}

void BlockWriter::ground_quad(const Quad& quad, int columns, int rows, double lift, std::uint32_t material,
                              std::uint32_t color) {
    for (int r = 0; r < rows; ++r)
        for (int c = 0; c < columns; ++c) {
            const Quad p =
                part_of(quad, double(c) / columns, double(c + 1) / columns, double(r) / rows, double(r + 1) / rows);
            mesh.flat_quad({on_ground(p[0], lift), on_ground(p[1], lift), on_ground(p[2], lift), on_ground(p[3], lift)},
                           {ground_uv(p[0]), ground_uv(p[1]), ground_uv(p[2]), ground_uv(p[3])}, material, color);
        }
}

void BlockWriter::ground_ring(const Quad& outer, const Quad& inner, const std::array<int, 2>& pieces, double lift,
                              std::uint32_t material, std::uint32_t color) {
    for (int side = 0; side < 4; ++side) {
        const int next = (side + 1) % 4;
        ground_quad({outer[side], outer[next], inner[next], inner[side]}, pieces[side % 2], 1, lift, material, color);
    }
}

std::array<int, 2> pieces_of(const Quad& q) {
    const auto count = [](double a, double b) { return std::max(1, int(std::ceil(std::max(a, b) / kPiece))); };
    return {count(glm::length(q[1] - q[0]), glm::length(q[2] - q[3])),
            count(glm::length(q[2] - q[1]), glm::length(q[3] - q[0]))};
}

}  // namespace ff::cook::city
