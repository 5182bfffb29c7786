#include "engine/budget/calibration.h"

#include <cmath>
#include <cstddef>
#include <limits>

#include "engine/core/jobs.h"
#include "engine/core/work_clock.h"

namespace ff::budget {
namespace {

constexpr int kGridSide = 64;
constexpr std::size_t kRays = 2048, kRaysInPart = 128;
constexpr std::size_t kParts = kRays / kRaysInPart;

/// A number that looks random; the same on every machine.
std::uint32_t scramble(std::uint32_t x) {
    x ^= x >> 16;
    x *= 0x7FEB352Du;
    x ^= x >> 15;
    x *= 0x846CA68Bu;
    return x ^ x >> 16;
}

float unit_of(std::uint32_t x) {
    return float(scramble(x) >> 8) * 0x1p-24f;
}

float height_of(int x, int z) {
    return 3.0f * unit_of(std::uint32_t(z * (kGridSide + 1) + x));
}

void cross(const float* a, const float* b, float* out) {
    out[0] = a[1] * b[2] - a[2] * b[1];
    out[1] = a[2] * b[0] - a[0] * b[2];
    out[2] = a[0] * b[1] - a[1] * b[0];
}

float dot(const float* a, const float* b) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

}  // namespace

Calibration::Calibration() : partial_(kParts) {
    const auto corner = [](int x, int z, float* out) {
        out[0] = float(x);
        out[1] = height_of(x, z);
        out[2] = float(z);
    };
    const auto add = [&](int x0, int z0, int x1, int z1, int x2, int z2) {
        Triangle triangle;
        float b[3], c[3];
        corner(x0, z0, triangle.corner);
        corner(x1, z1, b);
        corner(x2, z2, c);
        for (int i = 0; i < 3; ++i) {
            triangle.edge1[i] = b[i] - triangle.corner[i];
            triangle.edge2[i] = c[i] - triangle.corner[i];
        }
        triangles_.push_back(triangle);
    };
    triangles_.reserve(std::size_t(2 * kGridSide * kGridSide));
    for (int z = 0; z < kGridSide; ++z)
        for (int x = 0; x < kGridSide; ++x) {
            add(x, z, x + 1, z, x, z + 1);
            add(x + 1, z, x + 1, z + 1, x, z + 1);
        }
}

/// Amanatides and Woo's walk through the cells under each ray (Eurographics 1987), Moeller and Trumbore's test of the
/// two triangles in each (JGT 1997): branches, divisions and loads as in any ray caster.
std::uint64_t Calibration::walk_rays(std::size_t begin, std::size_t end) const {
    std::uint64_t hits = 0;
    for (std::size_t ray = begin; ray < end; ++ray) {
        const auto seed = std::uint32_t(ray * 4);
        const float origin[3] = {unit_of(seed) * kGridSide, 4.0f, unit_of(seed + 1) * kGridSide};
        const float angle = 6.2831853f * unit_of(seed + 2);
        const float direction[3] = {std::cos(angle), -0.15f - 0.2f * unit_of(seed + 3), std::sin(angle)};
        int cell[2] = {int(origin[0]), int(origin[2])};
        const float along[2] = {direction[0], direction[2]};
        const float from[2] = {origin[0], origin[2]};
        int step[2];
        float next[2], delta[2];
        for (int a = 0; a < 2; ++a) {
            step[a] = along[a] < 0.0f ? -1 : 1;
            const float inverse = std::abs(along[a]) > 1e-9f ? 1.0f / std::abs(along[a]) : 1e30f;
            delta[a] = inverse;
            const float into = from[a] - float(cell[a]);
            next[a] = (step[a] > 0 ? 1.0f - into : into) * inverse;
        }
        float nearest = std::numeric_limits<float>::infinity();
        while (cell[0] >= 0 && cell[0] < kGridSide && cell[1] >= 0 && cell[1] < kGridSide && !std::isfinite(nearest)) {
            const std::size_t first = 2 * std::size_t(cell[1] * kGridSide + cell[0]);
            for (std::size_t t = first; t < first + 2; ++t) {
                const Triangle& triangle = triangles_[t];
                float p[3], q[3], offset[3];
                cross(direction, triangle.edge2, p);
                const float determinant = dot(triangle.edge1, p);
                if (std::abs(determinant) < 1e-9f) continue;
                const float inverse = 1.0f / determinant;
                for (int i = 0; i < 3; ++i) offset[i] = origin[i] - triangle.corner[i];
                const float u = dot(offset, p) * inverse;
                if (u < 0.0f || u > 1.0f) continue;
                cross(offset, triangle.edge1, q);
                const float v = dot(direction, q) * inverse;
                if (v < 0.0f || u + v > 1.0f) continue;
                const float distance = dot(triangle.edge2, q) * inverse;
                if (distance > 0.0f && distance < nearest) nearest = distance;
            }
            const int a = next[0] < next[1] ? 0 : 1;
            next[a] += delta[a];
            cell[a] += step[a];
        }
        hits += std::isfinite(nearest);
    }
    return hits;
}

double Calibration::run() {
    const std::int64_t begin_ns = work_ns();
    parallel_for(kParts,
                 [&](std::size_t part) { partial_[part] = walk_rays(part * kRaysInPart, (part + 1) * kRaysInPart); });
    const double ms = 1e-6 * double(work_ns() - begin_ns);
    checksum_ = 0;
    for (const std::uint64_t part : partial_) checksum_ = checksum_ * 31 + part;
    return ms;
}

}  // namespace ff::budget
