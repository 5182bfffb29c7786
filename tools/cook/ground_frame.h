#pragma once
// Where the world's origin lies on Earth.

#include <cmath>
#include <optional>
#include <string>

#include <fmt/core.h>

namespace ff::cook {

/// The local tangent plane at a point of the WGS84 ellipsoid: x east, z south, metres. Heights stay heights above the
/// datum; the ground's curvature (7 m at 10 km) is left out.
struct GroundFrame {
    double latitude_deg = 0, longitude_deg = 0;

    /// The plane as PROJ knows it; its axes are east and north.
    [[nodiscard]] std::string proj_text() const {
        return fmt::format("+proj=ortho +lat_0={:.12f} +lon_0={:.12f} +datum=WGS84 +units=m +no_defs", latitude_deg,
                           longitude_deg);
    }
};

}  // namespace ff::cook
