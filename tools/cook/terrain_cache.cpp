#include "tools/cook/terrain_cache.h"

#include "tools/cook/cook_bytes.h"

namespace ff::cook {
namespace {

// Bump when the step's output changes for the same input.
constexpr const char* kValleyStep = "valley 1";
constexpr const char* kErrorsStep = "terrain errors 1";

struct FieldFrame {
    double low_x, low_z, spacing_x, spacing_z;
    std::int64_t columns, rows;
};

FieldFrame frame_of(const HeightField& field) {
    return {field.low_x, field.low_z, field.spacing_x, field.spacing_z, field.columns, field.rows};
}

}  // namespace

HeightField make_valley_cached(const ValleySettings& s, CookCache& cache) {
    const CacheKey key = CacheKey(kValleyStep)
                             .add_value(s.seed)
                             .add_value(s.size_m)
                             .add_value(s.spacing_m)
                             .add_value(s.relief_m)
                             .add_value(s.floor_width_m)
                             .add_value(s.water_m);
    if (const auto found = cache.find(key)) {
        ByteReader in(*found);
        FieldFrame frame{};
        in.value(frame);
        HeightField field{frame.low_x,     frame.low_z, frame.spacing_x, frame.spacing_z, int(frame.columns),
                          int(frame.rows), {}};
        in.array(field.heights);
        return field;
    }
    HeightField field = make_valley(s);
    ByteWriter out;
    out.value(frame_of(field));
    out.array(field.heights);
    cache.store(key, out.bytes());
    return field;
}

Terrain make_terrain_cached(HeightField field, double max_error_m, const std::vector<RectXZ>& exact, CookCache& cache) {
    if (!cache.enabled()) return Terrain(std::move(field), max_error_m, exact);
    const CacheKey key = CacheKey(kErrorsStep).add_value(frame_of(field)).add_array(field.heights).add_array(exact);
    if (const auto found = cache.find(key)) {
        std::vector<float> errors;
        ByteReader(*found).array(errors);
        return Terrain(std::move(field), max_error_m, std::move(errors));
    }
    Terrain terrain(std::move(field), max_error_m, exact);
    ByteWriter out;
    out.array(terrain.errors());
    cache.store(key, out.bytes());
    return terrain;
}

}  // namespace ff::cook
