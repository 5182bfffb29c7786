#pragma once

#include <filesystem>

#include "engine/core/result.h"
#include "tools/cook/world_source.h"

namespace ff::cook {

/// Reads an equirectangular sky (EXR, HDR, or any image that OpenImageIO reads; 8- and 16-bit ones are sRGB) into the
/// world's environment. Row 0 is the zenith; column 0 looks north and columns grow to the east.
/// Errors: bad_input for what is no image, is larger than 8192 x 4096, or is not twice as wide as high.
Status load_sky_panorama(const std::filesystem::path& path, WorldSource& world);

}  // namespace ff::cook
