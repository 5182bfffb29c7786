#pragma once
// Instances by rule: trees, rocks, bushes over an area.

#include <array>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "tools/cook/buildings_footprint.h"
#include "tools/cook/gltf_import.h"
#include "tools/cook/terrain.h"
#include "tools/cook/world_source.h"

namespace ff::cook {

/// What stands on the ground already, for asking whether a point is free.
class Obstacles {
  public:
    void add(const Footprint& footprint);
    void add(const RectXZ& rect);
    /// Sorts what was added into squares; call once before the first question.
    void finish();
    /// @param margin_m  free of anything this near, for footprints by their corners' and sides' distance. At most 8
    [[nodiscard]] bool is_free(double x, double z, double margin_m) const;

  private:
    struct Square {
        long x, z;
        std::uint32_t footprint;
    };
    std::vector<Footprint> footprints_;
    std::vector<RectXZ> rects_;
    std::vector<Square> squares_;  ///< sorted by (x, z)
};

struct ScatterRule {
    double density_per_km2 = 0;
    RectXZ area;
    std::vector<Footprint> polygons;  ///< where not empty: only within
    double slope_max_deg = 90;
    double clump_m = 0;                             ///< woods and clearings of about this size; 0: even
    std::optional<std::array<double, 2>> height_m;  ///< only where the ground lies between these
    std::array<double, 2> scale{1, 1};
    std::uint64_t seed = 1;
    std::vector<double> weights;  ///< one per model
};

/// The ground, by (x, z): nullopt where there is none.
using GroundHeight = std::function<std::optional<double>(double, double)>;

/// Appends instances of the models: one place is tried in every square of 1 / density, jittered within it, so that
/// places are neither aligned nor crowded. Each decision hashes the square's number: the same for any number of
/// workers.
void scatter(std::span<const Model> models, const ScatterRule& rule, const GroundHeight& ground,
             const Obstacles& obstacles, WorldSource& world);

/// Rotation about the upright axis, times a scale; yaw clockwise seen from above.
[[nodiscard]] DMat3 world_from_yaw(double yaw_deg, double scale);

}  // namespace ff::cook
