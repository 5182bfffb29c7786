#include "engine/farfield/visibility_buffer.h"

#include <limits>

namespace ff::farfield {

void VisibilityBuffer::resize(int new_width, int new_height) {
    width = new_width;
    height = new_height;
    stride = (width + kTileSize - 1) / kTileSize * kTileSize;
    rows = (height + kTileSize - 1) / kTileSize * kTileSize;
    const auto count = std::size_t(stride) * std::size_t(rows);
    instance.assign(count, kUnresolved);
    triangle.assign(count, 0);
    depth.assign(count, std::numeric_limits<float>::infinity());
}

}  // namespace ff::farfield
