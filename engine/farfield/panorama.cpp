// Records, and the bookkeeping of changed texels. Filling stands in panorama_fill.cpp, lookups in panorama_lookup.cpp,
// storing and forgetting in panorama_store.cpp, the inner loops in panorama_kernels.cpp.

#include "engine/farfield/panorama.h"

#include <glm/geometric.hpp>

#include "engine/core/check.h"
#include "engine/core/jobs.h"
#include "engine/farfield/panorama_state.h"

namespace ff::farfield {

Panorama::Panorama(const PanoramaSettings& settings) : state_(std::make_unique<State>()) {
    const int size = settings.face_size;
    FF_CHECK(size >= 64 && size <= 2048 && size % kTileSize == 0,
             "panorama faces of {} texels; a multiple of 16 in "
             "[64, 2048]",
             size);
    FF_CHECK(settings.edge_contrast >= 0 && settings.edge_contrast <= 255, "edge contrast {}; [0, 255]",
             settings.edge_contrast);
    FF_CHECK(settings.strong_contrast >= 0 && settings.strong_contrast <= 255, "strong contrast {}; [0, 255]",
             settings.strong_contrast);
    State& s = *state_;
    s.settings = settings;
    s.map.size = size;
    s.map.tiles_side = size / kTileSize;
    // The outermost texel centres lie just beyond the face's edge, so that four texels of one face surround every
    // direction.
    s.map.extent = float(size) / float(size - 2);
    // A tile's row more than the faces need: the kernels read a row below and a texel to the right.
    const std::size_t texels = std::size_t(size) * std::size_t(6 * size + kTileSize);
    VisibilityBuffer& visibility = s.map.visibility;
    visibility.width = visibility.stride = size;
    visibility.height = 6 * size;
    visibility.rows = 6 * size + kTileSize;
    visibility.instance.resize(texels);
    visibility.triangle.resize(texels);
    visibility.depth.resize(texels);
    s.map.colors.resize(texels);
    s.map.records.resize(texels);
    s.map.tiles.assign(std::size_t(6 * s.map.tiles_side) * std::size_t(s.map.tiles_side), TexelTile{});
    s.records.assign(kRecordCount, ConfidenceRecord{});
    s.moved_x.assign(kRecordCount, 0.0f);
    s.moved_y.assign(kRecordCount, 0.0f);
    s.moved_z.assign(kRecordCount, 0.0f);
    s.marked.assign(s.map.tiles.size(), 0);
    s.dirty_part.resize(s.map.tiles.size());
    s.candidates.reserve(s.map.tiles.size());
    s.changed.reserve(s.map.tiles.size());
    s.dirty.reserve(s.map.tiles.size());
    for (auto& list : s.requests) list.reserve(s.map.tiles.size() / 6);
}

Panorama::~Panorama() = default;

namespace {

/// Of a face, for texels of 0.8 pixels.
float texels_for(const PinholeView& view, float density) {
    return density * 2.0f / (0.8f * view.pixel_angle());
}

}  // namespace

int Panorama::face_size_for(const PinholeView& view, float density) {
    int size = (int(std::min(texels_for(view, density), 2032.0f)) + kTileSize - 1) / kTileSize * kTileSize;
    if (size % 256 == 0) size += kTileSize;  // see PanoramaSettings
    return std::clamp(size, 64, 2048);
}

bool Panorama::is_too_coarse(int face_size, const PinholeView& view, float density) {
    return 1.5f * float(std::max(face_size, 64)) < texels_for(view, density);
}

const PanoramaSettings& Panorama::settings() const {
    return state_->settings;
}

VisibilityBuffer& Panorama::map() {
    return state_->map.visibility;
}

void Panorama::clear() {
    State& s = *state_;
    const auto side = std::size_t(s.map.tiles_side);
    for (std::size_t tile = 0; tile < s.map.tiles.size(); ++tile) {
        if (s.map.tiles[tile].record == kNeverTraced) continue;
        s.map.tiles[tile] = {};
        for (std::size_t j = 0; j < kTileSize; ++j) {
            const std::size_t row = s.map.index(int(tile % side) * kTileSize, int(tile / side * kTileSize + j));
            std::fill_n(s.map.colors.begin() + std::ptrdiff_t(row), kTileSize, 0u);
            std::fill_n(s.map.records.begin() + std::ptrdiff_t(row), kTileSize, kNeverTraced);
        }
    }
    for (auto& list : s.requests) list.clear();
}

void Panorama::populate() {
    State& s = *state_;
    populate_pages(s.map.visibility.instance);
    populate_pages(s.map.visibility.triangle);
    populate_pages(s.map.visibility.depth);
    populate_pages(s.map.colors);
    populate_pages(s.map.records);
}

void Panorama::begin_frame(const WorldPos& position) {
    State& s = *state_;
    ++s.frame;
    const bool has_moved = s.record == kNeverTraced ||
                           glm::distance(position, s.records[s.record].position) > s.settings.record_distance_m;
    if (!has_moved) return;
    ++s.records_made;
    s.record = std::uint16_t(s.record + 1 < kRecordCount ? s.record + 1 : 1);
    s.records[s.record] = {position, s.frame};
    s.sweep_old_records();
}

PinholeView Panorama::face_view(int face) const {
    const State& s = *state_;
    const int size = s.map.size;
    PinholeView view = make_cube_face_view(s.records[s.record].position, face, size);
    view.height = 6 * size;
    view.u_step *= s.map.extent;
    view.u_first *= s.map.extent;
    view.v_step *= s.map.extent;
    view.v_first = s.map.extent * float(1 + 2 * face);
    return view;
}

std::int64_t Panorama::age(const Vec3& direction) const {
    const State& s = *state_;
    const FacePoint p = face_point(direction);
    const int last = s.map.size - 1;
    const int x = std::clamp(int(texel_x(s.map, p.a) + 0.5f), 0, last);
    const int y = std::clamp(int(texel_y(s.map, p.b) + 0.5f), 0, last) + p.face * s.map.size;
    const std::uint16_t record = s.map.records[s.map.index(x, y)];
    return record == kNeverTraced ? -1 : std::int64_t(s.frame - s.records[record].frame);
}

std::uint64_t Panorama::memory_bytes() const {
    const State& s = *state_;
    return s.map.colors.size() * 18 + s.map.tiles.size() * (sizeof(TexelTile) + 4 + sizeof(State::Candidate)) +
           s.classes.size() * sizeof(panorama::TileClasses);
}

panorama::LookupJob Panorama::State::job(const PinholeView& view, const PanoramaLimits& limits) {
    const auto in_use = std::size_t(std::min<std::uint64_t>(records_made + 1, kRecordCount));
    for (std::size_t i = 1; i < in_use; ++i) {
        const Vec3 moved = Vec3(view.position - records[i].position);
        moved_x[i] = glm::dot(moved, view.world_from_camera[0]);
        moved_y[i] = glm::dot(moved, view.world_from_camera[1]);
        moved_z[i] = glm::dot(moved, view.world_from_camera[2]);
    }
    panorama::LookupJob job;
    job.map = &map;
    job.view = &view;
    job.moved_x = moved_x.data();
    job.moved_y = moved_y.data();
    job.moved_z = moved_z.data();
    job.focal_px = 1.0f / view.pixel_angle();
    job.by_distance = limits.measure == ConfidenceMeasure::distance;
    job.limit = job.by_distance ? limits.max_distance_m : limits.max_parallax_px;
    return job;
}

void Panorama::State::mark(std::uint32_t tile, std::vector<std::uint32_t>& list) {
    if (marked[tile] == stamp) return;
    marked[tile] = stamp;
    list.push_back(tile);
}

void Panorama::State::refresh_tile(std::uint32_t tile) {
    const auto side = std::uint32_t(map.tiles_side);
    const int x0 = int(tile % side) * kTileSize, y0 = int(tile / side) * kTileSize;
    TexelTile out{.record = map.records[map.index(x0, y0)],
                  .complete = true,
                  .any_marked = map.tiles[tile].any_marked,
                  .nearest_m = std::numeric_limits<float>::infinity()};
    for (int j = 0; j < kTileSize; ++j) {
        const std::size_t row = map.index(x0, y0 + j);
        for (std::size_t i = row; i < row + kTileSize; ++i) {
            if (map.records[i] != out.record) out.record = kMixedRecords;
            if (map.records[i] == kNeverTraced) out.complete = false;
            out.nearest_m = std::min(out.nearest_m, map.visibility.depth[i]);
        }
    }
    map.tiles[tile] = out;
}

void Panorama::State::refresh_changed() {
    parallel_ranges(changed.size(), 8, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) refresh_tile(changed[i]);
    });
    // Quads look a little beyond their tile, so the sides of the tiles around have to follow.
    const int side = map.tiles_side;
    ++stamp;
    dirty.clear();
    for (const std::uint32_t tile : changed) {
        const int x = int(tile) % side, row = int(tile) / side, face_row = row / side * side;
        for (int j = std::max(row - 1, face_row); j <= std::min(row + 1, face_row + side - 1); ++j)
            for (int i = std::max(x - 1, 0); i <= std::min(x + 1, side - 1); ++i) {
                const auto neighbour = std::uint32_t(j * side + i);
                if (marked[neighbour] != stamp) dirty_part[neighbour] = {};
                mark(neighbour, dirty);
                const panorama::TexelBox box = panorama::quads_that_see(x - i, row - j);
                panorama::TexelBox& part = dirty_part[neighbour];
                part = {std::min(part.x0, box.x0), std::max(part.x1, box.x1), std::min(part.y0, box.y0),
                        std::max(part.y1, box.y1)};
            }
    }
    // Neighbours take turns: a tile's quads read its neighbours' colours.
    const panorama::ContrastLimits contrast{settings.edge_contrast, settings.strong_contrast};
    for (int turn = 0; turn < 4; ++turn)
        parallel_ranges(dirty.size(), 16, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) {
                const int x = int(dirty[i]) % side, row = int(dirty[i]) / side;
                if ((x & 1) + 2 * (row & 1) == turn)
                    panorama::update_quads(map, x, row, dirty_part[dirty[i]], contrast);
            }
        });
    changed.clear();
}

void Panorama::State::sweep_old_records() {
    const std::size_t count = map.tiles.size();
    const std::size_t step = std::size_t(records_made % kSweepSteps);
    ++stamp;
    for (std::size_t tile = step * count / kSweepSteps; tile < (step + 1) * count / kSweepSteps; ++tile) {
        const std::uint16_t of_tile = map.tiles[tile].record;
        const auto is_old = [&](std::uint16_t r) {
            return r != kNeverTraced && (record + kRecordCount - 1 - r) % (kRecordCount - 1) > kRecordLifetime;
        };
        if (of_tile != kMixedRecords && !is_old(of_tile)) continue;
        const auto side = std::size_t(map.tiles_side);
        const int x0 = int(tile % side) * kTileSize, y0 = int(tile / side) * kTileSize;
        bool any = false;
        for (int j = 0; j < kTileSize; ++j)
            for (int i = 0; i < kTileSize; ++i) {
                std::uint16_t& r = map.records[map.index(x0 + i, y0 + j)];
                if (!is_old(r)) continue;
                r = kNeverTraced;
                any = true;
            }
        if (any) mark(std::uint32_t(tile), changed);
    }
    refresh_changed();
}

}  // namespace ff::farfield
