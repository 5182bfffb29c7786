#include "tools/accuracy/sweep.h"

#include <fmt/format.h>

#include <algorithm>

#include "engine/effects/wind.h"

namespace ff::accuracy {
namespace {

/// A time below that of exact frames by less is noise.
constexpr double kWorthwhileRatio = 0.97;
/// An error larger by less cannot be seen.
constexpr double kNoticeableFlip = 1e-4;

/// Of a point with one knob turned: null for a name that the table does not have.
const frame::Knob* knob_of(const Point& point) {
    const auto knobs = frame::knobs();
    const auto found = std::find_if(knobs.begin(), knobs.end(),
                                    [&](const frame::Knob& k) { return k.name == point.settings.front().first; });
    return found != knobs.end() ? &*found : nullptr;
}

frame::KnobScope scope_of(const Point& point) {
    const frame::Knob* const knob = knob_of(point);
    return knob != nullptr ? knob->scope : frame::KnobScope::all;
}

/// Whether a technique of its own is switched on, which other settings than the knobs of its scope leave as it is.
bool is_technique(frame::KnobScope scope) {
    return scope == frame::KnobScope::panorama || scope == frame::KnobScope::reprojection;
}

bool are_compatible(const Point& a, const Point& b) {
    using enum frame::KnobScope;
    if (a.settings.front().first == b.settings.front().first) return false;
    // Mode reproject takes no notice of what belongs to mode hybrid.
    const frame::KnobScope one = scope_of(a), other = scope_of(b);
    return (one == reprojection) == (other == reprojection) || one == all || other == all;
}

/// What two points have in common, and exact frames have not: the technique that both knobs need, with all of its knobs
/// at their defaults. Null where that was not measured.
const Point* common_ground(const Point& a, const Point& b, std::span<const Point* const> singles, const Point& exact) {
    const frame::KnobScope scope = scope_of(a);
    if (scope != scope_of(b) || !is_technique(scope)) return &exact;
    for (const Point* point : singles) {
        const frame::Knob* const knob = knob_of(*point);
        if (knob != nullptr && knob->scope == scope && point->settings.front().second == knob->default_value)
            return point;
    }
    return nullptr;
}

}  // namespace

std::vector<const Point*> pareto_front(std::span<const Point* const> points) {
    std::vector<const Point*> sorted(points.begin(), points.end());
    std::stable_sort(sorted.begin(), sorted.end(), [](const Point* a, const Point* b) {
        return a->time_ratio() != b->time_ratio() ? a->time_ratio() < b->time_ratio()
                                                  : a->errors.flip_mean < b->errors.flip_mean;
    });
    constexpr double kClearlyLess = 0.99;
    std::vector<const Point*> front;
    for (const Point* point : sorted)
        if (front.empty() || point->errors.flip_mean < kClearlyLess * front.back()->errors.flip_mean)
            front.push_back(point);
    return front;
}

std::vector<KnobSettings> promising_pairs(std::span<const Point* const> singles, const Point& exact,
                                          std::size_t count) {
    std::vector<Point> guesses;
    for (std::size_t i = 0; i < singles.size(); ++i)
        for (std::size_t j = i + 1; j < singles.size(); ++j) {
            const Point &a = *singles[i], &b = *singles[j];
            if (a.time_ratio() > kWorthwhileRatio || b.time_ratio() > kWorthwhileRatio || !are_compatible(a, b))
                continue;
            const Point* const ground = common_ground(a, b, singles, exact);
            if (ground == nullptr) continue;
            Point guess;
            guess.settings = a.settings;
            guess.settings.insert(guess.settings.end(), b.settings.begin(), b.settings.end());
            guess.times = {.median_ms = a.time_ratio() * b.time_ratio() / ground->time_ratio(), .exact_median_ms = 1.0};
            guess.errors.flip_mean = a.errors.flip_mean + b.errors.flip_mean - ground->errors.flip_mean;
            guesses.push_back(std::move(guess));
        }
    // The front first; then the front of the rest, until there are enough.
    std::vector<const Point*> left;
    for (const Point& guess : guesses) left.push_back(&guess);
    std::vector<KnobSettings> chosen;
    while (chosen.size() < count && !left.empty()) {
        const std::vector<const Point*> front = pareto_front(left);
        // Evenly over the front where it holds more than are wanted.
        const std::size_t wanted = std::min(count - chosen.size(), front.size());
        for (std::size_t i = 0; i < wanted; ++i)
            chosen.push_back(front[wanted > 1 ? i * (front.size() - 1) / (wanted - 1) : 0]->settings);
        std::erase_if(left, [&](const Point* p) { return std::find(front.begin(), front.end(), p) != front.end(); });
    }
    return chosen;
}

std::string say(const frame::Knob& knob, std::span<const Point> points) {
    const auto value_of = [&](const Point& p) { return p.settings.front().second; };
    const auto usual =
        std::find_if(points.begin(), points.end(), [&](const Point& p) { return value_of(p) == knob.default_value; });
    if (usual == points.end() || points.size() < 2) return fmt::format("Only one value of {} was measured.", knob.name);
    // The value that saves the most time a FLIP, and where none saves any, the one that costs least.
    const Point* best = nullptr;
    double best_gain = 0.0;
    for (const Point& p : points) {
        if (&p == &*usual || p.time_ratio() > kWorthwhileRatio * usual->time_ratio()) continue;
        const double cost = std::max(p.errors.flip_mean - usual->errors.flip_mean, 1e-5);
        const double gain = (usual->time_ratio() - p.time_ratio()) / cost;
        if (best == nullptr || gain > best_gain) {
            best = &p;
            best_gain = gain;
        }
    }
    const std::string from = knob.text(knob.default_value);
    if (best == nullptr)
        return fmt::format("No other value is faster than {} here: leave {} as it is.", from, knob.name);
    const double saved_ms = (usual->time_ratio() - best->time_ratio()) * usual->times.exact_median_ms;
    const double flip = best->errors.flip_mean - usual->errors.flip_mean;
    const std::string saves = fmt::format("{} instead of {} saves {:.2f} ms of {:.1f}", knob.text(value_of(*best)),
                                          from, saved_ms, usual->times.median_ms);
    const std::string worst = fmt::format("the worst frame has {:.1f} dB instead of {:.1f} against exact ones",
                                          best->errors.psnr_exact_db_min, usual->errors.psnr_exact_db_min);
    if (flip <= kNoticeableFlip) return fmt::format("{} and costs no FLIP; {}.", saves, worst);
    return fmt::format("{}: each millisecond costs {:.4f} FLIP; {}.", saves, flip / saved_ms, worst);
}

Result<Sweep> sweep(const Bench& bench, int pairs) {
    Sweep result;
    result.schedule_frames = bench.frames.size();
    for (const ScheduledFrame& f : bench.frames) result.counted_frames += f.counted;
    {
        const KnobSettings nothing_turned[1];
        FF_ASSIGN(std::vector<Point> exact, measure(bench, nothing_turned, "exact frames"));
        result.exact = std::move(exact.front());
    }
    for (const frame::Knob& knob : frame::knobs()) {
        if (knob.needs_gl && !bench.scene.has_gl) continue;
        const scene::StaticScene& scene = bench.scene.world.scene();
        if (knob.needs_sun && !scene.environment.sun_shadows) continue;
        if (knob.needs_lamps && scene.lamps.empty()) continue;
        if (knob.needs_mirrors && std::none_of(scene.materials.begin(), scene.materials.end(), scene::is_mirror))
            continue;
        if (knob.needs_air && !(scene.environment.atmosphere.turbidity > 0.0f) &&
            !(scene.environment.fog_density_per_m > 0.0f))
            continue;
        if (knob.needs_water && std::none_of(scene.materials.begin(), scene.materials.end(), [](const auto& material) {
                return (material.flags & scene::kMaterialWater) != 0;
            }))
            continue;
        const scene::Weather& weather = scene.environment.weather;
        if (knob.needs_wind && !(effects::has_foliage(scene) && weather.wind_m_s != Vec2(0.0f))) continue;
        if (knob.needs_weather && !(weather.rain > 0.0f || weather.snow > 0.0f)) continue;
        std::vector<KnobSettings> settings;
        for (const frame::KnobValue& v : knob.values) settings.push_back({{std::string(knob.name), v.value}});
        KnobCurve curve{.knob = &knob};
        FF_ASSIGN(curve.points, measure(bench, settings, std::string(knob.name)));
        curve.says = say(knob, curve.points);
        result.curves.push_back(std::move(curve));
    }
    std::vector<const Point*> all{&result.exact};
    for (const KnobCurve& curve : result.curves)
        for (const Point& point : curve.points)
            if (!point.is_exact) all.push_back(&point);
    const auto promising = promising_pairs(std::span(all).subspan(1), result.exact, std::size_t(pairs));
    if (!promising.empty()) {
        FF_ASSIGN(result.pairs, measure(bench, promising, "pairs of knobs"));
        for (const Point& point : result.pairs) all.push_back(&point);
    }
    for (const Point* point : pareto_front(all)) result.pareto.push_back(*point);
    return result;
}

}  // namespace ff::accuracy
