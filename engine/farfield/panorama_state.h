#pragma once
// The panorama's state between and within frames; what the files of class Panorama share.

#include "engine/farfield/panorama_kernels.h"
#include "engine/farfield/panorama_map.h"

namespace ff::farfield {

using PixelHistogram = std::array<std::uint64_t, 256>;

struct Panorama::State {
    PanoramaSettings settings;
    PanoramaMap map;

    // Confidence records: a ring, number 0 is "never traced".
    std::vector<ConfidenceRecord> records;
    std::uint16_t record = kNeverTraced;  ///< of this frame
    std::uint64_t frame = 0;
    std::uint64_t records_made = 0;

    // Moves of the viewer since each record, in the axes of the view that was asked for last.
    std::vector<float> moved_x, moved_y, moved_z;

    // Filling.
    struct Candidate {
        std::uint32_t tile;  ///< in map.tiles
        std::uint32_t texels;
        std::uint8_t worth;  ///< class of the tile
    };
    std::vector<Candidate> candidates;
    std::vector<std::uint32_t> marked;  ///< per texel tile: frame stamp of its last mark
    std::vector<std::uint8_t> needs;    ///< per pixel tile: some of its texels are not good
    std::uint32_t stamp = 0;
    std::array<std::vector<TileRequest>, 6> requests;  ///< what plan_fill chose
    bool is_fill_complete = true;                      ///< which was all that it was asked for

    // Lookup.
    std::vector<panorama::TileClasses> classes;  ///< per wanted tile
    std::vector<std::uint32_t> at_threshold;     ///< per wanted tile: pixels of the class that is cast in part

    std::vector<std::uint32_t> wanted_at;  ///< per tile of the view: its place among the wanted ones + 1, or 0

    // Pixels left aside for verify_edges.
    std::vector<TileRequest> edges;         ///< per wanted tile
    std::vector<std::uint32_t> edge_tiles;  ///< those that have any

    std::vector<PixelHistogram> task_classes, task_parallax;  ///< per parallel task

    // Texel tiles whose contents changed.
    std::vector<std::uint32_t> changed, dirty;
    std::vector<panorama::TexelBox> dirty_part;  ///< per texel tile: its quads to compute anew; valid for dirty ones

    [[nodiscard]] panorama::LookupJob job(const PinholeView& view, const PanoramaLimits& limits);
    void mark(std::uint32_t tile, std::vector<std::uint32_t>& list);
    /// Recomputes what is known of the `changed` tiles and the quads in and left and above of them; empties the list.
    void refresh_changed();
    void refresh_tile(std::uint32_t tile);
    /// Forgets texels of records that are about to be used again, a part of the map each time.
    void sweep_old_records();
};

}  // namespace ff::farfield
