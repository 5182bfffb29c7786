#include "engine/shading/waves.h"

#include <algorithm>
#include <cmath>

namespace ff::shading {

Waves make_waves(const WorldPos& eye, const scene::Weather& weather, double time_s) {
    struct Train {
        double length_m, turn, slope;
    };
    // Turns and lengths that never line up; long waves carry most of the slope.
    constexpr Train kTrains[] = {
        {11.3, 0.0, 0.030}, {6.1, 0.65, 0.030}, {3.37, -0.55, 0.028}, {1.93, 1.15, 0.024}, {1.07, -1.25, 0.020}};
    constexpr double kGravity = 9.81;
    const double wind_x = weather.wind_m_s.x, wind_z = weather.wind_m_s.y, speed = std::hypot(wind_x, wind_z);
    const double heading = speed > 0.1 ? std::atan2(wind_z, wind_x) : 0.4;
    // A breeze of 4 m/s is usual; still air leaves a swell.
    const double strength = std::clamp(0.4 + 0.15 * speed, 0.4, 3.0);
    Waves waves;
    for (std::size_t i = 0; i < waves.size(); ++i) {
        const Train& train = kTrains[i];
        const double number = 2.0 * kPi / train.length_m, angle = heading + train.turn;
        const double x = number * std::cos(angle), z = number * std::sin(angle);
        const double phase = x * eye.x + z * eye.z - std::sqrt(kGravity * number) * time_s;
        waves[i] = {float(x), float(z), float(strength * train.slope), float(std::remainder(phase, 2.0 * kPi)),
                    float(train.length_m)};
    }
    return waves;
}

}  // namespace ff::shading
