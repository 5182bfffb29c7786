// The reprojection (P3) where its geometry degenerates: no motion, none to be measured, no epipole, one at infinity, or
// one exactly on a pixel's centre, corner, row, column or the image's border; half turns, teleports, points behind the
// eye and beside it, and pixels that showed something that moves.

#include "engine/farfield/reproject.h"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <limits>

#include "engine/farfield/reproject_reference.h"
#include "tests/hardcases/cases.h"
#include "tests/support/worlds.h"

namespace ff::hardcases {
namespace {

using farfield::PixelCause;
using farfield::VisibilityBuffer;

constexpr int kWidth = 152, kHeight = 120;  // no whole number of tiles

/// Two views of a street, one after the other.
struct Step {
    PinholeView last, now;
    std::string name;
};

/// Where the epipole lies: on the plane of the image, in pixels.
struct Epipole {
    double x, y;
    const char* name;
};

Epipole random_epipole(test::Random& random) {
    const double x = random.below(kWidth), y = random.below(kHeight);
    const Epipole places[] = {
        {x + 0.5, y + 0.5, "on a pixel's centre"},
        {x, y, "on a pixel's corner"},
        {x + random.unit(), y + 0.5, "on a row"},
        {x + 0.5, y + random.unit(), "on a column"},
        {random.below(2) == 0 ? 0.0 : double(kWidth), y + random.unit(), "on the left or right border"},
        {x + random.unit(), random.below(2) == 0 ? 0.0 : double(kHeight), "on the upper or lower border"},
        {0.5 * kWidth, 0.5 * kHeight, "in the middle"},
        {1e6, y, "far beside the image"}};
    return places[random.below(std::size(places))];
}

Step random_step(test::Random& random) {
    constexpr std::array<double, 9> kLengths{0.0, 1e-9, 1e-6, 1e-3, 0.05, 0.3, -0.05, -1e-9, 60.0};
    constexpr std::array<double, 8> kTurns{0.0, 0.0, 1e-12, 0.02, 0.5 * kPi, -0.5 * kPi, kPi, -1e-6};
    Camera camera{.position = {random.in(2.0, 60.0), random.in(1.0, 12.0), random.in(2.0, 60.0)},
                  .yaw = random.in(-kPi, kPi),
                  .pitch = random.in(-0.3, 0.3),
                  .roll = random.below(2) == 0 ? 0.0 : random.in(-kPi, kPi)};
    const Epipole epipole = random_epipole(random);
    const double length = kLengths[random.below(kLengths.size())];
    Step step;
    step.last = make_view(camera, kWidth, kHeight);
    const DVec3 towards(double(step.last.u_first) + epipole.x * double(step.last.u_step),
                        double(step.last.v_first) + epipole.y * double(step.last.v_step), -1.0);
    camera.position += length / glm::length(towards) * (world_from_camera(camera) * towards);
    const double turn = kTurns[random.below(kTurns.size())];
    camera.yaw += turn;
    step.now = make_view(camera, kWidth, kHeight);
    step.name = fmt::format("a step of {} m, epipole {}, turned by {}", length, epipole.name, turn);
    return step;
}

Step ordinary_step(test::Random& random) {
    Camera camera{.position = {random.in(2.0, 60.0), random.in(1.0, 12.0), random.in(2.0, 60.0)},
                  .yaw = random.in(-kPi, kPi)};
    Step step;
    step.last = make_view(camera, kWidth, kHeight);
    camera.position += world_from_camera(camera) * DVec3(0.003, 0.002, -0.05);
    step.now = make_view(camera, kWidth, kHeight);
    return step;
}

/// A street, and what reprojects it.
class Street {
  public:
    Street()
        : data_(test::make_city({.cells = 2, .subdivisions = 2})),
          scene_(data_.view()),
          caster_(make_caster(Subject::beam, scene_)),
          reprojection_(scene_) {
        last_.resize(kWidth, kHeight);
        out_.resize(kWidth, kHeight);
    }

