#include "tools/accuracy/measure.h"

#include <algorithm>
#include <cmath>

#include "engine/core/log.h"
#include "engine/core/quantile.h"
#include "engine/frame/knobs.h"
#include "engine/shading/image_difference.h"
#include "tools/accuracy/flip.h"
#include "tools/accuracy/image_errors.h"

namespace ff::accuracy {
namespace {

/// What draws one setting's frames, lap after lap.
struct Trial {
    frame::FrameSettings settings;
    std::unique_ptr<frame::Renderer> renderer;
    std::vector<std::vector<double>> frame_ms;  ///< [counted frame][lap]
};

Trial make_trial(const Bench& bench, const frame::FrameSettings& settings) {
    const auto counted =
        std::count_if(bench.frames.begin(), bench.frames.end(), [](const ScheduledFrame& f) { return f.counted; });
    return {settings, bench.scene.make_renderer(bench.scene.width, bench.scene.height),
            std::vector<std::vector<double>>(std::size_t(counted))};
}

/// Times of the frames, each the median of its laps.
std::vector<double> frame_times(const Trial& trial) {
    std::vector<double> times;
    for (const auto& laps : trial.frame_ms) times.push_back(median_of(laps));
    return times;
}

/// Draws one segment of the schedule: the frames from `first` up to the next segment's.
/// @return where that begins
std::size_t time_segment(const Bench& bench, std::size_t first, Trial& trial, shading::Image& image) {
    std::size_t counted = 0;
    for (std::size_t i = 0; i < first; ++i) counted += bench.frames[i].counted;
    std::size_t i = first;
    do {
        const ScheduledFrame& f = bench.frames[i];
        const auto& stats = trial.renderer->draw(bench.scene.walk.camera(f.walk_frame),
                                                 bench.scene.dynamic(f.walk_frame), trial.settings, image);
        if (f.counted) trial.frame_ms[counted++].push_back(stats.frame_ms);
    } while (++i < bench.frames.size() && !bench.frames[i].first);
    return i;
}

/// A lap of all trials, segment by segment, so that all meet the same bursts of other processes; nobody is always
/// first.
void time_lap(const Bench& bench, std::size_t lap, std::vector<Trial>& trials) {
    shading::Image image;
    for (Trial& trial : trials) trial.renderer->reset();
    for (std::size_t first = 0, next = 0, turn = lap; first < bench.frames.size(); first = next, ++turn)
        for (std::size_t i = 0; i < trials.size(); ++i)
            next = time_segment(bench, first, trials[(i + turn) % trials.size()], image);
}

/// What a smaller visibility buffer says about each pixel of a larger image.
void enlarge(const farfield::VisibilityBuffer& from, int width, int height, farfield::VisibilityBuffer& to) {
    to.resize(width, height);
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            const std::size_t source =
                from.index((2 * x + 1) * from.width / (2 * width), (2 * y + 1) * from.height / (2 * height));
            const std::size_t target = to.index(x, y);
            to.instance[target] = from.instance[source];
            to.triangle[target] = from.triangle[source];
            to.depth[target] = from.depth[source];
        }
}

/// Draws a lap that is not timed and holds every counted frame against its truth.
class ErrorLap {
  public:
    explicit ErrorLap(const Bench& bench) : bench_(bench) {}

    void run(Trial& trial, Point& point) {
        frame::FrameSettings settings = trial.settings;
        settings.keep_ids = true;
        trial.renderer->reset();
        Errors sum{.psnr_exact_db_min = 99.0};
        double frames = 0.0, changes = 0.0;
        for (std::size_t i = 0; i < bench_.frames.size(); ++i) {
            std::swap(image_, before_);
            const Camera camera = bench_.scene.walk.camera(bench_.frames[i].walk_frame);
            trial.renderer->draw(camera, bench_.scene.dynamic(bench_.frames[i].walk_frame), settings, image_);
            if (!bench_.frames[i].counted) continue;
            const ReferenceFrame& truth = bench_.reference[i];
            add(i, truth, trial, sum, point.worst);
            if (!bench_.frames[i].first) {
                sum.flicker += flicker(before_, image_, bench_.reference[i - 1].image, truth.image);
                changes += 1.0;
            }
            frames += 1.0;
        }
        sum.psnr_db /= frames;
        sum.ssim /= frames;
        sum.flip_mean /= frames;
        sum.wrong_pixels_pct /= frames;
        sum.flicker /= std::max(1.0, changes);
        point.errors = sum;
    }

  private:
    void add(std::size_t i, const ReferenceFrame& truth, const Trial& trial, Errors& sum, WorstFrame& worst) {
        constexpr int kWrongLevels = 16;
        sum.psnr_db += shading::compare_images(image_, truth.image, kWrongLevels).psnr_db;
        const double exact = shading::compare_images(image_, truth.exact, kWrongLevels).psnr_db;
        sum.psnr_exact_db_min = std::min(sum.psnr_exact_db_min, exact);
        sum.ssim += structural_similarity(image_, truth.image);
        const double flip = flip_.compare(truth.image, image_);
        sum.flip_mean += flip;
        if (flip > worst.flip) worst = {i, flip, image_, flip_.map()};

        const farfield::VisibilityBuffer* visible = &trial.renderer->history().visibility;
        if (visible->width != truth.visible.width || visible->height != truth.visible.height) {
            enlarge(*visible, truth.visible.width, truth.visible.height, enlarged_);
            visible = &enlarged_;
        }
        const VisibilityError error = compare_visibility(*visible, truth.visible);
        sum.wrong_pixels_pct += 100.0 * error.wrong_primitives;
        sum.displacement_px = std::max(sum.displacement_px, error.displacement_px);
    }

    const Bench& bench_;
    Flip flip_;
    shading::Image image_, before_;
    farfield::VisibilityBuffer enlarged_;
};

}  // namespace

Result<std::vector<Point>> measure(const Bench& bench, std::span<const KnobSettings> settings,
                                   const std::string& title) {
    std::vector<Trial> trials;
    trials.push_back(make_trial(bench, bench.exact));
    for (const KnobSettings& knobs : settings) {
        frame::FrameSettings turned = bench.exact;
        for (const auto& [name, value] : knobs) FF_TRY(frame::set_knob(turned, name, value));
        trials.push_back(make_trial(bench, turned));
    }
    Progress progress(title, trials.size() * std::size_t(bench.laps) + settings.size());
    for (int lap = 0; lap < bench.laps; ++lap) {
        time_lap(bench, std::size_t(lap), trials);
        progress.advance(trials.size());
    }

    std::vector<Point> points(settings.size());
    ErrorLap error_lap(bench);
    const double exact_median = median_of(frame_times(trials[0]));
    for (std::size_t i = 0; i < settings.size(); ++i) {
        Point& point = points[i];
        const std::vector<double> times = frame_times(trials[i + 1]);
        point.settings = settings[i];
        point.is_exact = trials[i + 1].settings == bench.exact;
        point.times = {
            .median_ms = median_of(times), .p99_ms = quantile_of(times, 0.99), .exact_median_ms = exact_median};
        error_lap.run(trials[i + 1], point);
        progress.advance();
    }
    return points;
}

}  // namespace ff::accuracy
