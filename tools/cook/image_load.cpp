#include "tools/cook/image_load.h"

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imagebuf.h>
#include <OpenImageIO/imagebufalgo.h>
#include <OpenImageIO/imageio.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <fstream>
#include <memory>

#include "engine/core/hash.h"

namespace ff::cook {
namespace {

constexpr int kMaxSourceSize = 32768;
constexpr std::uint64_t kMaxSourcePixels = 1ull << 28;

// OpenImageIO chooses a reader by a file's name; a name after the first bytes serves every reader with the right one.
const char* format_name(std::span<const std::byte> bytes) {
    const auto starts = [&](std::string_view magic, std::size_t at = 0) {
        return bytes.size() >= at + magic.size() && std::memcmp(bytes.data() + at, magic.data(), magic.size()) == 0;
    };
    if (starts("\x89PNG")) return "image.png";
    if (starts("\xFF\xD8\xFF")) return "image.jpg";
    if (starts("RIFF") && starts("WEBP", 8)) return "image.webp";
    if (starts(std::string_view("II*\0", 4)) || starts(std::string_view("MM\0*", 4))) return "image.tif";
    if (starts("\x76\x2F\x31\x01")) return "image.exr";
    if (starts("#?RADIANCE") || starts("#?RGBE")) return "image.hdr";
    if (starts("BM")) return "image.bmp";
    if (starts("DDS ")) return "image.dds";
    if (starts("GIF8")) return "image.gif";
    return nullptr;
}

std::uint32_t nearest_power_of_two(int size) {
    std::uint32_t power = 1;
    while (power < kMaxTextureSize && static_cast<double>(power) * std::sqrt(2.0) < size) power *= 2;
    return power;
}

float srgb_encoded(float linear) {
    const float c = std::clamp(linear, 0.0f, 1.0f);
    return c <= 0.0031308f ? 12.92f * c : 1.055f * std::pow(c, 1.0f / 2.4f) - 0.055f;
}

std::uint32_t packed(const std::uint8_t* channels, int count) {
    std::uint32_t r = channels[0], g = r, b = r, a = 255;
    if (count == 2) a = channels[1];
    if (count >= 3) g = channels[1], b = channels[2];
    if (count >= 4) a = channels[3];
    return r | g << 8 | b << 16 | a << 24;
}

// Decodes to interleaved 8-bit channels.
Result<std::vector<std::uint8_t>> read_pixels(OIIO::ImageInput& input, const OIIO::ImageSpec& spec, int channels,
                                              const std::string& name) {
    const std::size_t count = static_cast<std::size_t>(spec.width) * static_cast<std::size_t>(spec.height) *
                              static_cast<std::size_t>(channels);
    std::vector<std::uint8_t> pixels(count);
    const bool linear = spec.format.is_floating_point();
    std::vector<float> values(linear ? count : 0);
    const bool good = linear ? input.read_image(0, 0, 0, channels, OIIO::TypeDesc::FLOAT, values.data())
                             : input.read_image(0, 0, 0, channels, OIIO::TypeDesc::UINT8, pixels.data());
    if (!good) return bad_input(fmt::format("{}: {}; expected a whole image", name, input.geterror()));
    for (std::size_t i = 0; i < values.size(); ++i) {
        const bool is_alpha =
            channels % 2 == 0 && i % static_cast<std::size_t>(channels) + 1 == static_cast<std::size_t>(channels);
        const float value = is_alpha ? std::clamp(values[i], 0.0f, 1.0f) : srgb_encoded(values[i]);
        pixels[i] = static_cast<std::uint8_t>(value * 255.0f + 0.5f);
    }
    return pixels;
}

// To powers of two, with colour weighted by alpha: the invisible texels of a cut-out must not bleed into its edge.
void resize(SourceTexture& texture, std::uint32_t width, std::uint32_t height) {
    const OIIO::ImageSpec from(static_cast<int>(texture.width), static_cast<int>(texture.height), 4,
                               OIIO::TypeDesc::UINT8);
    OIIO::ImageBuf source(from, texture.rgba.data());
    OIIO::ImageSpec float_spec = from;
    float_spec.format = OIIO::TypeDesc::FLOAT;
    float_spec.alpha_channel = 3;
    OIIO::ImageBuf premultiplied(float_spec);
    OIIO::ImageBufAlgo::copy(premultiplied, source, OIIO::TypeDesc::FLOAT);
    premultiplied.specmod().alpha_channel = 3;
    OIIO::ImageBufAlgo::premult(premultiplied, premultiplied, {}, 1);
    const OIIO::ROI roi(0, static_cast<int>(width), 0, static_cast<int>(height), 0, 1, 0, 4);
    OIIO::ImageBuf smaller = OIIO::ImageBufAlgo::resize(premultiplied, "", 0.0f, roi, 1);
    smaller.specmod().alpha_channel = 3;
    OIIO::ImageBufAlgo::unpremult(smaller, smaller, {}, 1);
    texture.width = width;
    texture.height = height;
    texture.rgba.resize(std::size_t{width} * height);
    std::vector<float> values(texture.rgba.size() * 4);
    smaller.get_pixels(roi, OIIO::TypeDesc::FLOAT, values.data());
    for (std::size_t i = 0; i < texture.rgba.size(); ++i) {
        std::uint8_t texel[4];
        for (std::size_t c = 0; c < 4; ++c)
            texel[c] = static_cast<std::uint8_t>(std::clamp(values[4 * i + c], 0.0f, 1.0f) * 255.0f + 0.5f);
        texture.rgba[i] = packed(texel, 4);
    }
}

// Whether a PNG's chunks follow each other up to IEND inside the file. OpenImageIO's reader leaks where libpng runs out
// of bytes: it jumps over the reader's own strings.
bool png_is_whole(std::span<const std::byte> bytes) {
    for (std::size_t at = 8; bytes.size() >= at + 12;) {
        std::uint32_t length = 0;
        for (std::size_t i = 0; i < 4; ++i) length = length << 8 | std::to_integer<std::uint32_t>(bytes[at + i]);
        if (std::memcmp(bytes.data() + at + 4, "IEND", 4) == 0) return true;
        at += std::size_t{12} + length;
    }
    return false;
}

Result<SourceTexture> decode(std::span<const std::byte> bytes, const std::string& name) {
    const char* file_name = format_name(bytes);
    if (file_name == nullptr)
        return bad_input(
            fmt::format("{}: {} bytes that are no image; expected PNG, JPEG, WebP, TIFF, EXR, HDR, BMP, "
                        "DDS or GIF",
                        name, bytes.size()));
    if (std::string_view(file_name) == "image.png" && !png_is_whole(bytes))
        return bad_input(fmt::format("{}: a PNG without its end; expected a whole image", name));
    OIIO::Filesystem::IOMemReader memory(const_cast<std::byte*>(bytes.data()), bytes.size());
    OIIO::ImageSpec config;
    config.attribute("oiio:UnassociatedAlpha", 1);  // as glTF and our textures have it
    // In the configuration as well: with one, readers take their proxy from there and nowhere else.
    OIIO::Filesystem::IOProxy* proxy = &memory;
    config.attribute("oiio:ioproxy", OIIO::TypeDesc::PTR, &proxy);
    const auto input = OIIO::ImageInput::open(file_name, &config, proxy);
    if (!input) return bad_input(fmt::format("{}: {}; expected an intact image", name, OIIO::geterror()));
    const OIIO::ImageSpec spec = input->spec();
    if (spec.width < 1 || spec.height < 1 || spec.width > kMaxSourceSize || spec.height > kMaxSourceSize ||
        spec.nchannels < 1 || static_cast<std::uint64_t>(spec.width) * spec.height > kMaxSourcePixels)
        return bad_input(fmt::format("{}: {} x {} pixels; expected at most {} a side and {} together", name, spec.width,
                                     spec.height, kMaxSourceSize, kMaxSourcePixels));
    const int channels = std::min(spec.nchannels, 4);
    FF_ASSIGN(const std::vector<std::uint8_t> pixels, read_pixels(*input, spec, channels, name));

    SourceTexture texture;
    texture.width = static_cast<std::uint32_t>(spec.width);
    texture.height = static_cast<std::uint32_t>(spec.height);
    texture.rgba.resize(pixels.size() / static_cast<std::size_t>(channels));
    for (std::size_t i = 0; i < texture.rgba.size(); ++i)
        texture.rgba[i] = packed(pixels.data() + i * static_cast<std::size_t>(channels), channels);
    const std::uint32_t width = nearest_power_of_two(spec.width), height = nearest_power_of_two(spec.height);
    if (width != texture.width || height != texture.height) resize(texture, width, height);
    return texture;
}

std::string texture_hash(const SourceTexture& texture) {
    const std::array<std::uint32_t, 2> size{texture.width, texture.height};
    return CacheKey("texels").add_value(size).add_array(texture.rgba).hex();
}

}  // namespace

Result<SourceTexture> decode_texture(std::span<const std::byte> bytes, const std::string& name, CookContext& context) {
    const CacheKey key = CacheKey("decode_texture 1").add_value(kMaxTextureSize).add(bytes);
    SourceTexture texture;
    if (const auto cached = context.cache().find(key)) {
        std::array<std::uint32_t, 2> size;
        std::memcpy(size.data(), cached->data(), sizeof size);
        texture.width = size[0];
        texture.height = size[1];
        texture.rgba.resize(std::size_t{size[0]} * size[1]);
        std::memcpy(texture.rgba.data(), cached->data() + sizeof size, texture.rgba.size() * 4);
    } else {
        try {  // readers inside OpenImageIO throw where memory fails
            FF_ASSIGN(texture, decode(bytes, name));
        } catch (const std::exception& e) {
            return bad_input(fmt::format("{}: {}; expected an intact image", name, e.what()));
        }
        const std::array<std::uint32_t, 2> size{texture.width, texture.height};
        std::vector<std::byte> entry(sizeof size + texture.rgba.size() * 4);
        std::memcpy(entry.data(), size.data(), sizeof size);
        std::memcpy(entry.data() + sizeof size, texture.rgba.data(), texture.rgba.size() * 4);
        context.cache().store(key, entry);
    }
    texture.name = name;
    texture.content_hash = texture_hash(texture);
    return texture;
}

Result<SourceTexture> load_texture(const std::filesystem::path& path, CookContext& context) {
    FF_ASSIGN(const std::vector<std::byte> bytes, read_file_bytes(path));
    context.add_input(path, bytes.size());
    return decode_texture(bytes, path.string(), context);
}

Result<std::vector<std::byte>> read_file_bytes(const std::filesystem::path& path) {
    std::error_code error;
    if (std::filesystem::is_directory(path, error))
        return bad_input(fmt::format("{}: a directory; expected a file", path.string()));
    std::ifstream in(path, std::ios::binary | std::ios::ate);
    if (!in) return bad_input(fmt::format("{}: cannot open: {}", path.string(), std::strerror(errno)));
    const std::streamoff size = in.tellg();
    if (size < 0) return bad_input(fmt::format("{}: no length; expected a plain file", path.string()));
    std::vector<std::byte> bytes(static_cast<std::size_t>(size));
    in.seekg(0);
    if (!in.read(reinterpret_cast<char*>(bytes.data()), size))
        return bad_input(fmt::format("{}: cannot read: {}", path.string(), std::strerror(errno)));
    return bytes;
}

}  // namespace ff::cook