    /// Casts the last frame; a few of its pixels show things that move, whose primitives are nobody's now.
    void look(const Step& step, test::Random& random) {
        caster_->cast_tiles(step.last, all_tiles(step.last), last_);
        for (int i = 0; i < 200; ++i) {
            const std::size_t at = last_.index(int(random.below(kWidth)), int(random.below(kHeight)));
            last_.instance[at] = std::uint32_t(scene_.instances.size()) + random.below(3);
            last_.triangle[at] = random.below(1000);
            last_.depth[at] = float(random.in(0.5, 30.0));
        }
    }

    /// @return whether anything could be reprojected
    bool reproject(const Step& step, const farfield::ReprojectSettings& settings) {
        if (!reprojection_.reproject(step.last, last_, step.now, settings)) return false;
        out_ = last_;
        reprojection_.verify(step.now, settings, 5, out_, left_);
        return true;
    }

    /// Each pixel is answered by what its own ray meets, or asked for; never both, never neither.
    void count(const Step& step, Trial& trial) {
        farfield::PixelMask asked;
        asked.reset(kWidth, kHeight);
        for (const farfield::TileRequest& tile : left_)
            for (int j = 0; j < farfield::kTileSize; ++j)
                for (int i = 0; i < farfield::kTileSize; ++i)
                    if (((tile.rows[j] >> i) & 1) != 0) asked.set(tile.x + i, tile.y + j);
        for (int y = 0; y < kHeight; ++y)
            for (int x = 0; x < kWidth; ++x) {
                double error = 0.0;
                const bool is_right = is_right_pixel(step, asked, x, y, error);
                trial.count(is_right, error, [&] { return fmt::format("{}: pixel {}, {}", step.name, x, y); });
            }
    }

  private:
    [[nodiscard]] bool is_right_pixel(const Step& step, const farfield::PixelMask& asked, int x, int y,
                                      double& error) const {
        constexpr double kSlack = 1e-3;  // a ray may pass just beside an edge, by rounding
        const std::size_t at = out_.index(x, y);
        const PixelCause cause = reprojection_.causes().at(x, y);
        const bool is_answered = cause == PixelCause::verified || cause == PixelCause::background;
        if (is_answered == asked.test(x, y)) return false;
        if (cause == PixelCause::background) return out_.instance[at] == farfield::kSkyInstance;
        if (cause != PixelCause::verified) return true;
        if (out_.instance[at] >= scene_.instances.size()) return false;  // what moves is nowhere any more
        const double depth =
            farfield::intersect_primitive(scene_, step.now, x, y, out_.instance[at], out_.triangle[at], kSlack);
        error = std::fabs(double(out_.depth[at]) / depth - 1.0);
        return error <= kSlack;
    }

    scene::SceneData data_;
    scene::StaticScene scene_;
    std::unique_ptr<farfield::RayCaster> caster_;
    farfield::Reprojection reprojection_;
    VisibilityBuffer last_, out_;
    std::vector<farfield::TileRequest> left_;
};

}  // namespace

void reprojected_motions(Trial& trial) {
    Street street;
    while (!trial.done()) {
        test::Random random(trial.next_seed());
        farfield::ReprojectSettings settings;
        // With its checks and without: both must be sound, wherever the epipole lies.
        settings.check_view_frustum = false;
        settings.check_occlusion = random.below(4) != 0;
        settings.check_abrupt = random.below(4) != 0;
        const Step easy = ordinary_step(random), hard = random_step(random);
        street.look(easy, random);
        trial.time_easy([&] { street.reproject(easy, settings); });
        street.look(hard, random);
        bool has_landed = false;
        trial.time_hard([&] { has_landed = street.reproject(hard, settings); });
        if (has_landed) street.count(hard, trial);
        trial.report();
    }
}

}  // namespace ff::hardcases
