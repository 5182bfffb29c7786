#include "engine/host/random_player.h"

#include <algorithm>
#include <cmath>

#include "engine/math/types.h"

namespace ff::host {
namespace {

/// SplitMix64 (Steele, Lea and Flood 2014): the same numbers everywhere, which std's distributions do not promise.
class Random {
  public:
    explicit Random(std::uint64_t seed) : state_(seed) {}
    std::uint64_t next() {
        std::uint64_t z = (state_ += 0x9E3779B97F4A7C15ull);
        z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9ull;
        z = (z ^ (z >> 27)) * 0x94D049BB133111EBull;
        return z ^ (z >> 31);
    }
    std::uint64_t below(std::uint64_t end) { return next() % end; }
    /// [-1, 1)
    double both() { return double(std::int64_t(next() >> 11)) * 0x1p-52 - 1.0; }

  private:
    std::uint64_t state_;
};

class RandomPlayer final : public AutoPlayer {
  public:
    RandomPlayer(const GameInfo& info, std::uint64_t seed)
        : buttons_(int(info.actions.size()) - loop::kWalkActions), random_(seed) {}

    loop::UserCommand next() override {
        if (left_ == 0) change_mind();
        --left_;
        yaw_ = std::remainder(yaw_ + turn_ / kTicksPerSecond, 2.0 * kPi);
        pitch_ = std::clamp(pitch_ + tilt_ / kTicksPerSecond, -0.5 * kPi, 0.5 * kPi);
        command_.yaw_urad = std::int32_t(std::lround(yaw_ * 1e6));
        command_.pitch_urad = std::int32_t(std::lround(pitch_ * 1e6));
        return command_;
    }

  private:
    void change_mind() {
        left_ = 10 + int(random_.below(3 * kTicksPerSecond));
        command_.move_ahead = std::int8_t(std::lround(127.0 * std::clamp(random_.both() + 0.6, -1.0, 1.0)));
        command_.move_right = std::int8_t(random_.below(3) == 0 ? std::lround(127.0 * random_.both()) : 0);
        turn_ = random_.below(12) == 0 ? 20.0 * random_.both() : 1.2 * random_.both();  // at times a sharp turn
        tilt_ = 0.6 * random_.both() - 0.3 * pitch_;
        command_.buttons = 0;
        for (int b = 0; b < buttons_; ++b)
            if (random_.below(5) == 0) command_.buttons = std::uint16_t(command_.buttons | (1u << b));
    }

    int buttons_;
    Random random_;
    loop::UserCommand command_;
    double yaw_ = 0.0, pitch_ = 0.0, turn_ = 0.0, tilt_ = 0.0;
    int left_ = 0;
};

}  // namespace

std::unique_ptr<AutoPlayer> make_random_player(const GameInfo& info, std::uint64_t seed) {
    return std::make_unique<RandomPlayer>(info, seed);
}

}  // namespace ff::host
