#pragma once
// A city made by rule: a slightly irregular grid of streets, high-rises in the middle, perimeter blocks around them,
// houses with gardens at the edge. All of it is geometry: windows, doors, ledges, balconies, kerbs, lane markings.

#include <array>
#include <cstdint>
#include <functional>
#include <vector>

#include "engine/math/types.h"
#include "tools/cook/buildings_footprint.h"
#include "tools/cook/world_source.h"

namespace ff::cook::city {

/// Height of the ground at (x, z), metres.
using GroundHeight = std::function<double(double x, double z)>;

struct CitySettings {
    std::uint32_t seed = 1;
    double center_x = 0, center_z = 0;  ///< world, metres
    double size_m = 1200;               ///< across, at scale 1. [300, 20000]
    double block_m = 90;                ///< side of a block between its streets, on average. [60, 120]
    double street_m = 14;               ///< of a usual street, kerb to kerb; avenues are 26 m. [12, 20]
    double downtown_m = 350;            ///< radius within which the high-rises stand. [0, size_m]
    double max_height_m = 110;          ///< of the high-rises. [20, 300]
    double detail = 1.0;                ///< more and narrower bays with more trim above 1. [0.25, 4]
    double scale = 1;                   ///< this many times the triangles, by growing around the centre. [1, 1000]
};

/// Ids of WorldSource::textures, scene::kNoTexture where there is none. Walls need none: their brick, plaster, stone
/// and concrete are made with the city.
struct CityTextures {
    std::uint32_t asphalt = scene::kNoTexture, pavement = scene::kNoTexture;    ///< a tile covers 4 x 4 m
    std::uint32_t grass = scene::kNoTexture, gravel = scene::kNoTexture;        ///< 4 x 4 m
    std::uint32_t roof_red = scene::kNoTexture, roof_dark = scene::kNoTexture;  ///< 3 x 3 m
};

/// Where the caller may place an instance of a model that he has.
struct CityProp {
    enum class Kind : std::uint8_t { street_lamp, bench, street_tree, park_tree, garden_tree, bush };
    Kind kind = Kind::street_lamp;
    DVec3 position{0.0};   ///< of its foot
    double yaw_deg = 0.0;  ///< clockwise from north: lamps lean over the street, benches face it
};

/// What the city leaves for those who build around it.
struct CitySite {
    std::vector<std::array<DVec2, 4>> blocks;     ///< with their streets; (x, z), they tile the city's ground
    std::vector<std::array<DVec2, 4>> buildings;  ///< convex outlines, (x, z)
    std::vector<CityProp> props;
};

/// Around the centre, how far the ground ought to be level or gently sloping: all of the city lies within.
[[nodiscard]] double city_flat_radius_m(const CitySettings& settings);

/// Appends the city's materials (fewer than 24) and one static mesh for every block. A block depends on the seed, its
/// place and the settings other than `scale`: a larger scale adds blocks around the same ones.
/// Streets lie 5 cm, pavements 17 cm above the ground as the callback tells it, which is asked at least every 12 m and
/// from several threads at once.
/// Parallel over blocks; the number of workers never changes the result. About 70 bytes a triangle.
void add_city(const CitySettings& settings, const CityTextures& textures, const GroundHeight& ground, WorldSource& into,
              CitySite& site);

}  // namespace ff::cook::city
