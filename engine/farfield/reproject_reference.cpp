#include "engine/farfield/reproject_reference.h"

#include <cmath>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <limits>
#include <set>
#include <utility>

#include "engine/farfield/alpha_test.h"

namespace ff::farfield {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
using Primitive = std::pair<std::uint32_t, std::uint32_t>;

DVec3 ray_of(const PinholeView& view, int x, int y) {
    return {(x + 0.5) * double(view.u_step) + double(view.u_first),
            (y + 0.5) * double(view.v_step) + double(view.v_first), -1.0};
}

/// A point of the last frame: P3's triple, and where it lands.
struct Point {
    bool exists = false, is_abrupt = false, is_trusted = true;
    std::uint32_t instance = 0, triangle = 0;
    double across = 0, down = 0;  ///< pixels of the old image, seen from the new eye
    int x = 0, y = 0;
    double depth = 0;
};

/// What landed in a pixel (AIP).
struct Landing {
    bool is_filled = false, is_abrupt = false;
    std::uint32_t instance = 0, triangle = 0;
    double depth = 0;
};

/// An image with a border of one pixel.
struct Plane {
    int width, height;
    std::vector<Landing> pixels;
    Plane(int w, int h) : width(w), height(h), pixels(std::size_t(w + 2) * std::size_t(h + 2)) {}
    Landing& at(int x, int y) { return pixels[std::size_t(y + 1) * std::size_t(width + 2) + std::size_t(x + 1)]; }
    const Landing& at(int x, int y) const { return const_cast<Plane*>(this)->at(x, y); }
    [[nodiscard]] bool has(int x, int y) const { return x >= -1 && y >= -1 && x <= width && y <= height; }
};

bool has_left_frustum(const PinholeView& last_view, const PinholeView& view) {
    const DVec3 eye = glm::transpose(DMat3(last_view.world_from_camera)) * (view.position - last_view.position);
    if (eye == DVec3(0.0)) return false;
    if (eye.z >= 0.0) return true;
    const double x = (eye.x / -eye.z - double(last_view.u_first)) / double(last_view.u_step);
    const double y = (eye.y / -eye.z - double(last_view.v_first)) / double(last_view.v_step);
    return x < 0.0 || y < 0.0 || x > last_view.width || y > last_view.height;
}

Point project(const PinholeView& last_view, const VisibilityBuffer& last, const PinholeView& view,
              const ReprojectSettings& settings, std::size_t static_instances, int x, int y) {
    Point point;
    const std::size_t at = last.index(x, y);
    point.instance = last.instance[at];
    point.triangle = last.triangle[at];
    const bool is_sky = point.instance == kSkyInstance;
    if (is_sky ? !settings.use_background : point.instance >= static_instances) return point;
    const DMat3 old_axes(last_view.world_from_camera), new_axes(view.world_from_camera);
    const DVec3 step = view.position - last_view.position;
    // In old axes, from the new eye; sky is a direction.
    const DVec3 ray = ray_of(last_view, x, y);
    const DVec3 old = is_sky ? ray : ray * double(last.depth[at]) - glm::transpose(old_axes) * step;
    if (old.z >= 0.0) return point;
    point.exists = true;
    point.across = (old.x / -old.z - double(last_view.u_first)) / double(last_view.u_step);
    point.down = (old.y / -old.z - double(last_view.v_first)) / double(last_view.v_step);
    const DVec3 camera = glm::transpose(new_axes) * (old_axes * old);
    point.depth = is_sky ? kInfinity : -camera.z;
    point.is_abrupt = settings.check_abrupt && glm::length(step) > point.depth / 2.0 / settings.abrupt_frames;
    point.x = point.y = -1000;
    if (camera.z >= 0.0) return point;
    const double column = (camera.x / -camera.z - double(view.u_first)) / double(view.u_step);
    const double row = (camera.y / -camera.z - double(view.v_first)) / double(view.v_step);
    if (std::fabs(column) > 1e5 || std::fabs(row) > 1e5) return point;
    point.x = int(std::floor(column));
    point.y = int(std::floor(row));
    return point;
}

/// P3 4.2 along one row or column: from where image motion comes to where it goes, each point must pass all before it.
/// @param motion  of a pixel: positive towards greater coordinates
template <class PointAt, class Motion, class Coordinate>
void check_line(int size, PointAt&& point_at, Motion&& motion, Coordinate&& coordinate) {
    const auto walk = [&](bool forwards) {
        double farthest = -kInfinity;
        for (int i = 0; i < size; ++i) {
            const int at = forwards ? i : size - 1 - i;
            if ((motion(at) > 0.0) != forwards) continue;
            Point& point = point_at(at);
            if (!point.exists || !point.is_trusted) continue;
            const double value = forwards ? coordinate(point) : -coordinate(point);
            if (value > farthest)
                farthest = value;
            else
                point.is_trusted = false;
        }
    };
    walk(true);
    walk(false);
}

void check_order(const PinholeView& last_view, const PinholeView& view, std::vector<Point>& points) {
    const DVec3 step = glm::transpose(DMat3(last_view.world_from_camera)) * (view.position - last_view.position);
    if (step == DVec3(0.0)) return;
    const int width = view.width, height = view.height;
    const auto at = [&](int x, int y) -> Point& {
        return points[std::size_t(y) * std::size_t(width) + std::size_t(x)];
    };
    for (int y = 0; y < height; ++y)
        check_line(
            width, [&](int x) -> Point& { return at(x, y); },
            [&](int x) { return (ray_of(last_view, x, y).x * -step.z - step.x) / double(last_view.u_step); },
            [](const Point& point) { return point.across; });
    for (int x = 0; x < width; ++x)
        check_line(
            height, [&](int y) -> Point& { return at(x, y); },
            [&](int y) { return (ray_of(last_view, x, y).y * -step.z - step.y) / double(last_view.v_step); },
            [](const Point& point) { return point.down; });
}

/// The primitives that landed in the tile of a pixel or next to it.
std::set<Primitive> primitives_around_tile(const Plane& plane, int x0, int y0) {
    std::set<Primitive> primitives;
    for (int y = y0 - 1; y <= y0 + kTileSize; ++y)
        for (int x = x0 - 1; x <= x0 + kTileSize; ++x) {
            if (!plane.has(x, y)) continue;
            const Landing& landing = plane.at(x, y);
            if (landing.is_filled && landing.instance != kSkyInstance)
                primitives.insert({landing.instance, landing.triangle});
        }
    return primitives;
}

template <class Counts>
int count_around(const Plane& plane, int x, int y, Counts&& counts) {
    int count = 0;
    for (int j = y - 1; j <= y + 1; ++j)
        for (int i = x - 1; i <= x + 1; ++i) count += counts(plane.at(i, j));
    return count;
}

PixelCause answer(const scene::StaticScene& scene, const PinholeView& view, const Plane& plane,
                  const std::set<Primitive>& primitives, const ReprojectSettings& settings, int x, int y,
                  VisibilityBuffer& out) {
    const bool has_abrupt = count_around(plane, x, y, [](const Landing& l) { return !l.is_filled && l.is_abrupt; }) > 0;
    const PixelCause otherwise = has_abrupt ? PixelCause::abrupt : PixelCause::failed;
    const auto is_filled = [](const Landing& l) { return l.is_filled; };
    if (count_around(plane, x, y, is_filled) < settings.min_count) return otherwise;
    const std::size_t at = out.index(x, y);
    double nearest = kInfinity;
    Primitive hit;
    for (const Primitive& primitive : primitives) {
        const double depth = intersect_primitive(scene, view, x, y, primitive.first, primitive.second);
        if (depth >= nearest) continue;
        nearest = depth;
        hit = primitive;
    }
    if (nearest == kInfinity) {
        const auto is_sky = [](const Landing& l) { return l.is_filled && l.instance == kSkyInstance; };
        if (count_around(plane, x, y, is_sky) < std::max(1, settings.min_count)) return otherwise;
        out.instance[at] = kSkyInstance;
        out.triangle[at] = 0;
        out.depth[at] = std::numeric_limits<float>::infinity();
        return PixelCause::background;
    }
    const auto votes = [&](const Landing& l) {
        if (!l.is_filled) return false;
        const bool is_same = Primitive{l.instance, l.triangle} == hit;
        const bool is_near = std::fabs(l.depth - nearest) <= double(settings.surface_share) * nearest;
        return settings.vote == Vote::any || is_same || (settings.vote == Vote::surface && is_near);
    };
    if (count_around(plane, x, y, votes) < settings.min_count) return otherwise;
    out.instance[at] = hit.first;
    out.triangle[at] = hit.second;
    out.depth[at] = float(nearest);
    return PixelCause::verified;
}

}  // namespace

