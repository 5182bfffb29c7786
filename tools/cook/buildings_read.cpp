// Footprints through OGR: GeoJSON, OpenStreetMap extracts, and whatever else it opens.

#include <cpl_error.h>
#include <fmt/core.h>
#include <ogrsf_frmts.h>

#include <charconv>
#include <cmath>
#include <map>
#include <optional>

#include "tools/cook/buildings.h"
#include "tools/cook/gdal_session.h"

namespace ff::cook {
namespace {

constexpr double kMaxBuildingArea = 4e6;    // m²: larger outlines are land use, not houses
constexpr double kMaxHeight = 1000.0;       // m
constexpr double kMaxDistance = 200'000.0;  // m from the origin: beyond it the tangent plane means nothing
constexpr std::size_t kMaxPoints = 20'000;

/// The number that a property begins with: "12", "12.5 m".
std::optional<double> leading_number(const char* text) {
    const std::string_view view(text);
    const std::size_t start = view.find_first_not_of(' ');
    if (start == std::string_view::npos) return std::nullopt;
    double value = 0;
    const auto [end, error] = std::from_chars(view.data() + start, view.data() + view.size(), value);
    if (error != std::errc() || !std::isfinite(value)) return std::nullopt;
    return value;
}

/// A property by name; OpenStreetMap layers keep the rarer ones in one text, `"key"=>"value","key"=>..`.
std::optional<double> number_property(const OGRFeature& feature, const std::string& name) {
    const int field = feature.GetFieldIndex(name.c_str());
    if (field >= 0)
        return feature.IsFieldSetAndNotNull(field) ? leading_number(feature.GetFieldAsString(field)) : std::nullopt;
    const int others = feature.GetFieldIndex("other_tags");
    if (others < 0 || !feature.IsFieldSetAndNotNull(others)) return std::nullopt;
    const std::string_view tags = feature.GetFieldAsString(others);
    const std::string key = fmt::format("\"{}\"=>\"", name);
    const std::size_t at = tags.find(key);
    return at == std::string_view::npos ? std::nullopt : leading_number(tags.data() + at + key.size());
}

bool is_building(const OGRFeature& feature) {
    for (const char* name : {"building", "building:part"}) {
        const int field = feature.GetFieldIndex(name);
        if (field >= 0 && feature.IsFieldSetAndNotNull(field)) return true;
    }
    const int others = feature.GetFieldIndex("other_tags");
    return others >= 0 && feature.IsFieldSetAndNotNull(others) &&
           std::string_view(feature.GetFieldAsString(others)).find("\"building:part\"=>") != std::string_view::npos;
}

bool is_wood(const OGRFeature& feature) {
    const auto value_of = [&](const char* name) {
        const int field = feature.GetFieldIndex(name);
        return std::string_view(field >= 0 && feature.IsFieldSetAndNotNull(field) ? feature.GetFieldAsString(field)
                                                                                  : "");
    };
    const std::string_view natural = value_of("natural");
    if (natural == "wood" || natural == "scrub") return true;
    const std::string_view landuse = value_of("landuse");
    return landuse == "forest" || landuse == "orchard";
}

std::string feature_name(const OGRFeature& feature) {
    const int field = feature.GetFieldIndex("name");
    const char* name = field >= 0 && feature.IsFieldSetAndNotNull(field) ? feature.GetFieldAsString(field) : "";
    return *name ? fmt::format("feature {} ({})", feature.GetFID(), name) : fmt::format("feature {}", feature.GetFID());
}

Ring read_ring(const OGRLinearRing& line, bool counter_clockwise) {
    Ring ring;
    for (int i = 0; i + 1 < line.getNumPoints(); ++i) ring.emplace_back(line.getX(i), line.getY(i));
    normalize_ring(ring, counter_clockwise);
    return ring;
}

struct FootprintReader {
    const FootprintSettings& settings;
    OutlineKind kind;
    std::vector<Footprint>& out;
    std::size_t skipped = 0;
    std::string first_skipped;

    void skip(const std::string& name, const std::string& why) {
        if (skipped++ == 0) first_skipped = fmt::format("{}: {}", name, why);
    }

    void add(const OGRPolygon& polygon, const OGRFeature& feature) {
        const std::string name = feature_name(feature);
        const OGRLinearRing* exterior = polygon.getExteriorRing();
        if (!exterior) return skip(name, "no outline");
        if (std::size_t(exterior->getNumPoints()) > kMaxPoints) return skip(name, "too many corners");
        for (int i = 0; i < exterior->getNumPoints(); ++i)
            if (!std::isfinite(exterior->getX(i)) || !std::isfinite(exterior->getY(i)) ||
                std::abs(exterior->getX(i)) > kMaxDistance || std::abs(exterior->getY(i)) > kMaxDistance)
                return skip(name, fmt::format("more than {:.0f} km from the origin", kMaxDistance / 1000));
        if (!polygon.IsValid()) return skip(name, fmt::format("crosses itself ({})", CPLGetLastErrorMsg()));
        Footprint footprint;
        footprint.name = name;
        footprint.outer = read_ring(*exterior, true);
        const double area = signed_area(footprint.outer);
        if (area < 0.5) return skip(name, "no area");
        if (kind == OutlineKind::buildings && area > kMaxBuildingArea)
            return skip(name, fmt::format("{:.0f} m2 is no building", area));
        for (int i = 0; i < polygon.getNumInteriorRings(); ++i) {
            Ring hole = read_ring(*polygon.getInteriorRing(i), false);
            if (!hole.empty()) footprint.holes.push_back(std::move(hole));
        }
        if (kind == OutlineKind::woods) {
            out.push_back(std::move(footprint));
            return;
        }
        const std::optional<double> levels = number_property(feature, settings.levels);
        footprint.height_m =
            number_property(feature, settings.height)
                .value_or(levels && *levels > 0 ? *levels * settings.level_height_m : settings.default_height_m);
        footprint.base_m = number_property(feature, settings.base).value_or(0.0);
        if (footprint.base_m < 0) footprint.base_m = 0;
        if (!(footprint.height_m > footprint.base_m) || footprint.height_m > kMaxHeight)
            return skip(name, fmt::format("walls from {:g} to {:g} m", footprint.base_m, footprint.height_m));
        out.push_back(std::move(footprint));
    }

