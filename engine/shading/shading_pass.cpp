#include "engine/shading/shading_pass.h"

#include <atomic>
#include <cmath>

#include "engine/core/check.h"
#include "engine/core/jobs.h"
#include "engine/shading/shade_frame.h"
#include "engine/shading/shading_kernel.h"

namespace ff::shading {
namespace {
// A few tiles a task: few enough for two workers to end together, enough to pay for a task.
constexpr std::size_t kTilesPerTask = 16;
}  // namespace

void Image::resize(int new_width, int new_height) {
    constexpr int kSize = farfield::kTileSize;
    width = new_width;
    height = new_height;
    stride = (width + kSize - 1) / kSize * kSize;
    // New memory, which is zeroed where it is touched: the panorama shades a few tiles of a large image at a time.
    pixels = ZeroPageVector<std::uint32_t>(std::size_t(stride) * std::size_t((height + kSize - 1) / kSize * kSize));
}

std::uint64_t shade_tiles(const scene::StaticScene& scene, std::span<const scene::Instance> dynamic,
                          const PinholeView& view, const farfield::VisibilityBuffer& visibility,
                          std::span<const farfield::TileRequest> tiles, const ShadeSettings& settings, Image& out) {
    FF_CHECK(out.width == view.width && out.height == view.height && out.stride == visibility.stride,
             "image {}x{} stride {} for a view of {}x{}, visibility stride {}", out.width, out.height, out.stride,
             view.width, view.height, visibility.stride);
    FF_CHECK(visibility.width == view.width && visibility.height == view.height, "visibility {}x{} for a view of {}x{}",
             visibility.width, visibility.height, view.width, view.height);
    FF_CHECK(std::isinf(settings.prelit_beyond_m) || !scene.prelit_colors.empty(),
             "prelit beyond {} m, but the scene has no prelit colours", settings.prelit_beyond_m);
    ShadeFrame frame{scene, dynamic, view, visibility, settings, make_uniforms(scene.environment, view), {}, out};
    if (settings.plain_srgb) frame.uniforms.panorama_size.w = 0.0f;
    frame.near_air = make_near_air(frame.uniforms, settings.air_error);
    std::atomic<std::uint64_t> pixels{0};
    parallel_ranges(tiles.size(), uneven_grain(tiles.size(), kTilesPerTask), [&](std::size_t begin, std::size_t end) {
        TileScratch scratch;
        pixels += shade_tile_batch(frame, tiles.subspan(begin, end - begin), scratch);
    });
    return pixels;
}

}  // namespace ff::shading
