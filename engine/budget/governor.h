#pragma once
// Chooses near distance, reuse and ray budget of the next frame from measured costs (P1 6.4.3 asks for it; P0 leaves
// them to the user). Pure arithmetic over its inputs: no clock, so recorded costs replay the same choices.

#include <array>
#include <cstdint>

#include "engine/budget/cost_model.h"

namespace ff::budget {

/// Near distances that are ever chosen, metres. Few, so that a choice can be held.
inline constexpr std::array<double, 7> kNearDistances{0.0, 25.0, 50.0, 100.0, 200.0, 400.0, 800.0};

/// What the coming frame looks like, as far as the last one tells.
struct Outlook {
    double pixels = 0;                                           ///< of the image
    double sky_pixels = 0;                                       ///< that the horizon is expected to answer
    std::array<double, kNearDistances.size()> near_triangles{};  ///< that OpenGL would draw up to each distance
    std::array<double, kNearDistances.size()> near_pixels{};     ///< that would be covered up to each distance
    double reusable_pixels = 0;                                  ///< whose panorama texel would still be good
    double horizon_azimuths = 0;
};

/// What gives where the budget does not suffice for a ray a pixel.
enum class WhenLate {
    coarser,  ///< all of the picture is drawn smaller and enlarged
    stale,    ///< P0 5.2: what is cast is cast at full size, the other pixels keep old texels of the panorama
};

/// Shares of the image's sides at which frames are drawn: quarter octaves, so that one can be held.
inline constexpr std::array<double, 9> kResolutions{1.0, 0.84, 0.71, 0.59, 0.5, 0.42, 0.35, 0.3, 0.25};

struct Choice {
    double near_m = 0.0;
    bool look_up_panorama = false;          ///< pays more than it costs
    std::uint64_t ray_budget = UINT64_MAX;  ///< casts allowed; UINT64_MAX: as many as are needed
    double resolution = 1.0;                ///< one of kResolutions; WhenLate::coarser
    double affordable_rays = 0.0;           ///< that fit into the budget, at most twice the image's pixels
    double needed_rays = 0.0;               ///< of the picture at full size
    double predicted_ms = 0.0;
};

/// Holds a choice until another is clearly better for a while: no oscillation. A change needs a predicted gain of
/// kSwitchGain in kPatience successive frames.
class Governor {
  public:
    static constexpr double kSwitchGain = 0.12;
    static constexpr int kPatience = 8;
    /// The ray budget moves at most by this factor a frame, and aims at this share of the time budget.
    static constexpr double kRayStep = 1.25;
    static constexpr double kAim = 0.92;
    /// Rays never fall below this share of the pixels, so that what is stale always heals.
    static constexpr double kMinRayShare = 0.005;
    /// A finer resolution must have this much room, for kPatience frames; a coarser one comes at once.
    static constexpr double kFinerRoom = 1.1;

    /// @param budget_ms  time the frame may take; 0: no limit
    [[nodiscard]] Choice choose(const Outlook& outlook, const CostModel& costs, double budget_ms,
                                WhenLate when_late = WhenLate::coarser);

  private:
    /// Holds or changes the resolution for so many rays where `needed` would be the whole picture.
    /// @param upscale_rays  that enlarging a smaller picture costs
    void choose_resolution(double rays, double upscale_rays, double needed);

    std::size_t near_index_ = 0;
    std::size_t resolution_index_ = 0;
    int finer_votes_ = 0;
    bool look_up_ = false;
    int near_votes_ = 0;
    int look_up_votes_ = 0;
    double ray_budget_ = -1.0;
};

/// Time of the near field and of what it leaves over, were the near distance kNearDistances[i]; ms.
[[nodiscard]] double predicted_near_and_cast_ms(const Outlook& outlook, const CostModel& costs, std::size_t i);

}  // namespace ff::budget
