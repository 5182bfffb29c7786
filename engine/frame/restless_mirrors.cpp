#include "engine/frame/restless_mirrors.h"

#include <array>
#include <bit>

#include "engine/core/jobs.h"
#include "engine/effects/mirrored_motion.h"
#include "engine/frame/history.h"

namespace ff::frame {
namespace {

using farfield::kTileSize;

enum class Rest : std::uint8_t { no_mirror, at_rest, restless };

/// Pixels of a row of a tile, by bits.
using Row = unsigned;

/// Where in a row a pixel sees another triangle than the one to its left. No branch and no search: a row is a few
/// vectors.
Row starts_of_runs(const std::uint32_t* instance, const std::uint32_t* triangle) {
    constexpr Row kBit[kTileSize] = {1u << 0, 1u << 1, 1u << 2,  1u << 3,  1u << 4,  1u << 5,  1u << 6,  1u << 7,
                                     1u << 8, 1u << 9, 1u << 10, 1u << 11, 1u << 12, 1u << 13, 1u << 14, 1u << 15};
    Row starts = 1u;
    for (int i = 1; i < kTileSize; ++i) {
        const std::uint32_t differs = (instance[i] ^ instance[i - 1]) | (triangle[i] ^ triangle[i - 1]);
        starts |= differs != 0 ? kBit[i] : 0u;
    }
    return starts;
}

/// Asks about the pixels of one tile after the other.
class RestTest {
  public:
    RestTest(const FramePlan& plan, const scene::StaticScene& scene, const FrameHistory& history)
        : scene_(scene),
          eye_(plan.view.position),
          seen_(history.visibility),
          within_m_(plan.reflections_within_m),
          waves_within_m_(plan.water_within_m),
          kind_of_(scene, plan.dynamic),
          motion_(plan.view, history.mirrored),
          any_moves_(!history.mirrored.empty()) {}

    void begin_tile(int x, int y) {
        x_ = x;
        y_ = y;
        is_begun_ = false;
        ++tile_;
    }

    /// Of pixels in a row of the tile, those of which keeps(Rest) is true.
    /// @param first  of the row, in the visibility buffer
    template <class Keeps>
    Row kept(std::size_t first, Row asked, Keeps&& keeps) {
        const std::uint32_t* const instance = seen_.instance.data() + first;
        if (skips(instance)) return keeps(Rest::no_mirror) ? asked : 0u;
        const Row starts = starts_of_runs(instance, seen_.triangle.data() + first);
        Row kept = 0;
        for (Row left = asked; left != 0;) {
            // What follows in the run of the first that is left.
            const Row begin = left & -left, later = starts & ~(2 * begin - 1);
            const Row end = later != 0 ? later & -later : 1u << kTileSize;
            const Row run = left & (end - begin);
            kept |= kept_of_run(first, run, keeps);
            left ^= run;
        }
        return kept;
    }

  private:
    /// What is known of a triangle, whichever tile it shows in.
    struct Facet {
        std::uint32_t instance = farfield::kSkyInstance, triangle = 0;
        effects::MirrorKind kind = effects::MirrorKind::none;
        bool has_plane = false;  ///< looked up, and not edge on
        farfield::MirrorPlane plane;
        unsigned tile = 0;  ///< in which `rest` is so, counted from 1
        Rest rest = Rest::no_mirror;
    };

    /// Whether none of a row's pixels can be a mirror: they show no instance that has any.
    bool skips(const std::uint32_t* instance) {
        unsigned other = 0;
        for (int i = 0; i < kTileSize; ++i)
            other |= unsigned(instance[i] != plain_) & unsigned(instance[i] != farfield::kSkyInstance);
        if (other == 0) return true;
        if (kind_of_.flags_of(instance[0]) == 0) plain_ = instance[0];
        return false;
    }

    template <class Keeps>
    Row kept_of_run(std::size_t first, Row run, Keeps&& keeps) {
        const std::size_t at = first + std::size_t(std::countr_zero(run));
        Facet& facet = facet_of(seen_.instance[at], seen_.triangle[at]);
        if (facet.kind == effects::MirrorKind::none) return keeps(Rest::no_mirror) ? run : 0u;
        const bool is_water = facet.kind == effects::MirrorKind::water;
        const float within_m = is_water ? waves_within_m_ : within_m_;
        if (facet.tile != tile_) {
            facet.tile = tile_;
            facet.rest = rest_of(facet);
        }
        // Near water has waves, which move; far glass mirrors nothing.
        const Rest near = is_water ? Rest::restless : facet.rest, far = is_water ? facet.rest : Rest::no_mirror;
        const bool keeps_near = keeps(near), keeps_far = keeps(far);
        if (keeps_near == keeps_far) return keeps_near ? run : 0u;
        Row kept = 0;
        for (Row left = run; left != 0; left &= left - 1) {
            const bool is_near = seen_.depth[first + std::size_t(std::countr_zero(left))] < within_m;
            if (is_near ? keeps_near : keeps_far) kept |= left & -left;
        }
        return kept;
    }