double intersect_primitive(const scene::StaticScene& scene, const PinholeView& view, int x, int y,
                           std::uint32_t instance_id, std::uint32_t triangle, double slack) {
    const scene::Instance& instance = scene.instances[instance_id];
    const scene::Mesh& mesh = scene.meshes[instance.mesh];
    DVec3 corners[3];
    for (std::size_t k = 0; k < 3; ++k) {
        const std::uint32_t index = scene.indices[3 * (std::size_t(mesh.first_triangle) + triangle) + k];
        corners[k] = DMat3(instance.world_from_mesh) * DVec3(scene.positions[mesh.first_vertex + index]) +
                     (instance.position - view.position);
    }
    const DVec3 ray = DMat3(view.world_from_camera) * ray_of(view, x, y);
    // Möller, Trumbore 1997.
    const DVec3 ab = corners[1] - corners[0], ac = corners[2] - corners[0], across = glm::cross(ray, ac);
    const double determinant = glm::dot(ab, across);
    const DVec3 moment = glm::cross(-corners[0], ab);
    const double b1 = glm::dot(-corners[0], across) / determinant, b2 = glm::dot(ray, moment) / determinant;
    const double depth = glm::dot(ac, moment) / determinant;
    if (!(b1 >= -slack && b2 >= -slack && b1 + b2 <= 1.0 + slack && depth > 0.0)) return kInfinity;
    const AlphaSurface surface = make_alpha_surface(scene, instance, instance_id, triangle);
    return is_opaque_at(surface, float(b1), float(b2), float(depth) * view.pixel_angle()) ? depth : kInfinity;
}

