#pragma once
// A texel with the three right of it and below, between which a pixel looks; what panorama_*.cpp ask of them.

#include <hwy/highway.h>

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

struct QuadColor {
    std::uint32_t color = 0;  ///< opaque; 0: none
    bool is_marked = false;
};

/// The mean colour of those of a quad's texels that show a primitive. Without branches: which do is anyone's guess.
inline QuadColor mean_of_same(const PanoramaMap& map, std::int32_t quad, PrimitiveId shown) {
    namespace hn = hwy::HWY_NAMESPACE;
    constexpr hn::FixedTag<std::uint32_t, 2> two;
    constexpr hn::FixedTag<std::uint32_t, 4> four;
    const auto texels = [&](const auto& plane) {
        const std::uint32_t* const upper = plane.data() + quad;
        return hn::Combine(four, hn::LoadU(two, upper + map.size), hn::LoadU(two, upper));
    };
    const auto same = hn::And(hn::Eq(texels(map.visibility.instance), hn::Set(four, shown.instance)),
                              hn::Eq(texels(map.visibility.triangle), hn::Set(four, shown.triangle)));
    const auto colors = hn::IfThenElseZero(same, texels(map.colors));
    // Two of 16 bits at once: red and blue, green and marks.
    const auto sum = [&](auto pairs) {
        pairs = hn::Add(pairs, hn::Shuffle1032(pairs));
        return hn::GetLane(hn::Add(pairs, hn::Shuffle2301(pairs)));
    };
    const std::uint32_t red_blue = sum(hn::And(colors, hn::Set(four, 0x00FF00FFu)));
    const std::uint32_t green_marks =
        sum(hn::And(hn::ShiftRight<8>(colors), hn::Set(four, 0x000000FFu | kTexelMarked << 16)));
    constexpr std::uint32_t kOver[] = {0, 65536, 32768, 21846, 16384};  // 65536 / count
    const std::size_t count = hn::CountTrue(four, same);
    const auto mean = [&](std::uint32_t total) { return (total * kOver[count] + 32768u) >> 16; };
    const std::uint32_t opaque = count != 0 ? 0xFF000000u : 0u;
    return {opaque | mean(red_blue >> 16) << 16 | mean(green_marks & 0xFFFFu) << 8 | mean(red_blue & 0xFFFFu),
            green_marks >> 16 != 0};
}

}  // namespace ff::farfield
