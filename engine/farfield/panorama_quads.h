#pragma once
// A texel with the three right of it and below, between which a pixel looks; what panorama_*.cpp ask of them.

#include <array>
#include <cstddef>
#include <cstdint>

#include "engine/farfield/known_primitives.h"
#include "engine/farfield/panorama_map.h"

namespace ff::farfield {

/// A texel and its three neighbours.
inline std::array<std::size_t, 4> texels_of(std::int32_t quad, int map_size) {
    const auto first = std::size_t(quad), below = first + std::size_t(map_size);
    return {first, first + 1, below, below + 1};
}

/// The mean colour of those of four texels that show a primitive. Without branches: which do is anyone's guess.
/// @return 0 where none does
inline std::uint32_t mean_of_same(const PanoramaMap& map, const std::array<std::size_t, 4>& texels, PrimitiveId shown) {
    constexpr std::uint32_t kOver[] = {0, 65536, 32768, 21846, 16384};  // 65536 / count
    std::uint32_t red = 0, green = 0, blue = 0, count = 0;
    for (const std::size_t at : texels) {
        const auto same = std::uint32_t(map.visibility.instance[at] == shown.instance) &
                          std::uint32_t(map.visibility.triangle[at] == shown.triangle);
        const std::uint32_t color = map.colors[at] & (0u - same);
        red += color & 255u;
        green += color >> 8 & 255u;
        blue += color >> 16 & 255u;
        count += same;
    }
    const auto mean = [&](std::uint32_t sum) { return (sum * kOver[count] + 32768u) >> 16; };
    const std::uint32_t opaque = count != 0 ? 0xFF000000u : 0u;
    return opaque | mean(blue) << 16 | mean(green) << 8 | mean(red);
}

}  // namespace ff::farfield
