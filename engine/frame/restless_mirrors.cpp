#include "engine/frame/restless_mirrors.h"

#include <array>
#include <bit>

#include "engine/core/jobs.h"
#include "engine/effects/mirrored_motion.h"
#include "engine/farfield/tile_row.h"
#include "engine/frame/history.h"

namespace ff::frame {
namespace {

using farfield::kTileSize;

enum class Rest : std::uint8_t { no_mirror, at_rest, restless };

using Row = farfield::TileRow;

namespace hn = hwy::HWY_NAMESPACE;
constexpr hn::FixedTag<std::uint32_t, 4> kFourNames;
constexpr hn::FixedTag<float, 4> kFourDepths;

/// Where in a row a pixel sees another triangle than the one so many before it; of the row's first pixel, where that is
/// one, anything.
Row differs_from(const std::uint32_t* instance, const std::uint32_t* triangle, std::ptrdiff_t before) {
    const auto same = [&](const std::uint32_t* row, int i) {
        const auto names = hn::LoadU(kFourNames, row + i);
        // Nothing lies before the first pixel of all.
        const auto others =
            i == 0 && before == 1 ? hn::ShiftLeftLanes<1>(kFourNames, names) : hn::LoadU(kFourNames, row + i - before);
        return hn::Eq(names, others);
    };
    return ~farfield::tile_row_of(kFourNames, [&](int i) { return hn::And(same(instance, i), same(triangle, i)); }) &
           farfield::kWholeTileRow;
}

/// What of a row lies nearer than a depth.
Row nearer(const float* depth, float within_m) {
    const auto within = hn::Set(kFourDepths, within_m);
    return farfield::tile_row_of(kFourDepths, [&](int i) { return hn::Lt(hn::LoadU(kFourDepths, depth + i), within); });
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

    /// Whether any of the pixels asked for of the tile may be restless: each patch that sees one triangle is asked
    /// about once, not each of its rows.
    bool any_restless(int x, int y, const farfield::TileMask& asked) {
        Row above = 0;
        for (int row = 0; row < kTileSize; ++row) {
            const Row bits = asked.rows[row];
            const std::size_t first = seen_.index(x, y + row);
            if (bits != 0) {
                const std::uint32_t* const instance = seen_.instance.data() + first;
                const std::uint32_t* const triangle = seen_.triangle.data() + first;
                Row starts = bits & (differs_from(instance, triangle, 1) | ~(bits << 1));
                if (above != 0) starts &= differs_from(instance, triangle, seen_.stride) | ~above;
                for (; starts != 0; starts &= starts - 1) {
                    const Facet& facet = rested_facet_of(first + std::size_t(std::countr_zero(starts)));
                    if (facet.kind == effects::MirrorKind::water || facet.rest == Rest::restless) return true;
                }
            }
            above = bits;
        }
        return false;
    }

    /// Of pixels in a row of the tile, those of which keeps(Rest) is true.
    /// @param first  of the row, in the visibility buffer
    template <class Keeps>
    Row kept(std::size_t first, Row asked, Keeps&& keeps) {
        const std::uint32_t* const instance = seen_.instance.data() + first;
        if (kind_of_.is_plain_row(instance)) return keeps(Rest::no_mirror) ? asked : 0u;
        const Row starts = differs_from(instance, seen_.triangle.data() + first, 1) | 1u;
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

    template <class Keeps>
    Row kept_of_run(std::size_t first, Row run, Keeps&& keeps) {
        const Facet& facet = rested_facet_of(first + std::size_t(std::countr_zero(run)));
        if (facet.kind == effects::MirrorKind::none) return keeps(Rest::no_mirror) ? run : 0u;
        const bool is_water = facet.kind == effects::MirrorKind::water;
        const float within_m = is_water ? waves_within_m_ : within_m_;
        // Near water has waves, which move; far glass mirrors nothing.
        const Rest near = is_water ? Rest::restless : facet.rest, far = is_water ? facet.rest : Rest::no_mirror;
        const bool keeps_near = keeps(near), keeps_far = keeps(far);
        if (keeps_near == keeps_far) return keeps_near ? run : 0u;
        const Row near_pixels = nearer(seen_.depth.data() + first, within_m);
        return run & (keeps_near ? near_pixels : ~near_pixels);
    }

    /// What a pixel sees, and whether that is at rest in this tile.
    const Facet& rested_facet_of(std::size_t at) {
        Facet& facet = facet_of(seen_.instance[at], seen_.triangle[at]);
        if (facet.tile == tile_) return facet;
        facet.tile = tile_;
        facet.rest = facet.kind == effects::MirrorKind::none ? Rest::no_mirror : rest_of(facet);
        return facet;
    }

    Facet& facet_of(std::uint32_t instance, std::uint32_t triangle) {
        Facet& facet = facets_[(instance * 37 + triangle) % facets_.size()];
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
    bool is_begun_ = false;          ///< few tiles have any mirror
    std::array<Facet, 128> facets_;  ///< panes come back row by row, and in the next tile
};

/// Leaves those pixels of a mask of which keeps(Rest) is true.
/// @param named  optional: those that may show a mirror; else all may
template <class Keeps>
void keep(const FramePlan& plan, const scene::StaticScene& scene, const FrameHistory& history,
          const farfield::PixelMask* named, farfield::PixelMask& mask, Keeps&& keeps) {
    constexpr std::size_t kTilesPerTask = 64;
    parallel_ranges(mask.tiles.size(), kTilesPerTask, [&](std::size_t begin, std::size_t end) {
        RestTest rest(plan, scene, history);
        for (std::size_t t = begin; t < end; ++t) {
            farfield::TileMask& tile = mask.tiles[t];
            farfield::TileMask asked = tile;
            unsigned any = 0;
            for (int row = 0; row < kTileSize; ++row) {
                if (named != nullptr) asked.rows[row] &= named->tiles[t].rows[row];
                any |= asked.rows[row];
                if (!keeps(Rest::no_mirror)) tile.rows[row] = 0;
            }
            if (any == 0) continue;
            const int x = int(t % std::size_t(mask.tiles_x)) * kTileSize;
            const int y = int(t / std::size_t(mask.tiles_x)) * kTileSize;
            rest.begin_tile(x, y);
            if (keeps(Rest::no_mirror) && keeps(Rest::at_rest) && !rest.any_restless(x, y, asked)) continue;
            for (int row = 0; row < kTileSize; ++row) {
                if (asked.rows[row] == 0) continue;
                const Row kept = rest.kept(history.visibility.index(x, y + row), asked.rows[row], keeps);
                tile.rows[row] = std::uint16_t((tile.rows[row] & ~asked.rows[row]) | kept);
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
                               const farfield::PixelMask* named, farfield::PixelMask& mask) {
    keep(plan, scene, history, named, mask, [](Rest rest) { return rest != Rest::restless; });
}

void keep_resting_mirrors(const FramePlan& plan, const scene::StaticScene& scene, const FrameHistory& history,
                          farfield::PixelMask& mask) {
    keep(plan, scene, history, nullptr, mask, [](Rest rest) { return rest == Rest::at_rest; });
}

}  // namespace ff::frame
