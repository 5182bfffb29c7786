#pragma once
// The numbers of the game. Times are ticks of 1/120 s.

#include "engine/host/game.h"

namespace ff::beacons {

inline constexpr int kTicks = host::kTicksPerSecond;
inline constexpr double kTick = 1.0 / kTicks;  ///< seconds

/// Actions beside walking, in the order of GameInfo::actions: bits of UserCommand::buttons.
enum Button : int { kJump, kRun, kUse, kSpyglass };

inline constexpr std::uint32_t kDayTicks = 20 * 60 * kTicks;  ///< from the start to the last light
inline constexpr double kSunStart = radians_of(46.0), kSunEnd = radians_of(-2.0);
inline constexpr double kSunAzimuthStart = radians_of(205.0), kSunAzimuthEnd = radians_of(290.0);
/// The sun stands still for so long, then moves on a little: what its light costs is kept from frame to frame.
inline constexpr std::uint32_t kSunStepTicks = 4 * kTicks;

inline constexpr float kWalk = 2.2f, kRunning = 8.0f;  ///< metres a second
inline constexpr double kAbyss = 20.0;                 ///< metres below all of the world: out of it
inline constexpr double kEyeHeight = 1.65;             ///< metres above the feet
inline constexpr double kFov = radians_of(65.0), kSpyglassFov = radians_of(5.0);

inline constexpr double kKindleReach = 4.5;                    ///< metres
inline constexpr std::uint32_t kKindleTicks = 3 * kTicks / 2;  ///< of holding the torch to it
inline constexpr std::uint32_t kSpotTicks = kTicks;            ///< of looking at it through the spyglass
inline constexpr double kSpotAngle = radians_of(1.5);          ///< from the middle of the view
inline constexpr double kSpotRange = 20'000.0;                 ///< metres
inline constexpr double kBirdsWithin = 1'500.0;                ///< metres; see scenery::Flocks
inline constexpr double kGateReach = 5.0;                      ///< metres

}  // namespace ff::beacons
