#include "tools/cook/city.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

#include "engine/core/jobs.h"
#include "tools/cook/city_block.h"

namespace ff::cook::city {
namespace {

constexpr double kGrowthMargin = 1.12;  // how much further the city may reach than its area's root says
constexpr std::size_t kBatch = 32;      // blocks built before their triangles are counted

/// What a finished block adds to the world.
struct BuiltBlock {
    WorldPos origin{0.0};
    SourceMesh mesh;
    Quad ground{};
    std::vector<Quad> buildings;
    std::vector<CityProp> props;
};

BuiltBlock build_block(const CityPlan& plan, const CityMaterials& materials, const GroundHeight& ground,
                       BlockIndex index) {
    const CityBlock block = plan.block(index);
    const DVec2 middle = point_in(block.kerb, 0.5, 0.5);
    const WorldPos origin(std::round(middle.x), std::round(ground(middle.x, -middle.y)), std::round(-middle.y));
    BlockWriter writer{
        plan, materials, ground, block, MeshBuilder(fmt::format("city block {} {}", index.column, index.row), origin),
        {},   {}};
    const Quad inside = add_streets(writer);
    switch (block.kind) {
        case BlockKind::downtown:
            add_downtown(writer, inside);
            break;
        case BlockKind::perimeter:
            add_perimeter(writer, inside);
            break;
        case BlockKind::houses:
            add_houses(writer, inside);
            break;
        case BlockKind::park:
            add_park(writer, inside);
            break;
        case BlockKind::square:
            add_square(writer, inside);
            break;
    }
    BuiltBlock built{origin, writer.mesh.take(), plan.with_streets(index), std::move(writer.buildings),
                     std::move(writer.props)};
    // Large cities are kept whole in memory: give back what growing left over.
    scene::MeshSource& g = built.mesh.geometry;
    g.positions.shrink_to_fit();
    g.attributes.shrink_to_fit();
    g.indices.shrink_to_fit();
    g.triangle_materials.shrink_to_fit();
    return built;
}

Quad in_world(const Quad& plan) {
    Quad world;
    std::transform(plan.begin(), plan.end(), world.begin(), [](const DVec2& p) { return DVec2(p.x, -p.y); });
    return world;
}

double first_reach(const CitySettings& settings, const CityPlan& plan) {
    return 0.5 * settings.size_m - 0.25 * plan.pitch();
}

double last_reach(const CitySettings& settings, const CityPlan& plan) {
    return first_reach(settings, plan) * (settings.scale > 1 ? kGrowthMargin * std::sqrt(settings.scale) : 1.0);
}

}  // namespace

double city_flat_radius_m(const CitySettings& settings) {
    const CityPlan plan(settings);
    // The norm of order 4 leaves the diagonal 2^(1/4) times as far as the axes; then the outermost block and street.
    return 1.19 * last_reach(settings, plan) * 1.03 + plan.pitch();
}

void add_city(const CitySettings& settings, const CityTextures& textures, const GroundHeight& ground, WorldSource& into,
              CitySite& site) {
    const CityPlan plan(settings);
    const CityMaterials materials = add_city_materials(textures, into);
    const std::vector<BlockIndex> order = plan.blocks_within(last_reach(settings, plan));
    const double first = first_reach(settings, plan);
    const std::size_t first_count = std::size_t(
        std::partition_point(order.begin(), order.end(), [&](BlockIndex index) { return plan.reach(index) <= first; }) -
        order.begin());

    std::vector<BuiltBlock> built;
    std::size_t triangles = 0;
    const auto build = [&](std::size_t end) {
        const std::size_t begin = built.size();
        built.resize(end);
        parallel_for(end - begin,
                     [&](std::size_t i) { built[begin + i] = build_block(plan, materials, ground, order[begin + i]); });
        for (std::size_t i = begin; i < end; ++i) triangles += built[i].mesh.geometry.triangle_materials.size();
    };
    build(first_count);
    const double wanted = settings.scale * double(triangles);
    while (double(triangles) < wanted && built.size() < order.size())
        build(std::min(built.size() + kBatch, order.size()));

    for (BuiltBlock& block : built) {
        Placement placement;
        placement.mesh = std::uint32_t(into.meshes.size());
        placement.position = block.origin;
        placement.stands_clear = true;  // what shares a plane here is of one material, or under the ground
        into.meshes.push_back(std::move(block.mesh));
        into.placements.push_back(placement);
        site.blocks.push_back(in_world(block.ground));
        for (const Quad& quad : block.buildings) site.buildings.push_back(in_world(quad));
        site.props.insert(site.props.end(), std::make_move_iterator(block.props.begin()),
                          std::make_move_iterator(block.props.end()));
    }
}

}  // namespace ff::cook::city
