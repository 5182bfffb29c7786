#include "engine/frame/restless_mirrors.h"

#include <bit>
#include <optional>

#include "engine/core/jobs.h"
#include "engine/effects/mirrored_motion.h"
#include "engine/frame/history.h"

namespace ff::frame {
namespace {

using farfield::kTileSize;

enum class Rest : std::uint8_t { no_mirror, at_rest, restless };

/// Asks about the pixels of one tile after the other.
class RestTest {
  public:
    RestTest(const FramePlan& plan, const scene::StaticScene& scene, const FrameHistory& history)
        : seen_(history.visibility),
          static_instances_(std::uint32_t(scene.instances.size())),
          within_m_(plan.reflections_within_m),
          waves_within_m_(plan.water_within_m),
          kind_of_(scene, plan.dynamic),
          motion_(scene, plan.view, history.mirrored),
          any_moves_(!history.mirrored.empty()) {}

    void begin_tile(int x, int y) {
        x_ = x;
        y_ = y;
        is_begun_ = false;
        instance_ = farfield::kSkyInstance;
        kind_ = effects::MirrorKind::none;
    }

    Rest operator()(std::size_t at) {
        const std::uint32_t instance = seen_.instance[at], triangle = seen_.triangle[at];
        if (instance != instance_ || triangle != triangle_) {
            instance_ = instance;
            triangle_ = triangle;
            kind_ = kind_of_(instance, triangle);
            rest_.reset();
        }
        if (kind_ == effects::MirrorKind::none) return Rest::no_mirror;
        const bool is_water = kind_ == effects::MirrorKind::water;
        const bool is_near = seen_.depth[at] < (is_water ? waves_within_m_ : within_m_);
        if (is_water && is_near) return Rest::restless;  // waves move
        if (!is_water && !is_near) return Rest::no_mirror;
        if (!rest_) rest_ = find(instance, triangle);
        return *rest_;
    }

    /// Whether none of a row's pixels can be a mirror: they show no instance that has any.
    bool skips(std::size_t first) {
        const std::uint32_t* const instance = seen_.instance.data() + first;
        unsigned other = 0;
        for (int i = 0; i < kTileSize; ++i)
            other |= unsigned(instance[i] != plain_) & unsigned(instance[i] != farfield::kSkyInstance);
        if (other == 0) return true;
        if (kind_of_.flags_of(instance[0]) == 0) plain_ = instance[0];
        return false;
    }

  private:
    Rest find(std::uint32_t instance, std::uint32_t triangle) {
        if (instance >= static_instances_) return Rest::restless;
        if (!any_moves_) return Rest::at_rest;
        if (!is_begun_) motion_.begin_tile(x_, y_);
        is_begun_ = true;
        return motion_.shows(instance, triangle) ? Rest::restless : Rest::at_rest;
    }

    const farfield::VisibilityBuffer& seen_;
    std::uint32_t static_instances_;
    float within_m_, waves_within_m_;
    effects::MirrorTest kind_of_;
    effects::MirroredMotion motion_;
    bool any_moves_;
    int x_ = 0, y_ = 0;
    bool is_begun_ = false;                         ///< few tiles have any mirror
    std::uint32_t plain_ = farfield::kSkyInstance;  ///< without mirrors
    // The last answer, as neighbours see the same: of a mirror whose depth leaves it a mirror.
    std::uint32_t instance_ = farfield::kSkyInstance, triangle_ = 0;
    effects::MirrorKind kind_ = effects::MirrorKind::none;
    std::optional<Rest> rest_;
};

/// Leaves those pixels of a mask of which keeps(Rest) is true.
template <class Keeps>
void keep(const FramePlan& plan, const scene::StaticScene& scene, const FrameHistory& history,
          farfield::PixelMask& mask, Keeps&& keeps) {
    constexpr std::size_t kTilesPerTask = 64;
    parallel_ranges(mask.tiles.size(), kTilesPerTask, [&](std::size_t begin, std::size_t end) {
        RestTest rest(plan, scene, history);
        for (std::size_t t = begin; t < end; ++t) {
            const int x = int(t % std::size_t(mask.tiles_x)) * kTileSize;
            const int y = int(t / std::size_t(mask.tiles_x)) * kTileSize;
            rest.begin_tile(x, y);
            for (int row = 0; row < kTileSize; ++row) {
                unsigned bits = mask.tiles[t].rows[row];
                const std::size_t first = history.visibility.index(x, y + row);
                if (bits == 0) continue;
                if (rest.skips(first)) {
                    if (!keeps(Rest::no_mirror)) mask.tiles[t].rows[row] = 0;
                    continue;
                }
                for (unsigned left = bits; left != 0; left &= left - 1)
                    if (!keeps(rest(first + std::size_t(std::countr_zero(left))))) bits &= ~(left & -left);
                mask.tiles[t].rows[row] = std::uint16_t(bits);
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
                               farfield::PixelMask& mask) {
    keep(plan, scene, history, mask, [](Rest rest) { return rest != Rest::restless; });
}

void keep_resting_mirrors(const FramePlan& plan, const scene::StaticScene& scene, const FrameHistory& history,
                          farfield::PixelMask& mask) {
    keep(plan, scene, history, mask, [](Rest rest) { return rest == Rest::at_rest; });
}

}  // namespace ff::frame
