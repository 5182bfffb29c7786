#include "tools/cook/walks_frames.h"

#include <algorithm>
#include <cmath>

namespace ff::cook {
namespace {

constexpr double kRate_hz = 30.0;
constexpr double kMostTurn_deg = 2.5;  // a frame: eyes turn faster, heads that walk do not

// A Gaussian by weights; the ends are held.
std::vector<double> blurred(const std::vector<double>& values, double sigma) {
    const int reach = static_cast<int>(std::ceil(3.0 * sigma)), count = static_cast<int>(values.size());
    std::vector<double> weights(std::size_t(reach) + 1), out(values.size());
    for (int i = 0; i <= reach; ++i) weights[std::size_t(i)] = std::exp(-0.5 * (i / sigma) * (i / sigma));
    for (int i = 0; i < count; ++i) {
        double sum = 0, total = 0;
        for (int j = -reach; j <= reach; ++j) {
            const double w = weights[std::size_t(std::abs(j))];
            sum += w * values[std::size_t(std::clamp(i + j, 0, count - 1))];
            total += w;
        }
        out[std::size_t(i)] = sum / total;
    }
    return out;
}

double largest_step(const std::vector<double>& values) {
    double step = 0;
    for (std::size_t i = 1; i < values.size(); ++i) step = std::max(step, std::abs(values[i] - values[i - 1]));
    return step;
}

}  // namespace

void smooth_angles(std::vector<double>& angles_deg, double most_deg) {
    for (std::size_t i = 1; i < angles_deg.size(); ++i)
        angles_deg[i] = angles_deg[i - 1] + std::remainder(angles_deg[i] - angles_deg[i - 1], 360.0);
    const std::vector<double> given = angles_deg;
    for (double sigma = 6.0; sigma < 400.0; sigma *= 1.4) {
        angles_deg = blurred(given, sigma);
        if (largest_step(angles_deg) <= most_deg) return;
    }
}

std::vector<WalkFrame> walk_along(const WalkRoute& route, double start_m, double speed_m_s, double look_m, int frames) {
    const double length = route.length_m();
    const auto count = static_cast<std::size_t>(frames);
    std::vector<double> along(count), sense(count, 1.0);
    bool turns_back = false;
    for (std::size_t f = 0; f < count; ++f) {
        const double way = start_m + double(f) * speed_m_s / kRate_hz;
        const double lap = std::fmod(way, 2.0 * length);
        along[f] = lap <= length ? lap : 2.0 * length - lap;
        sense[f] = lap <= length ? 1.0 : -1.0;
        turns_back = turns_back || way > length;
    }
    if (turns_back) along = blurred(along, 8.0);  // slows down before it turns
    std::vector<double> yaw(count), pitch(count);
    std::vector<WalkFrame> out(count);
    for (std::size_t f = 0; f < count; ++f) {
        out[f].position = route.at(along[f]) + DVec3(0.0, kEyeHeight_m, 0.0);
        // Near the end of the route the last piece tells the direction.
        const double from = sense[f] > 0 ? std::min(along[f], length - look_m) : std::max(along[f], look_m);
        const DVec3 a = route.at(from), b = route.at(from + sense[f] * look_m);
        yaw[f] = degrees_of(std::atan2(b.x - a.x, a.z - b.z));
        pitch[f] = 0.5 * degrees_of(std::atan2(b.y - a.y, std::max(0.1, std::hypot(b.x - a.x, b.z - a.z))));
    }
    smooth_angles(yaw, kMostTurn_deg);
    smooth_angles(pitch, 1.0);
    for (std::size_t f = 0; f < count; ++f) out[f].yaw_deg = yaw[f], out[f].pitch_deg = pitch[f];
    return out;
}

void look_at(std::vector<WalkFrame>& frames, const DVec3& target) {
    for (WalkFrame& frame : frames) {
        const DVec3 d = target - frame.position;
        frame.yaw_deg = degrees_of(std::atan2(d.x, -d.z));
        frame.pitch_deg = degrees_of(std::atan2(d.y, std::hypot(d.x, d.z)));
    }
}

void round_frames(std::vector<WalkFrame>& frames) {
    const auto whole = [](double v) { return std::round(v * 1e6) / 1e6 + 0.0; };
    for (WalkFrame& frame : frames) {
        for (int axis = 0; axis < 3; ++axis) frame.position[axis] = whole(frame.position[axis]);
        frame.yaw_deg = whole(frame.yaw_deg - 360.0 * std::floor(frame.yaw_deg / 360.0));
        if (frame.yaw_deg >= 360.0) frame.yaw_deg = 0.0;
        frame.pitch_deg = whole(std::clamp(frame.pitch_deg, -90.0, 90.0));
        frame.roll_deg = whole(frame.roll_deg);
    }
}

}  // namespace ff::cook
