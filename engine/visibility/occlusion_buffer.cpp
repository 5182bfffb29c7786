#include "engine/visibility/occlusion_buffer.h"

#include <algorithm>
#include <cmath>
#include <glm/matrix.hpp>
#include <limits>

#include "engine/core/check.h"

namespace ff::visibility {

void OcclusionBuffer::resize(int width, int height) {
    if (width == width_ && height == height_) return;
    width_ = width;
    height_ = height;
    row_.resize(std::size_t(width));
    levels_.clear();
    std::size_t size = 0;
    int w = (width + kBlockPixels - 1) / kBlockPixels, h = (height + kBlockPixels - 1) / kBlockPixels;
    for (;;) {
        levels_.push_back({w, h, size});
        size += std::size_t(w) * std::size_t(h);
        if (w == 1 && h == 1) break;
        w = (w + 1) / 2;
        h = (h + 1) / 2;
    }
    farthest_.resize(size);
}

void OcclusionBuffer::reduce_pixels(std::span<const float> depth) {
    const auto width = std::size_t(width_);
    for (int block_y = 0; block_y < levels_[0].height; ++block_y) {
        const int first_row = block_y * kBlockPixels, end_row = std::min(first_row + kBlockPixels, height_);
        const float* first = depth.data() + std::size_t(first_row) * width;
        std::copy_n(first, width, row_.data());
        for (int y = first_row + 1; y < end_row; ++y) {
            const float* row = depth.data() + std::size_t(y) * width;
            for (std::size_t x = 0; x < width; ++x) row_[x] = row[x] < row_[x] ? row[x] : row_[x];
        }
        float* out = &farthest_[std::size_t(block_y) * std::size_t(levels_[0].width)];
        for (std::size_t x = 0; x < width; x += kBlockPixels) {
            float least = row_[x];
            for (std::size_t i = x + 1; i < std::min(x + kBlockPixels, width); ++i) least = std::min(least, row_[i]);
            *out++ = least;
        }
    }
}

void OcclusionBuffer::build(const PinholeView& view, std::span<const float> depth, float near_plane_m) {
    FF_CHECK(depth.size() == std::size_t(view.width) * std::size_t(view.height) && near_plane_m > 0.0f,
             "{} depths for {} x {} pixels, near plane {} m", depth.size(), view.width, view.height, near_plane_m);
    resize(view.width, view.height);
    camera_from_world_ = glm::transpose(DMat3(view.world_from_camera));
    position_ = view.position;
    u_step_ = view.u_step;
    u_first_ = view.u_first;
    v_step_ = view.v_step;
    v_first_ = view.v_first;
    near_plane_m_ = near_plane_m;
    reduce_pixels(depth);
    for (std::size_t l = 1; l < levels_.size(); ++l) {
        const Level &fine = levels_[l - 1], &coarse = levels_[l];
        const auto at = [&](int x, int y) {
            return farthest_[fine.first + std::size_t(std::min(y, fine.height - 1)) * std::size_t(fine.width) +
                             std::size_t(std::min(x, fine.width - 1))];
        };
        float* out = &farthest_[coarse.first];
        for (int y = 0; y < coarse.height; ++y)
            for (int x = 0; x < coarse.width; ++x)
                *out++ = std::min(std::min(at(2 * x, 2 * y), at(2 * x + 1, 2 * y)),
                                  std::min(at(2 * x, 2 * y + 1), at(2 * x + 1, 2 * y + 1)));
    }
}

bool OcclusionBuffer::is_hidden(const DBox3& box) const {
    if (levels_.empty() || box.is_empty()) return false;
    const DVec3 low = camera_from_world_ * (box.low - position_), extent = box.extent();
    const DVec3 along[3] = {camera_from_world_[0] * extent.x, camera_from_world_[1] * extent.y,
                            camera_from_world_[2] * extent.z};
    double nearest_m = std::numeric_limits<double>::infinity();
    double x0 = nearest_m, y0 = nearest_m, x1 = -nearest_m, y1 = -nearest_m;
    for (int corner = 0; corner < 8; ++corner) {
        DVec3 p = low;
        for (int axis = 0; axis < 3; ++axis)
            if (corner >> axis & 1) p += along[axis];
        const double depth_m = -p.z;
        if (!(depth_m > near_plane_m_)) return false;
        nearest_m = std::min(nearest_m, depth_m);
        const double x = (p.x / depth_m - u_first_) / u_step_, y = (p.y / depth_m - v_first_) / v_step_;
        x0 = std::min(x0, x);
        x1 = std::max(x1, x);
        y0 = std::min(y0, y);
        y1 = std::max(y1, y);
    }
    // A pixel more on each side than its centre asks for: whatever rounding there is, here and in the rasteriser.
    x0 = std::max(std::floor(x0) - 1.0, 0.0);
    y0 = std::max(std::floor(y0) - 1.0, 0.0);
    x1 = std::min(std::floor(x1) + 1.0, double(width_ - 1));
    y1 = std::min(std::floor(y1) + 1.0, double(height_ - 1));
    if (!(x0 <= x1 && y0 <= y1)) return true;
    int bx0 = int(x0) / kBlockPixels, by0 = int(y0) / kBlockPixels;
    int bx1 = int(x1) / kBlockPixels, by1 = int(y1) / kBlockPixels;
    std::size_t l = 0;
    for (; std::max(bx1 - bx0, by1 - by0) >= kBlocksTested; ++l) {
        bx0 /= 2;
        by0 /= 2;
        bx1 /= 2;
        by1 /= 2;
    }
    const Level& level = levels_[l];
    const float box_depth = float(near_plane_m_ / nearest_m * (1.0 + kDepthSlack));
    for (int y = by0; y <= by1; ++y) {
        const float* row = &farthest_[level.first + std::size_t(y) * std::size_t(level.width)];
        for (int x = bx0; x <= bx1; ++x)
            if (!(row[x] > box_depth)) return false;
    }
    return true;
}

}  // namespace ff::visibility