    Facet& facet_of(std::uint32_t instance, std::uint32_t triangle) {
        Facet& facet = facets_[(instance * 7 + triangle) % facets_.size()];
        if (facet.instance == instance && facet.triangle == triangle) return facet;
        facet.instance = instance;
        facet.triangle = triangle;
        facet.tile = 0;
        facet.kind = kind_of_(instance, triangle);
        facet.has_plane = false;
        if (facet.kind == effects::MirrorKind::none || !any_moves_ || instance >= scene_.instances.size()) return facet;
        const auto plane = effects::mirror_plane(scene_, scene_.instances[instance], triangle, eye_);
        facet.has_plane = plane.has_value();
        if (plane) facet.plane = *plane;
        return facet;
    }

    /// Of a mirror near enough, in the tile that was begun.
    Rest rest_of(const Facet& facet) {
        if (facet.instance >= scene_.instances.size()) return Rest::restless;
        if (!any_moves_) return Rest::at_rest;
        if (!facet.has_plane) return Rest::restless;  // seen edge on: whoever knows
        if (!is_begun_) motion_.begin_tile(x_, y_);
        is_begun_ = true;
        return motion_.shows(facet.plane) ? Rest::restless : Rest::at_rest;
    }

    const scene::StaticScene& scene_;
    WorldPos eye_;
    const farfield::VisibilityBuffer& seen_;
    float within_m_, waves_within_m_;
    effects::MirrorTest kind_of_;
    effects::MirroredMotion motion_;
    bool any_moves_;
    int x_ = 0, y_ = 0;
    unsigned tile_ = 0;
    bool is_begun_ = false;                         ///< few tiles have any mirror
    std::uint32_t plain_ = farfield::kSkyInstance;  ///< without mirrors
    std::array<Facet, 64> facets_;                  ///< panes come back row by row, and in the next tile
};

/// Leaves those pixels of a mask of which keeps(Rest) is true.
/// @param has_names  by tile: 0 where all are kept; empty: any tile may have some that are not
template <class Keeps>
void keep(const FramePlan& plan, const scene::StaticScene& scene, const FrameHistory& history,
          std::span<const std::uint8_t> has_names, farfield::PixelMask& mask, Keeps&& keeps) {
    constexpr std::size_t kTilesPerTask = 64;
    parallel_ranges(mask.tiles.size(), kTilesPerTask, [&](std::size_t begin, std::size_t end) {
        RestTest rest(plan, scene, history);
        for (std::size_t t = begin; t < end; ++t) {
            if (!has_names.empty() && has_names[t] == 0) continue;
            const int x = int(t % std::size_t(mask.tiles_x)) * kTileSize;
            const int y = int(t / std::size_t(mask.tiles_x)) * kTileSize;
            rest.begin_tile(x, y);
            for (int row = 0; row < kTileSize; ++row) {
                std::uint16_t& bits = mask.tiles[t].rows[row];
                if (bits != 0) bits = std::uint16_t(rest.kept(history.visibility.index(x, y + row), bits, keeps));
            }
        }
    });
}

}  // namespace

void find_mirrored(const FramePlan& plan, FrameHistory& history) {
    history.mirrored.clear();
    if (plan.effects.is_active(effects::EffectId::reflections))
        effects::find_mirrored(plan.view, history.moving, history.mirrored);
}

bool has_restless_mirrors(const FramePlan& plan, const FrameHistory& history) {
    return plan.effects.is_active(effects::EffectId::water) || !history.mirrored.empty();
}

void take_out_restless_mirrors(const FramePlan& plan, const scene::StaticScene& scene, const FrameHistory& history,
                               std::span<const std::uint8_t> has_names, farfield::PixelMask& mask) {
    keep(plan, scene, history, has_names, mask, [](Rest rest) { return rest != Rest::restless; });
}

void keep_resting_mirrors(const FramePlan& plan, const scene::StaticScene& scene, const FrameHistory& history,
                          farfield::PixelMask& mask) {
    keep(plan, scene, history, {}, mask, [](Rest rest) { return rest == Rest::at_rest; });
}

}  // namespace ff::frame
