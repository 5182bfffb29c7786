#include "engine/shading/upscale.h"

#include <algorithm>

#include "engine/core/check.h"
#include "engine/core/jobs.h"

namespace ff::shading {
namespace {

/// a + (b - a) * weight / 256 in each of the four bytes, rounded: two bytes at a time in 16 bits each.
std::uint32_t mix(std::uint32_t a, std::uint32_t b, std::uint32_t weight) {
    constexpr std::uint32_t kEven = 0x00FF00FFu, kHalf = 0x00800080u;
    const std::uint32_t even = ((a & kEven) * (256 - weight) + (b & kEven) * weight + kHalf) >> 8 & kEven;
    const std::uint32_t odd = ((a >> 8 & kEven) * (256 - weight) + (b >> 8 & kEven) * weight + kHalf) & ~kEven;
    return even | odd;
}

}  // namespace

void Upscaler::make_taps(int from, int to, std::vector<Tap>& taps) {
    taps.resize(std::size_t(to));
    const double step = double(from) / double(to);
    for (int i = 0; i < to; ++i) {
        const double at = std::clamp((i + 0.5) * step - 0.5, 0.0, double(from - 1));
        const int first = std::min(int(at), std::max(0, from - 2));
        taps[std::size_t(i)] = {std::uint32_t(first), std::uint32_t((at - first) * 256.0 + 0.5)};
    }
}

void Upscaler::run(const Image& from, Image& to) {
    FF_CHECK(from.width > 0 && from.height > 0 && to.width > 0 && to.height > 0, "{}x{} to {}x{} pixels", from.width,
             from.height, to.width, to.height);
    make_taps(from.width, to.width, columns_);
    make_taps(from.height, to.height, rows_);
    const std::uint32_t right = from.width > 1 ? 1 : 0;
    const std::size_t below = from.height > 1 ? std::size_t(from.stride) : 0;
    parallel_ranges(std::size_t(to.height), 16, [&](std::size_t begin, std::size_t end) {
        for (std::size_t y = begin; y < end; ++y) {
            const Tap row = rows_[y];
            const std::uint32_t* upper = from.pixels.data() + std::size_t(row.first) * std::size_t(from.stride);
            const std::uint32_t* lower = upper + below;
            std::uint32_t* out = to.pixels.data() + y * std::size_t(to.stride);
            for (const Tap& column : columns_) {
                const std::uint32_t left_mix = mix(upper[column.first], lower[column.first], row.weight);
                const std::uint32_t right_mix =
                    mix(upper[column.first + right], lower[column.first + right], row.weight);
                *out++ = mix(left_mix, right_mix, column.weight);
            }
        }
    });
}

}  // namespace ff::shading
