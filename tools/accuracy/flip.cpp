#include "tools/accuracy/flip.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "engine/core/check.h"
#include "engine/core/jobs.h"

namespace ff::accuracy {
namespace {

constexpr std::size_t kRowsPerTask = 16;

struct Color {
    float x, y, z;
};

// Linear sRGB to XYZ and back (IEC 61966-2-1), and the white point that they imply.
constexpr float kToXyz[3][3] = {{0.41238656f, 0.35759149f, 0.18045049f},
                                {0.21263682f, 0.71518298f, 0.07218020f},
                                {0.01933062f, 0.11919716f, 0.95037259f}};
constexpr float kFromXyz[3][3] = {{3.24100326f, -1.53739899f, -0.49861587f},
                                  {-0.96922426f, 1.87592999f, 0.04155422f},
                                  {0.05563942f, -0.20401120f, 1.05714897f}};
constexpr Color kWhite{0.95042854f, 1.0f, 1.08890037f};

Color transform(const float (&m)[3][3], Color c) {
    return {m[0][0] * c.x + m[0][1] * c.y + m[0][2] * c.z, m[1][0] * c.x + m[1][1] * c.y + m[1][2] * c.z,
            m[2][0] * c.x + m[2][1] * c.y + m[2][2] * c.z};
}

/// YCxCz, the linear opponent space of the contrast sensitivity filters (section 4.1.1).
Color ycxcz_of(Color linear) {
    const Color xyz = transform(kToXyz, linear);
    const float x = xyz.x / kWhite.x, y = xyz.y / kWhite.y, z = xyz.z / kWhite.z;
    return {116.0f * y - 16.0f, 500.0f * (x - y), 200.0f * (y - z)};
}

Color linear_of_ycxcz(Color c) {
    const float y = (c.x + 16.0f) / 116.0f;
    return transform(kFromXyz, {(y + c.y / 500.0f) * kWhite.x, y * kWhite.y, (y - c.z / 200.0f) * kWhite.z});
}

/// CIE L*a*b*, its chroma scaled by the lightness (Hunt effect, section 4.1.3).
Color hunt_lab_of(Color linear) {
    const Color xyz = transform(kToXyz, linear);
    const auto f = [](float t) {
        constexpr float kDelta = 6.0f / 29.0f;
        return t > kDelta * kDelta * kDelta ? std::cbrt(t) : t / (3.0f * kDelta * kDelta) + 4.0f / 29.0f;
    };
    const float x = f(xyz.x / kWhite.x), y = f(xyz.y / kWhite.y), z = f(xyz.z / kWhite.z);
    const float lightness = 116.0f * y - 16.0f;
    return {lightness, 0.01f * lightness * 500.0f * (x - y), 0.01f * lightness * 200.0f * (y - z)};
}

/// HyAB distance (section 4.1.3).
float distance(Color p, Color q) {
    return std::abs(p.x - q.x) + std::hypot(p.y - q.y, p.z - q.z);
}

constexpr float kColorExponent = 0.7f;
constexpr float kFeatureExponent = 0.5f;

/// A Gaussian of the contrast sensitivity (section 4.1.1, Table 1), a sqrt(pi/b) exp(-pi^2 x^2 / b), x in degrees.
struct Sensitivity {
    double a, b;
    [[nodiscard]] double sigma_px(double pixels_per_degree) const {
        return std::sqrt(b / (2.0 * std::numbers::pi * std::numbers::pi)) * pixels_per_degree;
    }
    /// What the kernel sums to over both dimensions before it is normalised.
    [[nodiscard]] double weight(double pixels_per_degree, int radius) const {
        double sum = 0.0;
        const double sigma = sigma_px(pixels_per_degree);
        for (int i = -radius; i <= radius; ++i) sum += std::exp(-0.5 * i * i / (sigma * sigma));
        return a * std::sqrt(std::numbers::pi / b) * sum * sum;
    }
};
constexpr Sensitivity kAchromatic{1.0, 0.0047}, kRedGreen{1.0, 0.0053};
constexpr Sensitivity kBlueYellow[2] = {{34.1, 0.04}, {13.5, 0.025}};

/// Scales the positive taps to sum 1 and the negative ones to sum -1.
std::vector<float> balanced(const std::vector<double>& taps) {
    double positive = 0.0, negative = 0.0;
    for (const double tap : taps) (tap > 0.0 ? positive : negative) += tap;
    std::vector<float> result;
    for (const double tap : taps) result.push_back(float(tap > 0.0 ? tap / positive : -tap / negative));
    return result;
}

}  // namespace

Flip::Flip(double pixels_per_degree) {
    FF_CHECK(pixels_per_degree > 0.0, "{} pixels a degree", pixels_per_degree);
    const int radius = int(std::ceil(3.0 * kBlueYellow[0].sigma_px(pixels_per_degree)));
    achromatic_ = gaussian_taps(kAchromatic.sigma_px(pixels_per_degree), radius);
    red_green_ = gaussian_taps(kRedGreen.sigma_px(pixels_per_degree), radius);
    const double weights[2] = {kBlueYellow[0].weight(pixels_per_degree, radius),
                               kBlueYellow[1].weight(pixels_per_degree, radius)};
    for (int i = 0; i < 2; ++i) {
        blue_yellow_[i] = gaussian_taps(kBlueYellow[i].sigma_px(pixels_per_degree), radius);
        blue_yellow_share_[i] = float(weights[i] / (weights[0] + weights[1]));
    }
    // Edges and points as wide as 0.082 degrees (section 4.2).
    const double sigma = 0.5 * 0.082 * pixels_per_degree;
    const int feature_radius = int(std::ceil(3.0 * sigma));
    feature_ = gaussian_taps(sigma, feature_radius);
    std::vector<double> edge, point;
    for (int i = -feature_radius; i <= feature_radius; ++i) {
        const double gauss = std::exp(-0.5 * i * i / (sigma * sigma));
        edge.push_back(-i * gauss);
        point.push_back((i * i / (sigma * sigma) - 1.0) * gauss);
    }
    feature_edge_ = balanced(edge);
    feature_point_ = balanced(point);
    max_color_error_ = std::pow(distance(hunt_lab_of({0, 1, 0}), hunt_lab_of({0, 0, 1})), kColorExponent);
}

void Flip::look_at(const shading::Image& image, Filtered& out) {
    for (Plane* plane : {&y_, &cx_, &cz_, &out.lightness, &out.a, &out.b}) plane->resize(image.width, image.height);
    const auto linear = linear_of_srgb();
    const auto for_rows = [&](auto&& body) {
        parallel_ranges(std::size_t(image.height), kRowsPerTask, [&](std::size_t begin, std::size_t end) {
            for (std::size_t y = begin; y < end; ++y) body(int(y));
        });
    };
    for_rows([&](int y) {
        const std::uint32_t* pixels = image.pixels.data() + std::size_t(y) * std::size_t(image.stride);
        for (int x = 0; x < image.width; ++x) {
            const std::uint32_t p = pixels[x];
            const Color c = ycxcz_of({linear[p & 255u], linear[p >> 8 & 255u], linear[p >> 16 & 255u]});
            y_.row(y)[x] = c.x;
            cx_.row(y)[x] = c.y;
            cz_.row(y)[x] = c.z;
        }
    });
    filter(y_, achromatic_, achromatic_, scratch_, out.lightness);
    filter(cx_, red_green_, red_green_, scratch_, out.a);
    filter(cz_, blue_yellow_[0], blue_yellow_[0], scratch_, sum_);
    filter(cz_, blue_yellow_[1], blue_yellow_[1], scratch_, out.b);
    for_rows([&](int y) {
        for (int x = 0; x < image.width; ++x) {
            const float blue_yellow = blue_yellow_share_[0] * sum_.row(y)[x] + blue_yellow_share_[1] * out.b.row(y)[x];
            Color c = linear_of_ycxcz({out.lightness.row(y)[x], out.a.row(y)[x], blue_yellow});
            c = {std::clamp(c.x, 0.0f, 1.0f), std::clamp(c.y, 0.0f, 1.0f), std::clamp(c.z, 0.0f, 1.0f)};
            const Color lab = hunt_lab_of(c);
            out.lightness.row(y)[x] = lab.x;
            out.a.row(y)[x] = lab.y;
            out.b.row(y)[x] = lab.z;
            y_.row(y)[x] = (y_.row(y)[x] + 16.0f) / 116.0f;
        }
    });
    filter(y_, feature_edge_, feature_, scratch_, out.edge_x);
    filter(y_, feature_, feature_edge_, scratch_, out.edge_y);
    filter(y_, feature_point_, feature_, scratch_, out.point_x);
    filter(y_, feature_, feature_point_, scratch_, out.point_y);
}

double Flip::compare(const shading::Image& reference, const shading::Image& test) {
    FF_CHECK(reference.width == test.width && reference.height == test.height, "images of {}x{} and {}x{} pixels",
             reference.width, reference.height, test.width, test.height);
    look_at(reference, reference_);
    look_at(test, test_);
    map_.resize(test.width, test.height);
    // Colour errors up to this share of the largest take up this share of the range (section 4.1.3).
    constexpr float kUsualShare = 0.4f, kUsualRange = 0.95f;
    const float usual = kUsualShare * max_color_error_;
    const Filtered &r = reference_, &t = test_;
    parallel_ranges(std::size_t(test.height), kRowsPerTask, [&](std::size_t begin, std::size_t end) {
        for (int y = int(begin); y < int(end); ++y) {
            for (int x = 0; x < test.width; ++x) {
                const auto at = [&](const Plane& plane) { return plane.row(y)[x]; };
                const float raw = std::pow(
                    distance({at(r.lightness), at(r.a), at(r.b)}, {at(t.lightness), at(t.a), at(t.b)}), kColorExponent);
                const float color = raw < usual
                                        ? kUsualRange / usual * raw
                                        : kUsualRange + (raw - usual) / (max_color_error_ - usual) * (1 - kUsualRange);
                const float edges =
                    std::abs(std::hypot(at(r.edge_x), at(r.edge_y)) - std::hypot(at(t.edge_x), at(t.edge_y)));
                const float points =
                    std::abs(std::hypot(at(r.point_x), at(r.point_y)) - std::hypot(at(t.point_x), at(t.point_y)));
                const float feature =
                    std::pow(std::max(edges, points) / std::numbers::sqrt2_v<float>, kFeatureExponent);
                map_.row(y)[x] = color > 0.0f ? std::pow(std::min(color, 1.0f), std::max(0.0f, 1.0f - feature)) : 0.0f;
            }
        }
    });
    double sum = 0.0;
    for (const float error : map_.values) sum += double(error);
    return sum / (double(test.width) * double(test.height));
}

}  // namespace ff::accuracy
