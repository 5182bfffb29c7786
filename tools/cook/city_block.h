#pragma once
// What the parts of one block are written into, and who writes which.

#include <vector>

#include "tools/cook/buildings_facade.h"
#include "tools/cook/city_materials.h"
#include "tools/cook/city_plan.h"
#include "tools/cook/mesh_builder.h"

namespace ff::cook::city {

inline constexpr double kRoadLift = 0.05, kPavementLift = 0.17, kPaintLift = 0.02;  // metres above the ground, the road

struct BlockWriter {
    const CityPlan& plan;
    const CityMaterials& materials;
    const GroundHeight& ground;
    CityBlock block;
    MeshBuilder mesh;
    std::vector<Quad> buildings;
    std::vector<CityProp> props;

    [[nodiscard]] double ground_at(const DVec2& p) const { return ground(p.x, -p.y); }
    /// The point on what lies `lift` above the ground.
    [[nodiscard]] DVec3 on_ground(const DVec2& p, double lift) const { return world_from_plan(p, ground_at(p) + lift); }
    /// @param facing  plan; need not be unit
    void prop(CityProp::Kind kind, const DVec2& p, const DVec2& facing, double lift = kPavementLift);

    /// A quad that follows the ground, in `columns` x `rows` pieces; textured by its place.
    void ground_quad(const Quad& quad, int columns, int rows, double lift, std::uint32_t material,
                     std::uint32_t color = kWhite);
    /// The ring between two quads, side i in pieces[i % 2] pieces.
    void ground_ring(const Quad& outer, const Quad& inner, const std::array<int, 2>& pieces, double lift,
                     std::uint32_t material, std::uint32_t color = kWhite);
};

/// Pieces of at most 10 m for sides 0 and 2, and for sides 1 and 3.
[[nodiscard]] std::array<int, 2> pieces_of(const Quad& quad);

/// The streets and crossings that belong to the block, their markings, kerbs, pavements and lamps.
/// @return the ground within the pavements, which lies level with them and is not covered yet
Quad add_streets(BlockWriter& writer);

void add_downtown(BlockWriter& writer, const Quad& inside);
void add_perimeter(BlockWriter& writer, const Quad& inside);
void add_houses(BlockWriter& writer, const Quad& inside);
void add_park(BlockWriter& writer, const Quad& inside);
void add_square(BlockWriter& writer, const Quad& inside);

}  // namespace ff::cook::city
