#include "engine/frame/history.h"

namespace ff::frame {

void FrameHistory::reset(int width, int height) {
    governor = {};
    outlook = {};
    horizon.invalidate();
    for (farfield::PixelMask* mask :
         {&sources.near_field, &sources.sky, &sources.panorama, &sources.cast, &sources.dynamic, &named})
        mask->reset(width, height);
    visibility.width = 0;  // whatever its size was: nothing in it counts any more
    fit(width, height);
    for (auto* scratch : {&wanted, &requests, &to_shade, &to_store, &swaying}) {
        scratch->clear();
        scratch->reserve(all_tiles.size());
    }
    if (panorama) panorama->clear();
    if (sun) {
        sun->history.clear();
        sun->pause_frames = 0;
    }
    if (shelter) shelter->clear();
    if (reflections && !reflections->fits(width, height)) reflections.reset();
    if (reflections) reflections->step = ReflectionWork::kFirstStep;
    panorama_light = {};
    panorama_is_full = false;
    swaying_share = 0.0;
    rest_frames = 0;
    has_frame = false;
    frame_number = 0;
}

void FrameHistory::fit(int width, int height) {
    if (visibility.width == width && visibility.height == height) return;
    visibility.resize(width, height);
    all_tiles.clear();
    for (int y = 0; y < height; y += farfield::kTileSize) {
        for (int x = 0; x < width; x += farfield::kTileSize) {
            farfield::TileRequest tile;
            tile.x = std::uint16_t(x);
            tile.y = std::uint16_t(y);
            const int columns = std::min(farfield::kTileSize, width - x);
            for (int row = 0; row < std::min(farfield::kTileSize, height - y); ++row)
                tile.rows[row] = std::uint16_t((1u << columns) - 1u);
            all_tiles.push_back(tile);
        }
    }
}

}  // namespace ff::frame