std::vector<PixelCause> reproject_reference(const scene::StaticScene& scene, const PinholeView& last_view,
                                            const VisibilityBuffer& last, const PinholeView& view,
                                            const ReprojectSettings& settings, std::uint64_t frame_number,
                                            VisibilityBuffer& out) {
    if (settings.check_view_frustum && has_left_frustum(last_view, view)) return {};
    const int width = view.width, height = view.height;
    std::vector<Point> points;
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x)
            points.push_back(project(last_view, last, view, settings, scene.instances.size(), x, y));
    if (settings.check_occlusion) check_order(last_view, view, points);

    Plane plane(width, height);
    for (const Point& point : points) {
        if (!point.exists || !point.is_trusted || !plane.has(point.x, point.y)) continue;
        Landing& landing = plane.at(point.x, point.y);
        if (point.is_abrupt) {
            landing.is_abrupt = true;
        } else if (!landing.is_filled || point.depth < landing.depth) {
            landing = {true, landing.is_abrupt, point.instance, point.triangle, point.depth};
        }
    }

    std::vector<PixelCause> causes(points.size());
    for (int y0 = 0; y0 < height; y0 += kTileSize)
        for (int x0 = 0; x0 < width; x0 += kTileSize) {
            const auto primitives = primitives_around_tile(plane, x0, y0);
            const TileMask due = resample_mask(settings, x0 / kTileSize, y0 / kTileSize, frame_number);
            for (int j = 0; j < std::min(kTileSize, height - y0); ++j)
                for (int i = 0; i < std::min(kTileSize, width - x0); ++i) {
                    const int x = x0 + i, y = y0 + j;
                    causes[std::size_t(y) * std::size_t(width) + std::size_t(x)] =
                        ((due.rows[j] >> i) & 1) != 0 ? PixelCause::resampled
                                                      : answer(scene, view, plane, primitives, settings, x, y, out);
                }
        }
    return causes;
}

}  // namespace ff::farfield
