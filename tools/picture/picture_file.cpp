#include "tools/picture/picture_file.h"

#include <OpenImageIO/imageio.h>
#include <fmt/format.h>
#include <unistd.h>

namespace ff::tool {

Status write_image(const std::filesystem::path& path, const shading::Image& image) {
    // The ending decides the format, so the part file keeps it.
    const auto part = path.parent_path() / fmt::format(".part{}-{}", ::getpid(), path.filename().string());
    auto output = OIIO::ImageOutput::create(path.string());
    if (!output) return usage_error(fmt::format("{}: no image format has this ending; use .png", path.string()));
    OIIO::ImageSpec spec(image.width, image.height, 3, OIIO::TypeDesc::UINT8);
    spec.attribute("oiio:ColorSpace", "sRGB");
    spec.attribute("Compression", "jpeg:90");  // for JPEG alone
    std::error_code ignored;
    if (!output->open(part.string(), spec) ||
        !output->write_image(OIIO::TypeDesc::UINT8, image.pixels.data(), 4, OIIO::stride_t(image.stride) * 4) ||
        !output->close()) {
        std::filesystem::remove(part, ignored);
        return failure(fmt::format("{}: cannot write: {}", path.string(), output->geterror()));
    }
    std::filesystem::rename(part, path, ignored);
    if (ignored) return failure(fmt::format("{}: cannot rename into place: {}", path.string(), ignored.message()));
    return {};
}

Result<shading::Image> read_image(const std::filesystem::path& path) {
    const auto input = OIIO::ImageInput::open(path.string());
    if (!input) return bad_input(fmt::format("{}: cannot be read: {}", path.string(), OIIO::geterror()));
    const OIIO::ImageSpec& spec = input->spec();
    if (spec.format != OIIO::TypeDesc::UINT8 || (spec.nchannels != 3 && spec.nchannels != 4))
        return bad_input(fmt::format("{}: {} channels of {}; expected 3 or 4 of 8 bits", path.string(), spec.nchannels,
                                     spec.format.c_str()));
    shading::Image image;
    image.resize(spec.width, spec.height);
    if (!input->read_image(0, 0, 0, spec.nchannels, OIIO::TypeDesc::UINT8, image.pixels.data(), 4,
                           OIIO::stride_t(image.stride) * 4))
        return bad_input(fmt::format("{}: cannot be read: {}", path.string(), input->geterror()));
    for (std::uint32_t& pixel : image.pixels) pixel |= 0xFF000000u;
    return image;
}

}  // namespace ff::tool
