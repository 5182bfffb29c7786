#pragma once
// Terrain: a regular grid of heights, drawn as a right-triangulated irregular network (RTIN), whose triangles are as
// large as the allowed height error lets them be. The mesh has no cracks: a vertex is there for all its neighbours or
// for none.
// Based on: Evans, Kirkpatrick, Townsend, "Right-Triangulated Irregular Networks", Algorithmica 30, 2001;
//   the error pyramid over a square grid as in Lindstrom and Pascucci, "Visualization of Large Terrains Made Easy",
//   IEEE Visualization 2001. Ours differs: the error bound is uniform, as the viewer may go anywhere.

#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <vector>

#include "engine/core/result.h"
#include "engine/math/types.h"
#include "tools/cook/ground_frame.h"
#include "tools/cook/world_source.h"

namespace ff::cook {

/// Heights at the corners of a grid: row 0 in the north (smallest z), column 0 in the west; row-major.
struct HeightField {
    double low_x = 0, low_z = 0;  ///< world position of sample (0, 0)
    double spacing_x = 1, spacing_z = 1;
    int columns = 0, rows = 0;  ///< each at least 2
    std::vector<float> heights;

    [[nodiscard]] double high_x() const { return low_x + spacing_x * (columns - 1); }
    [[nodiscard]] double high_z() const { return low_z + spacing_z * (rows - 1); }
    [[nodiscard]] float at(int column, int row) const { return heights[std::size_t(row) * columns + column]; }
    /// Bilinear; clamped to the border.
    [[nodiscard]] double sample(double x, double z) const;
    /// From central differences on the grid, unit.
    [[nodiscard]] Vec3 normal_at(int column, int row) const;
};

struct RectXZ {
    double x0 = 0, z0 = 0, x1 = 0, z1 = 0;
    [[nodiscard]] bool contains(double x, double z) const { return x >= x0 && x <= x1 && z >= z0 && z <= z1; }
};

struct HeightFileSettings {
    std::optional<std::array<double, 2>> size_m;    ///< x, z; crops georeferenced files, stretches others
    std::optional<std::array<double, 2>> center_m;  ///< x, z of the middle; default: the origin
    std::optional<std::array<double, 2>> height_m;  ///< of values 0 and 65535 of a 16-bit image
    std::optional<double> spacing_m;                ///< default: the file's own
    double vertical_scale = 1.0;
};

/// Reads a height file through GDAL: GeoTIFF, SRTM .hgt, ASCII grid, 16-bit PNG. Georeferenced ones are warped to the
/// tangent plane of `frame`; where there is no frame yet the file's middle becomes it. Voids are filled from around.
/// Errors: bad_input for a file that is no raster, has no usable size, or holds only voids.
[[nodiscard]] Result<HeightField> read_height_file(const std::filesystem::path& path,
                                                   const HeightFileSettings& settings,
                                                   std::optional<GroundFrame>& frame);

/// The RTIN over a height field.
class Terrain {
  public:
    /// @param max_error_m  the mesh is nowhere further from the field, vertically, at any sample. >= 0
    /// @param exact        rectangles within which, and along whose borders, every sample is kept
    Terrain(HeightField field, double max_error_m, const std::vector<RectXZ>& exact = {});
    /// @param errors  what errors() of a terrain of the same field and rectangles gave
    Terrain(HeightField field, double max_error_m, std::vector<float> errors);

    /// How far the mesh would be off, by sample, if it left that sample out.
    [[nodiscard]] const std::vector<float>& errors() const { return errors_; }

    [[nodiscard]] const HeightField& field() const { return field_; }
    [[nodiscard]] bool covers(double x, double z) const;
    /// Height of the mesh itself; nullopt beyond the border.
    [[nodiscard]] std::optional<double> height_at(double x, double z) const;

    /// A vertex of the mesh, as the look needs it.
    struct Look {
        std::uint32_t material = 0;        ///< of triangles whose three corners are gentle
        std::uint32_t steep_material = 0;  ///< of the others
        double steep_cos = 0.0;            ///< a triangle is steep where its normal's y is below this
        double texture_size_m = 12.0;
        std::function<std::uint32_t(double x, double y, double z, const Vec3& normal)> color;  ///< may be empty
    };
    /// Appends the mesh, in chunks of about `chunk_samples` samples a side, as static placements.
    void add_to(WorldSource& world, const Look& look, int chunk_samples = 64) const;

  private:
    struct Corner {
        int x, z;
    };
    [[nodiscard]] float error_at(int x, int z) const { return errors_[std::size_t(z) * side_ + x]; }
    [[nodiscard]] DVec3 position(Corner c) const;
    [[nodiscard]] bool is_split(Corner a, Corner b, Corner apex) const;
    [[nodiscard]] bool is_outside(Corner a, Corner b, Corner c) const;
    /// The most that a triangle is off at any sample within; +inf where it reaches over the border, 0 outside.
    [[nodiscard]] float deviation(Corner a, Corner b, Corner apex) const;
    void compute_errors(const std::vector<RectXZ>& exact);
    template <class Visit>
    void visit_triangles(Corner a, Corner b, Corner apex, const Visit& visit) const;

    HeightField field_;
    float max_error_ = 0;
    int side_ = 0;  ///< samples a side of the square that holds the field, 2^k + 1
    std::vector<float> errors_;
};

}  // namespace ff::cook
