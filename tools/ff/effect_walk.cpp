#include "tools/ff/effect_walk.h"

#include <algorithm>
#include <limits>
#include <memory>
#include <optional>

#include "engine/core/log.h"
#include "engine/core/quantile.h"
#include "engine/shading/image_difference.h"
#include "tools/ff/walk_lap.h"

namespace ff::tool {

Result<EffectWalk> walk_effects(Session& session, const ImageSize& size, std::size_t frames) {
    const auto renderer = session.make_renderer(size);
    shading::Image image;
    EffectWalk walk;
    effects::Decisions before;
    std::vector<double> all_ms, change_ms;
    int since_change = 3;
    Progress progress("walking", frames);
    const Status drawn = draw_lap(session, *renderer, session.settings(), size, frames, image, [&](const LapFrame& f) {
        const frame::FrameStats& stats = f.stats;
        for (const effects::Effect& effect : effects::registry()) {
            EffectSum& sum = walk.of[std::size_t(effect.id)];
            const effects::Decision& decision = stats.effects[effect.id];
            if (f.frame == 0 || decision.state > sum.decision.state) sum.decision = decision;
            const effects::Work& work = stats.work(effect.id);
            if (decision.state == effects::State::active &&
                sum.frames_in[std::size_t(effects::State::active)] >= kWarmUpFrames)
                sum.steady_allocations += work.allocations;
            ++sum.frames_in[std::size_t(decision.state)];
            sum.work.ms += work.ms;
            sum.work.allocations += work.allocations;
            sum.work.rays += work.rays;
            sum.work.systems = std::max(sum.work.systems, work.systems);
        }
        ++walk.frames;
        progress.advance();
        const auto same_states = [&] {
            for (std::size_t e = 0; e < effects::kEffectCount; ++e)
                if (before.of[e].state != stats.effects.of[e].state) return false;
            return true;
        };
        const bool changes = f.frame > 0 && !same_states();
        before = stats.effects;
        if (f.frame == 0) return;
        walk.changes += changes;
        since_change = changes ? 0 : since_change + 1;
        all_ms.push_back(stats.frame_ms);
        if (since_change < 3) change_ms.push_back(stats.frame_ms);
        if (!changes && f.frame >= kWarmUpFrames)
            walk.most_allocations = std::max(walk.most_allocations, f.allocations);
    });
    if (!drawn) return drawn.error();
    if (!all_ms.empty()) {
        walk.max_ms = *std::max_element(all_ms.begin(), all_ms.end());
        walk.p99_ms = quantile_of(all_ms, 0.99);
        walk.median_ms = median_of(all_ms);
    }
    if (!change_ms.empty()) walk.change_p99_ms = quantile_of(change_ms, 0.99);
    return walk;
}

namespace {

/// One way of drawing the frames of a comparison.
struct Run {
    effects::EffectSet without = 0;
    std::optional<scene::Weather> weather;
    std::unique_ptr<frame::Renderer> renderer;
    std::vector<double> ms;  // [frame], the least of all laps
    std::array<effects::Work, effects::kEffectCount> work{};
    shading::Image image;
};

/// The weather of frames that an effect is put into; none where it cannot be.
std::optional<scene::Weather> weather_of(effects::EffectId id, scene::Weather weather) {
    constexpr float kStrength = 0.6f;
    if (id == effects::EffectId::rain) weather.rain = kStrength;
    if (id == effects::EffectId::snow) weather.snow = kStrength;
    return id == effects::EffectId::rain || id == effects::EffectId::snow ? std::optional(weather) : std::nullopt;
}

}  // namespace

std::vector<EffectDifference> compare_effects(Session& session, const ImageSize& size, std::size_t frames, int laps,
                                              const EffectWalk& walk, bool any_weather) {
    // Run 0 is the walk as it is. A difference is that of two runs.
    std::vector<Run> runs;
    const auto add_run = [&](effects::EffectSet without, const std::optional<scene::Weather>& weather) {
        runs.push_back({.without = without, .weather = weather, .renderer = session.make_renderer(size)});
        runs.back().ms.assign(frames, std::numeric_limits<double>::infinity());
        return runs.size() - 1;
    };
    add_run(0, std::nullopt);
    struct Pair {
        std::size_t with, without;
    };
    std::vector<Pair> pairs;
    std::vector<EffectDifference> differences;
    const auto add_difference = [&](effects::EffectId id, bool is_called, const Pair& pair) {
        pairs.push_back(pair);
        EffectDifference difference;
        difference.id = id;
        difference.is_called = is_called;
        differences.push_back(std::move(difference));
    };
    const scene::Environment& air = session.world().scene().environment;
    for (const effects::Effect& effect : effects::registry()) {
        const bool is_called = walk.of[std::size_t(effect.id)].decision.state != effects::State::off;
        const auto weather = weather_of(effect.id, session.settings().weather.value_or(air.weather));
        if (is_called)
            add_difference(effect.id, true, {0, add_run(effects::set_of(effect.id), std::nullopt)});
        else if (any_weather && weather)
            add_difference(effect.id, false, {add_run(0, weather), 0});
    }
    if (differences.empty()) return differences;

    Progress progress("comparing", std::uint64_t(laps) * frames);
    for (int lap = 0; lap < laps; ++lap) {
        for (Run& run : runs) run.renderer->reset();
        for (std::size_t f = 0; f < frames; ++f) {
            const Camera camera = session.walk().camera(f);
            for (std::size_t i = 0; i < runs.size(); ++i) {
                Run& run = runs[(i + f) % runs.size()];  // nobody is always first
                frame::FrameSettings settings = session.settings_at(f);
                settings.without_effects |= run.without;
                if (run.weather) settings.weather = run.weather;
                const frame::FrameStats& stats =
                    run.renderer->draw(camera, session.dynamic(f, size, settings.without_effects), settings, run.image);
                double ms = stats.frame_ms;  // and ticks, which are no part of a frame
                for (const effects::EffectId id : {effects::EffectId::birds, effects::EffectId::rigid_bodies})
                    ms += stats.work(id).ms;
                run.ms[f] = std::min(run.ms[f], ms);
                for (std::size_t e = 0; e < effects::kEffectCount; ++e) {
                    run.work[e].ms += stats.effect_work[e].ms;
                    run.work[e].allocations += stats.effect_work[e].allocations;
                    run.work[e].rays += stats.effect_work[e].rays;
                }
            }
            progress.advance();
            if (lap != 0) continue;
            for (std::size_t i = 0; i < differences.size(); ++i) {
                EffectDifference& difference = differences[i];
                const shading::Image &with = runs[pairs[i].with].image, &without = runs[pairs[i].without].image;
                const double db = shading::compare_images(with, without, 0).psnr_db;
                if (f > 0 && db >= difference.psnr_db) continue;
                difference.psnr_db = db;
                difference.frame = f;
                difference.with = with;
                difference.without = without;
            }
        }
    }
    for (std::size_t i = 0; i < differences.size(); ++i) {
        EffectDifference& difference = differences[i];
        const Run &with = runs[pairs[i].with], &without = runs[pairs[i].without];
        std::vector<double> added(frames);
        for (std::size_t f = 0; f < frames; ++f) added[f] = with.ms[f] - without.ms[f];
        difference.ms_with = median_of(with.ms);
        difference.ms_without = median_of(without.ms);
        difference.ms_added = median_of(added);
        difference.own_with = with.work[std::size_t(difference.id)];
        difference.own_without = without.work[std::size_t(difference.id)];
        const double drawn = double(frames) * laps;
        difference.rays_per_frame = double(difference.own_with.rays) / drawn;
    }
    return differences;
}

}  // namespace ff::tool
