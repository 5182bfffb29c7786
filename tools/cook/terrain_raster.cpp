// Height files through GDAL.

#include <cpl_conv.h>
#include <cpl_error.h>
#include <fmt/core.h>
#include <gdal_priv.h>
#include <gdal_utils.h>
#include <ogr_spatialref.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <string>

#include "tools/cook/gdal_session.h"
#include "tools/cook/terrain.h"

namespace ff::cook {
namespace {

constexpr int kMaxSamplesPerSide = 8193;
constexpr float kVoid = -1e30f;

struct WarpOptionsDeleter {
    void operator()(GDALWarpAppOptions* options) const { GDALWarpAppOptionsFree(options); }
};

bool is_void(float value, double no_data, bool has_no_data) {
    return !std::isfinite(value) || value <= -32768.0f || value > 1e6f || (has_no_data && double(value) == no_data);
}

/// Reads band 1 as float32 with every void as kVoid.
Result<std::vector<float>> read_band(GDALDataset& dataset, const std::string& name) {
    GDALRasterBand* band = dataset.GetRasterBand(1);
    const int columns = dataset.GetRasterXSize(), rows = dataset.GetRasterYSize();
    std::vector<float> values(std::size_t(columns) * rows);
    if (band->RasterIO(GF_Read, 0, 0, columns, rows, values.data(), columns, rows, GDT_Float32, 0, 0, nullptr) !=
        CE_None)
        return bad_input(fmt::format("{}: its heights cannot be read: {}", name, CPLGetLastErrorMsg()));
    int has_no_data = 0;
    const double no_data = band->GetNoDataValue(&has_no_data);
    for (float& value : values)
        if (is_void(value, no_data, has_no_data != 0)) value = kVoid;
    return values;
}

/// Fills voids from the heights around them: means over ever larger squares, then bilinear back down (push-pull).
/// @return false where everything is void.
bool fill_voids(std::vector<float>& values, int columns, int rows) {
    if (std::find(values.begin(), values.end(), kVoid) == values.end()) return true;
    if (columns <= 1 && rows <= 1) return values[0] != kVoid;
    const int half_columns = (columns + 1) / 2, half_rows = (rows + 1) / 2;
    std::vector<float> half(std::size_t(half_columns) * half_rows, kVoid);
    for (int j = 0; j < half_rows; ++j)
        for (int i = 0; i < half_columns; ++i) {
            double sum = 0;
            int count = 0;
            for (int dj = 0; dj < 2; ++dj)
                for (int di = 0; di < 2; ++di) {
                    const int x = 2 * i + di, z = 2 * j + dj;
                    if (x >= columns || z >= rows || values[std::size_t(z) * columns + x] == kVoid) continue;
                    sum += values[std::size_t(z) * columns + x];
                    ++count;
                }
            if (count > 0) half[std::size_t(j) * half_columns + i] = float(sum / count);
        }
    if (!fill_voids(half, half_columns, half_rows)) return false;
    HeightField coarse{.columns = half_columns, .rows = half_rows, .heights = std::move(half)};
    for (int z = 0; z < rows; ++z)
        for (int x = 0; x < columns; ++x) {
            float& value = values[std::size_t(z) * columns + x];
            if (value != kVoid) continue;
            value = half_columns > 1 && half_rows > 1 ? float(coarse.sample(0.5 * x - 0.25, 0.5 * z - 0.25))
                                                      : coarse.at(x / 2, z / 2);
        }
    return true;
}

Status check_size(const std::string& name, double columns, double rows) {
    if (columns >= 2 && rows >= 2 && columns <= kMaxSamplesPerSide && rows <= kMaxSamplesPerSide) return {};
    return bad_input(fmt::format("{}: {:.0f} x {:.0f} samples; expected 2 to {} a side; set [terrain] spacing_m", name,
                                 columns, rows, kMaxSamplesPerSide));
}

/// The largest upright rectangle of the plane that lies within the warped raster, from points along its edges.
Result<RectXZ> covered_rect(GDALDataset& dataset, const OGRSpatialReference& from, const OGRSpatialReference& plane,
                            const std::string& name) {
    const std::unique_ptr<OGRCoordinateTransformation> transform(OGRCreateCoordinateTransformation(&from, &plane));
    double geo[6];
    dataset.GetGeoTransform(geo);
    if (!transform) return bad_input(fmt::format("{}: its coordinate system cannot be transformed", name));
    const double columns = dataset.GetRasterXSize(), rows = dataset.GetRasterYSize();
    RectXZ rect{-1e12, -1e12, 1e12, 1e12};  // z south
    constexpr int kSteps = 32;
    for (int edge = 0; edge < 4; ++edge)
        for (int i = 0; i <= kSteps; ++i) {
            const double t = double(i) / kSteps;
            const double u = edge == 0 ? 0.5 : edge == 1 ? columns - 0.5 : 0.5 + t * (columns - 1);
            const double v = edge == 2 ? 0.5 : edge == 3 ? rows - 0.5 : 0.5 + t * (rows - 1);
            double x = geo[0] + u * geo[1] + v * geo[2], y = geo[3] + u * geo[4] + v * geo[5];
            if (!transform->Transform(1, &x, &y) || !std::isfinite(x) || !std::isfinite(y))
                return bad_input(
                    fmt::format("{}: its border does not lie on the plane at the georeference; is it in "
                                "the same part of the Earth?",
                                name));
            if (edge == 0) rect.x0 = std::max(rect.x0, x);
            if (edge == 1) rect.x1 = std::min(rect.x1, x);
            if (edge == 2) rect.z0 = std::max(rect.z0, -y);
            if (edge == 3) rect.z1 = std::min(rect.z1, -y);
        }
    return rect;
}

Result<HeightField> read_georeferenced(GDALDataset& dataset, const OGRSpatialReference& reference,
                                       const HeightFileSettings& settings, std::optional<GroundFrame>& frame,
                                       const std::string& name) {
    OGRSpatialReference from(reference);
    from.SetAxisMappingStrategy(OAMS_TRADITIONAL_GIS_ORDER);
    if (!frame) {
        OGRSpatialReference wgs84;
        wgs84.SetWellKnownGeogCS("WGS84");
        wgs84.SetAxisMappingStrategy(OAMS_TRADITIONAL_GIS_ORDER);
        const std::unique_ptr<OGRCoordinateTransformation> to_degrees(OGRCreateCoordinateTransformation(&from, &wgs84));
        double geo[6];
        dataset.GetGeoTransform(geo);
        const double u = 0.5 * dataset.GetRasterXSize(), v = 0.5 * dataset.GetRasterYSize();
        double x = geo[0] + u * geo[1] + v * geo[2], y = geo[3] + u * geo[4] + v * geo[5];
        if (!to_degrees || !to_degrees->Transform(1, &x, &y))
            return bad_input(fmt::format("{}: its middle has no place on Earth", name));
        frame = GroundFrame{y, x};
    }
    OGRSpatialReference plane;
    plane.importFromProj4(frame->proj_text().c_str());
    plane.SetAxisMappingStrategy(OAMS_TRADITIONAL_GIS_ORDER);
    FF_ASSIGN(RectXZ rect, covered_rect(dataset, from, plane, name));
    const double spacing_x = settings.spacing_m.value_or((rect.x1 - rect.x0) / (dataset.GetRasterXSize() - 1));
    const double spacing_z = settings.spacing_m.value_or((rect.z1 - rect.z0) / (dataset.GetRasterYSize() - 1));
    if (settings.size_m) {
        const std::array<double, 2> center = settings.center_m.value_or(std::array<double, 2>{0.0, 0.0});
        rect.x0 = std::max(rect.x0, center[0] - 0.5 * (*settings.size_m)[0]);
        rect.x1 = std::min(rect.x1, center[0] + 0.5 * (*settings.size_m)[0]);
        rect.z0 = std::max(rect.z0, center[1] - 0.5 * (*settings.size_m)[1]);
        rect.z1 = std::min(rect.z1, center[1] + 0.5 * (*settings.size_m)[1]);
    }
    if (!(rect.x1 > rect.x0 && rect.z1 > rect.z0))
        return bad_input(fmt::format("{}: covers nothing of the asked area around {:.5f}, {:.5f}", name,
                                     frame->latitude_deg, frame->longitude_deg));
    const double columns = std::floor((rect.x1 - rect.x0) / spacing_x + 1e-6) + 1;
    const double rows = std::floor((rect.z1 - rect.z0) / spacing_z + 1e-6) + 1;
    FF_TRY(check_size(name, columns, rows));

    // Pixel centres of the warped raster are our samples.
    CPLStringList arguments;
    const auto add = [&](const std::string& text) { arguments.AddString(text.c_str()); };
    for (const char* text : {"-of", "MEM", "-ot", "Float32", "-r", "bilinear", "-dstnodata", "-1e30", "-overwrite"})
        add(text);
    add("-t_srs"), add(frame->proj_text());
    const double west = rect.x0 - 0.5 * spacing_x, north = -rect.z0 + 0.5 * spacing_z;
    add("-te"), add(fmt::format("{:.9f}", west)), add(fmt::format("{:.9f}", north - rows * spacing_z));
    add(fmt::format("{:.9f}", west + columns * spacing_x)), add(fmt::format("{:.9f}", north));
    add("-ts"), add(fmt::format("{:.0f}", columns)), add(fmt::format("{:.0f}", rows));
    const std::unique_ptr<GDALWarpAppOptions, WarpOptionsDeleter> options(
        GDALWarpAppOptionsNew(arguments.List(), nullptr));
    GDALDatasetH source = GDALDataset::ToHandle(&dataset);
    int usage_error = 0;
    const GdalDataset warped(GDALDataset::FromHandle(GDALWarp("", nullptr, 1, &source, options.get(), &usage_error)));
    if (!warped) return bad_input(fmt::format("{}: cannot be warped to the plane: {}", name, CPLGetLastErrorMsg()));

    HeightField field{.low_x = rect.x0, .low_z = rect.z0, .spacing_x = spacing_x, .spacing_z = spacing_z};
    field.columns = int(columns), field.rows = int(rows);
    FF_ASSIGN(field.heights, read_band(*warped, name));
    return field;
}

Result<HeightField> read_plain(GDALDataset& dataset, const HeightFileSettings& settings, const std::string& name) {
    const GDALDataType type = dataset.GetRasterBand(1)->GetRasterDataType();
    const bool is_code = type == GDT_Byte || type == GDT_UInt16;
    double geo[6] = {0, 0, 0, 0, 0, 0};
    const bool has_cells = dataset.GetGeoTransform(geo) == CE_None && geo[1] != 0 && geo[5] != 0;
    HeightField field;
    field.columns = dataset.GetRasterXSize(), field.rows = dataset.GetRasterYSize();
    FF_TRY(check_size(name, field.columns, field.rows));
    std::array<double, 2> size;
    if (settings.size_m)
        size = *settings.size_m;
    else if (has_cells)
        size = {std::abs(geo[1]) * (field.columns - 1), std::abs(geo[5]) * (field.rows - 1)};
    else
        return bad_input(fmt::format("{}: is not georeferenced; expected [terrain] size_m = [x, z]", name));
    if (is_code && !settings.height_m)
        return bad_input(
            fmt::format("{}: an image whose values are no metres; expected [terrain] height_m = [at 0, at {}]", name,
                        type == GDT_Byte ? 255 : 65535));
    FF_ASSIGN(field.heights, read_band(dataset, name));
    if (is_code) {
        const double low = (*settings.height_m)[0];
        const double step = ((*settings.height_m)[1] - low) / (type == GDT_Byte ? 255.0 : 65535.0);
        for (float& height : field.heights)
            if (height != kVoid) height = float(low + height * step);
    }
    const std::array<double, 2> center = settings.center_m.value_or(std::array<double, 2>{0.0, 0.0});
    field.low_x = center[0] - 0.5 * size[0], field.low_z = center[1] - 0.5 * size[1];
    field.spacing_x = size[0] / (field.columns - 1), field.spacing_z = size[1] / (field.rows - 1);
    return field;
}

Result<HeightField> resample(HeightField field, double spacing, const std::string& name) {
    if (std::abs(spacing / field.spacing_x - 1) < 1e-3 && std::abs(spacing / field.spacing_z - 1) < 1e-3) return field;
    HeightField out{.low_x = field.low_x, .low_z = field.low_z};
    const double width = field.high_x() - field.low_x, depth = field.high_z() - field.low_z;
    const double columns = std::max(2.0, std::round(width / spacing) + 1),
                 rows = std::max(2.0, std::round(depth / spacing) + 1);
    FF_TRY(check_size(name, columns, rows));
    out.columns = int(columns), out.rows = int(rows);
    out.spacing_x = width / (out.columns - 1), out.spacing_z = depth / (out.rows - 1);
    out.heights.resize(std::size_t(out.columns) * out.rows);
    for (int j = 0; j < out.rows; ++j)
        for (int i = 0; i < out.columns; ++i)
            out.heights[std::size_t(j) * out.columns + i] =
                float(field.sample(out.low_x + i * out.spacing_x, out.low_z + j * out.spacing_z));
    return out;
}

}  // namespace

Result<HeightField> read_height_file(const std::filesystem::path& path, const HeightFileSettings& settings,
                                     std::optional<GroundFrame>& frame) {
    const std::string name = path.string();
    const GdalSession session;
    std::error_code ignored;
    if (!std::filesystem::is_regular_file(path, ignored)) return bad_input(fmt::format("{}: no such file", name));
    const GdalDataset dataset(GDALDataset::Open(name.c_str(), GDAL_OF_RASTER | GDAL_OF_READONLY));
    if (!dataset)
        return bad_input(
            fmt::format("{}: not a raster that GDAL reads ({}); expected GeoTIFF, .hgt, ASCII grid or "
                        "16-bit PNG",
                        name, CPLGetLastErrorMsg()));
    const int bands = dataset->GetRasterCount();
    if (bands != 1 && bands != 2)
        return bad_input(fmt::format("{}: {} channels; expected one channel of heights", name, bands));
    const OGRSpatialReference* reference = dataset->GetSpatialRef();
    double geo[6];
    const bool georeferenced = reference && dataset->GetGeoTransform(geo) == CE_None &&
                               (reference->IsGeographic() || reference->IsProjected());
    FF_ASSIGN(HeightField field, georeferenced ? read_georeferenced(*dataset, *reference, settings, frame, name)
                                               : read_plain(*dataset, settings, name));
    if (!fill_voids(field.heights, field.columns, field.rows))
        return bad_input(fmt::format("{}: holds no heights, only voids", name));
    if (!georeferenced && settings.spacing_m) {
        FF_ASSIGN(field, resample(std::move(field), *settings.spacing_m, name));
    }
    if (settings.vertical_scale != 1.0)
        for (float& height : field.heights) height = float(height * settings.vertical_scale);
    return field;
}

}  // namespace ff::cook
