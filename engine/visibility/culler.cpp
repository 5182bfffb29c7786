#include "engine/visibility/culler.h"

#include <algorithm>
#include <cmath>

namespace ff::visibility {

Culler::Culler(const scene::StaticScene& scene) : scene_(scene) {
    // Squares of about 4 x 4 cells: one test stands for sixteen.
    const auto side = std::size_t(std::clamp(std::ceil(std::sqrt(double(scene.cells.size())) / 4.0), 1.0, 64.0));
    const DVec3 extent = glm::max(scene.bounds.extent(), DVec3(1e-3));
    const auto square_of = [&](const scene::Cell& cell) {
        const DVec3 place = (cell.bounds.center() - scene.bounds.low) / extent * double(side);
        const auto clamped = [&](double p) { return p > 0.0 ? std::min(std::size_t(p), side - 1) : 0; };
        return clamped(place.z) * side + clamped(place.x);
    };
    std::vector<std::vector<std::uint32_t>> members(side * side);
    for (std::uint32_t c = 0; c < scene.cells.size(); ++c) {
        if (!scene.cells[c].bounds.is_empty()) members[square_of(scene.cells[c])].push_back(c);
        most_ = std::max<std::size_t>(most_, scene.cells[c].instance_count);
    }
    for (const auto& square : members) {
        if (square.empty()) continue;
        squares_.push_back({std::uint32_t(cells_.size()), std::uint32_t(square.size())});
        DBox3 box;
        for (std::uint32_t c : square) {
            box.add(scene.cells[c].bounds);
            cells_.push_back(c);
            cell_boxes_.add(scene.cells[c].bounds, scene.origin);
        }
        square_boxes_.add(box, scene.origin);
        most_ = std::max(most_, square.size());
    }
    most_ = std::max(most_, squares_.size());
    for (const scene::Instance& instance : scene.instances)
        instance_boxes_.add(instance.bounds, scene.cells[instance.cell].origin);
    square_boxes_.finish();
    cell_boxes_.finish();
    instance_boxes_.finish();
}

void Culler::cull(const PinholeView& view, std::span<const scene::Instance> dynamic, VisibleSet& out,
                  double max_distance_m) const {
    const Frustum frustum = make_frustum(view);
    out.cells.clear();
    out.instances.clear();
    out.candidates.clear();
    out.overlaps.resize(most_ + kCullPadding);
    out.boxes_tested = squares_.size() + dynamic.size();

    for (std::size_t i = 0; i < dynamic.size(); ++i)
        if (!is_outside(frustum, dynamic[i].bounds))
            out.instances.push_back(std::uint32_t(scene_.instances.size() + i));

    // The squares that may be seen; out.cells holds them until the cells' own tests reuse the overlaps.
    cull_boxes(frustum, square_boxes_, scene_.origin, 0, squares_.size(), out.overlaps);
    for (std::uint32_t s = 0; s < squares_.size(); ++s)
        if (out.overlaps[s] != Overlap::outside) out.cells.push_back(s);
    for (std::uint32_t s : out.cells) {
        const Square& square = squares_[s];
        cull_boxes(frustum, cell_boxes_, scene_.origin, square.first, square.count, out.overlaps);
        out.boxes_tested += square.count;
        for (std::uint32_t i = 0; i < square.count; ++i) {
            if (out.overlaps[i] == Overlap::outside) continue;
            const std::uint32_t cell = cells_[square.first + i];
            const double distance = distance_to(scene_.cells[cell].bounds, view.position);
            if (distance < max_distance_m)
                out.candidates.push_back({distance, cell, out.overlaps[i] == Overlap::inside});
        }
    }
    out.cells.clear();

    std::sort(out.candidates.begin(), out.candidates.end(),
              [](const VisibleSet::Candidate& a, const VisibleSet::Candidate& b) {
                  return a.distance_m != b.distance_m ? a.distance_m < b.distance_m : a.cell < b.cell;
              });
    for (const VisibleSet::Candidate& candidate : out.candidates) {
        const scene::Cell& cell = scene_.cells[candidate.cell];
        out.cells.push_back(candidate.cell);
        if (candidate.inside) {
            for (std::uint32_t i = 0; i < cell.instance_count; ++i) out.instances.push_back(cell.first_instance + i);
            continue;
        }
        cull_boxes(frustum, instance_boxes_, cell.origin, cell.first_instance, cell.instance_count, out.overlaps);
        out.boxes_tested += cell.instance_count;
        for (std::uint32_t i = 0; i < cell.instance_count; ++i)
            if (out.overlaps[i] != Overlap::outside) out.instances.push_back(cell.first_instance + i);
    }
}

}  // namespace ff::visibility
