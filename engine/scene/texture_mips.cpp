// Based on: Castano, "Computing Alpha Mipmaps", 2010 (each mip's alpha is scaled until as many of its texels pass the
// cutoff as do in level 0: foliage keeps its coverage in the distance).

#include "engine/scene/texture_mips.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "engine/core/check.h"
#include "engine/core/jobs.h"

namespace ff::scene {
namespace {

constexpr std::uint32_t kCutoff = 128;  // of the alpha byte; the usual alpha_cutoff of 0.5

std::array<float, 256> make_linear_table() {
    std::array<float, 256> table;
    for (std::size_t i = 0; i < 256; ++i) {
        const double s = double(i) / 255.0;
        table[i] = float(s <= 0.04045 ? s / 12.92 : std::pow((s + 0.055) / 1.055, 2.4));
    }
    return table;
}

// sRGB byte of a linear value in 1/65535.
std::vector<std::uint8_t> make_srgb_table() {
    std::vector<std::uint8_t> table(65536);
    for (std::size_t i = 0; i < table.size(); ++i) {
        const double x = double(i) / 65535.0;
        const double s = x <= 0.0031308 ? 12.92 * x : 1.055 * std::pow(x, 1.0 / 2.4) - 0.055;
        table[i] = std::uint8_t(std::lround(255.0 * s));
    }
    return table;
}

std::uint32_t average(const std::uint32_t (&four)[4]) {
    static const std::vector<std::uint8_t> srgb = make_srgb_table();
    const auto linear = linear_of_srgb();
    // Colour counts by its alpha: what is cut away must not tint what is left.
    float sum[3] = {}, plain[3] = {};
    std::uint32_t alpha = 0;
    for (const std::uint32_t texel : four) {
        const std::uint32_t a = texel >> 24;
        alpha += a;
        for (int c = 0; c < 3; ++c) {
            const float value = linear[(texel >> (8 * c)) & 0xFF];
            sum[c] += value * float(a);
            plain[c] += value;
        }
    }
    std::uint32_t out = ((alpha + 2) / 4) << 24;
    for (int c = 0; c < 3; ++c) {
        const float value = alpha > 0 ? sum[c] / float(alpha) : plain[c] * 0.25f;
        out |= std::uint32_t(srgb[std::size_t(std::min(value, 1.0f) * 65535.0f + 0.5f)]) << (8 * c);
    }
    return out;
}

double coverage_of(std::span<const std::uint32_t> level) {
    std::size_t covered = 0;
    for (const std::uint32_t texel : level) covered += (texel >> 24) >= kCutoff;
    return double(covered) / double(level.size());
}

// Scales alpha so that about `coverage` of the texels reach the cutoff.
void scale_alpha_to_coverage(std::span<std::uint32_t> level, double coverage) {
    std::array<std::size_t, 256> histogram{};
    for (const std::uint32_t texel : level) ++histogram[texel >> 24];
    const auto wanted = std::size_t(coverage * double(level.size()) + 0.5);
    std::uint32_t threshold = 256;  // the alpha that shall become the cutoff
    std::size_t passing = 0;
    while (threshold > 1 && passing < wanted) passing += histogram[--threshold];
    if (threshold == 256) --threshold;
    for (std::uint32_t& texel : level) {
        const std::uint32_t alpha = std::min(255u, ((texel >> 24) * kCutoff + threshold / 2) / threshold);
        texel = (texel & 0xFFFFFFu) | (alpha << 24);
    }
}

}  // namespace

std::span<const float, 256> linear_of_srgb() {
    static const std::array<float, 256> table = make_linear_table();
    return table;
}

Texture append_mip_chain(std::span<const std::uint32_t> rgba, std::uint32_t width, std::uint32_t height,
                         std::vector<std::uint32_t>& texels) {
    const auto is_side = [](std::uint32_t n) { return n >= 1 && n <= 8192 && (n & (n - 1)) == 0; };
    FF_CHECK(is_side(width) && is_side(height), "{} x {} texels", width, height);
    FF_CHECK(rgba.size() == std::size_t(width) * height, "{} texels for {} x {}", rgba.size(), width, height);

    Texture texture{.width = width, .height = height, .level_count = 1, .first_texel = texels.size()};
    std::size_t total = rgba.size();
    for (std::uint32_t w = width, h = height; w > 1 || h > 1; ++texture.level_count) {
        w = std::max(1u, w / 2);
        h = std::max(1u, h / 2);
        total += std::size_t(w) * h;
    }
    texels.resize(texels.size() + total);
    std::uint32_t* level = texels.data() + texture.first_texel;
    std::copy(rgba.begin(), rgba.end(), level);

    std::uint32_t w = width, h = height;
    for (std::uint32_t l = 1; l < texture.level_count; ++l) {
        const std::uint32_t* from = level;
        std::uint32_t* to = level + std::size_t(w) * h;
        const std::uint32_t half_w = std::max(1u, w / 2), half_h = std::max(1u, h / 2);
        const std::uint32_t step_x = w > 1 ? 1 : 0, step_y = h > 1 ? w : 0;
        parallel_ranges(half_h, std::max(1u, 16384 / half_w), [&](std::size_t begin, std::size_t end) {
            for (std::size_t y = begin; y < end; ++y) {
                const std::uint32_t* row = from + (h > 1 ? 2 * y : 0) * w;
                for (std::uint32_t x = 0; x < half_w; ++x) {
                    const std::uint32_t* at = row + (w > 1 ? 2 * x : 0);
                    to[y * half_w + x] = average({at[0], at[step_x], at[step_y], at[step_x + step_y]});
                }
            }
        });
        level = to;
        w = half_w;
        h = half_h;
    }

    // Only now: every level was averaged from true alphas.
    const double coverage = coverage_of(rgba);
    if (coverage > 0.0 && coverage < 1.0) {
        level = texels.data() + texture.first_texel;
        w = width;
        h = height;
        for (std::uint32_t l = 1; l < texture.level_count; ++l) {
            level += std::size_t(w) * h;
            w = std::max(1u, w / 2);
            h = std::max(1u, h / 2);
            scale_alpha_to_coverage({level, std::size_t(w) * h}, coverage);
        }
    }
    return texture;
}

}  // namespace ff::scene
