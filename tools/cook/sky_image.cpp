#include "tools/cook/sky_image.h"

#include <OpenImageIO/imageio.h>
#include <fmt/core.h>

#include <algorithm>
#include <bit>
#include <cmath>

namespace ff::cook {
namespace {

/// Non-negative, at most 65504; rounds to nearest.
std::uint16_t half_of(float value) {
    if (!(value > 0)) return 0;
    value = std::min(value, 65504.0f);
    if (value < 6.1035156e-5f) return std::uint16_t(std::lround(value * 16777216.0f));  // subnormal: units of 2^-24
    const std::uint32_t bits = std::bit_cast<std::uint32_t>(value) + 0x1000u;
    return std::uint16_t((bits - 0x38000000u) >> 13);
}

float linear_of_srgb(float v) {
    return v <= 0.04045f ? v / 12.92f : std::pow((v + 0.055f) / 1.055f, 2.4f);
}

}  // namespace

Status load_sky_panorama(const std::filesystem::path& path, WorldSource& world) {
    const std::string name = path.string();
    const std::unique_ptr<OIIO::ImageInput> input = OIIO::ImageInput::open(name);
    if (!input) return bad_input(fmt::format("{}: not an image: {}", name, OIIO::geterror()));
    const OIIO::ImageSpec& spec = input->spec();
    if (spec.width > 8192 || spec.width < 2 || spec.width != 2 * spec.height || spec.nchannels < 3)
        return bad_input(
            fmt::format("{}: {} x {}, {} channels; expected colour, twice as wide as high, at most 8192 x "
                        "4096",
                        name, spec.width, spec.height, spec.nchannels));
    const std::size_t texels = std::size_t(spec.width) * std::size_t(spec.height),
                      channels = std::size_t(spec.nchannels);
    const bool encoded =
        spec.format.basetype == OIIO::TypeDesc::UINT8 || spec.format.basetype == OIIO::TypeDesc::UINT16;
    std::vector<float> values(texels * channels);
    if (!input->read_image(0, 0, 0, spec.nchannels, OIIO::TypeDesc::FLOAT, values.data()))
        return bad_input(fmt::format("{}: cannot be read: {}", name, input->geterror()));
    world.environment.panorama_width = std::uint32_t(spec.width);
    world.environment.panorama_height = std::uint32_t(spec.height);
    world.sky_panorama.resize(texels * 4);
    for (std::size_t i = 0; i < texels; ++i) {
        for (std::size_t c = 0; c < 3; ++c) {
            const float v = values[i * channels + c];
            world.sky_panorama[4 * i + c] = half_of(encoded ? linear_of_srgb(v) : v);
        }
        world.sky_panorama[4 * i + 3] = half_of(1.0f);
    }
    return {};
}

}  // namespace ff::cook
