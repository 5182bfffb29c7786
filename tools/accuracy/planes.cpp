#include "tools/accuracy/planes.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "engine/core/jobs.h"

namespace ff::accuracy {
namespace {

constexpr std::size_t kRowsPerTask = 16;

std::array<float, 256> make_linear_of_srgb() {
    std::array<float, 256> table;
    for (std::size_t i = 0; i < table.size(); ++i) {
        const double v = double(i) / 255.0;
        table[i] = float(v <= 0.04045 ? v / 12.92 : std::pow((v + 0.055) / 1.055, 2.4));
    }
    return table;
}

}  // namespace

void Plane::resize(int new_width, int new_height) {
    width = new_width;
    height = new_height;
    values.resize(std::size_t(new_width) * std::size_t(new_height));
}

void filter(const Plane& in, std::span<const float> across, std::span<const float> down, Plane& scratch, Plane& out) {
    scratch.resize(in.width, in.height);
    out.resize(in.width, in.height);
    const int radius_x = int(across.size()) / 2, radius_y = int(down.size()) / 2;
    parallel_ranges(std::size_t(in.height), kRowsPerTask, [&](std::size_t begin, std::size_t end) {
        std::vector<float> padded(std::size_t(in.width + 2 * radius_x));
        for (std::size_t y = begin; y < end; ++y) {
            const float* row = in.row(int(y));
            std::fill_n(padded.begin(), radius_x, row[0]);
            std::copy_n(row, in.width, padded.begin() + radius_x);
            std::fill_n(padded.end() - radius_x, radius_x, row[in.width - 1]);
            float* to = scratch.row(int(y));
            std::fill_n(to, in.width, 0.0f);
            for (std::size_t t = 0; t < across.size(); ++t) {
                const float tap = across[t];
                const float* from = padded.data() + t;
                for (int x = 0; x < in.width; ++x) to[x] += tap * from[x];
            }
        }
    });
    parallel_ranges(std::size_t(in.height), kRowsPerTask, [&](std::size_t begin, std::size_t end) {
        for (std::size_t y = begin; y < end; ++y) {
            float* to = out.row(int(y));
            std::fill_n(to, in.width, 0.0f);
            for (std::size_t t = 0; t < down.size(); ++t) {
                const float tap = down[t];
                const float* from = scratch.row(std::clamp(int(y) + int(t) - radius_y, 0, in.height - 1));
                for (int x = 0; x < in.width; ++x) to[x] += tap * from[x];
            }
        }
    });
}

std::vector<float> gaussian_taps(double sigma, int radius) {
    std::vector<double> taps;
    double sum = 0.0;
    for (int i = -radius; i <= radius; ++i) {
        taps.push_back(std::exp(-0.5 * i * i / (sigma * sigma)));
        sum += taps.back();
    }
    std::vector<float> result;
    for (const double tap : taps) result.push_back(float(tap / sum));
    return result;
}

std::span<const float, 256> linear_of_srgb() {
    static const std::array<float, 256> table = make_linear_of_srgb();
    return table;
}

}  // namespace ff::accuracy