    void add(const OGRGeometry& geometry, const OGRFeature& feature) {
        switch (wkbFlatten(geometry.getGeometryType())) {
            case wkbPolygon:
                add(*geometry.toPolygon(), feature);
                break;
            case wkbMultiPolygon:
                for (const OGRPolygon* part : *geometry.toMultiPolygon()) add(*part, feature);
                break;
            default:
                break;
        }
    }
};

}  // namespace

Result<std::vector<Footprint>> read_footprints(const std::filesystem::path& path, const FootprintSettings& settings,
                                               OutlineKind kind, std::optional<GroundFrame>& frame,
                                               CookContext& context) {
    const std::string file = path.string();
    const GdalSession session;
    std::error_code ignored;
    if (!std::filesystem::is_regular_file(path, ignored)) return bad_input(fmt::format("{}: no such file", file));
    const GdalDataset dataset(GDALDataset::Open(file.c_str(), GDAL_OF_VECTOR | GDAL_OF_READONLY));
    if (!dataset)
        return bad_input(
            fmt::format("{}: no geometry that OGR reads ({}); expected GeoJSON or an OpenStreetMap extract", file,
                        CPLGetLastErrorMsg()));
    const bool is_osm = dataset->GetDriver() && std::string_view(dataset->GetDriver()->GetDescription()) == "OSM";

    // Features in the file's order; OSM extracts must be read layer by layer as they come.
    std::vector<OGRFeatureUniquePtr> features;
    OGREnvelope extent;
    OGRLayer* layer = nullptr;
    OGRSpatialReference wgs84;
    wgs84.SetWellKnownGeogCS("WGS84");
    wgs84.SetAxisMappingStrategy(OAMS_TRADITIONAL_GIS_ORDER);
    std::map<const OGRLayer*, std::unique_ptr<OGRCoordinateTransformation>> to_degrees;
    for (;;) {
        OGRFeatureUniquePtr feature(dataset->GetNextFeature(&layer, nullptr, nullptr, nullptr));
        if (!feature) break;
        OGRGeometry* geometry = feature->GetGeometryRef();
        if (!geometry) continue;
        const OGRwkbGeometryType type = wkbFlatten(geometry->getGeometryType());
        if (type != wkbPolygon && type != wkbMultiPolygon) continue;
        if (is_osm && !(kind == OutlineKind::buildings ? is_building(*feature) : is_wood(*feature))) continue;
        auto [place, is_new] = to_degrees.try_emplace(layer);
        if (is_new && layer->GetSpatialRef()) {
            OGRSpatialReference from(*layer->GetSpatialRef());
            from.SetAxisMappingStrategy(OAMS_TRADITIONAL_GIS_ORDER);
            if (!from.IsSame(&wgs84)) place->second.reset(OGRCreateCoordinateTransformation(&from, &wgs84));
        }
        if (place->second && geometry->transform(place->second.get()) != OGRERR_NONE) continue;
        OGREnvelope envelope;
        geometry->getEnvelope(&envelope);
        extent.Merge(envelope);
        features.push_back(std::move(feature));
    }
    if (features.empty())
        return bad_input(fmt::format(
            "{}: no {}polygons{}", file,
            !is_osm                          ? ""
            : kind == OutlineKind::buildings ? "building "
                                             : "wood ",
            CPLGetLastErrorType() >= CE_Failure ? fmt::format(" ({})", CPLGetLastErrorMsg()) : std::string()));
    if (!frame) frame = GroundFrame{0.5 * (extent.MinY + extent.MaxY), 0.5 * (extent.MinX + extent.MaxX)};

    OGRSpatialReference plane;
    plane.importFromProj4(frame->proj_text().c_str());
    plane.SetAxisMappingStrategy(OAMS_TRADITIONAL_GIS_ORDER);
    const std::unique_ptr<OGRCoordinateTransformation> to_plane(OGRCreateCoordinateTransformation(&wgs84, &plane));
    std::vector<Footprint> footprints;
    FootprintReader reader{settings, kind, footprints, 0, {}};
    for (const OGRFeatureUniquePtr& feature : features) {
        OGRGeometry* geometry = feature->GetGeometryRef();
        if (!to_plane || geometry->transform(to_plane.get()) != OGRERR_NONE) {
            reader.skip(feature_name(*feature), "does not lie on the plane at the georeference");
            continue;
        }
        reader.add(*geometry, *feature);
    }
    if (reader.skipped > 0)
        context.warn(
            fmt::format("{}: {} outlines left out; the first is {}", file, reader.skipped, reader.first_skipped));
    return footprints;
}

}  // namespace ff::cook
