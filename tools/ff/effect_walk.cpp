#include "tools/ff/effect_walk.h"

#include <algorithm>
#include <limits>
#include <memory>

#include "engine/core/log.h"
#include "engine/core/quantile.h"
#include "engine/shading/image_difference.h"
#include "tools/ff/walk_lap.h"

namespace ff::tool {

Result<EffectWalk> walk_effects(Session& session, const ImageSize& size, std::size_t frames) {
    const auto renderer = session.make_renderer(size);
    shading::Image image;
    EffectWalk walk;
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
        }
        ++walk.frames;
        progress.advance();
    });
    if (!drawn) return drawn.error();
    return walk;
}

std::vector<EffectDifference> compare_effects(Session& session, const ImageSize& size, std::size_t frames, int laps,
                                              const EffectWalk& walk) {
    struct Run {
        frame::FrameSettings settings;
        std::unique_ptr<frame::Renderer> renderer;
        std::vector<double> ms;  // [frame], the least of all laps
        shading::Image image;
    };
    const auto run_of = [&](effects::EffectSet without) {
        Run run{.settings = session.settings(), .renderer = session.make_renderer(size)};
        run.settings.without_effects |= without;
        run.ms.assign(frames, std::numeric_limits<double>::infinity());
        return run;
    };
    std::vector<Run> runs;
    runs.push_back(run_of(0));
    std::vector<EffectDifference> differences;
    for (const effects::Effect& effect : effects::registry()) {
        if (walk.of[std::size_t(effect.id)].decision.state == effects::State::off) continue;
        runs.push_back(run_of(effects::set_of(effect.id)));
        differences.push_back({.id = effect.id});
    }
    if (differences.empty()) return differences;

    Progress progress("comparing", std::uint64_t(laps) * frames);
    for (int lap = 0; lap < laps; ++lap) {
        for (Run& run : runs) run.renderer->reset();
        for (std::size_t f = 0; f < frames; ++f) {
            const Camera camera = session.walk().camera(f);
            for (std::size_t i = 0; i < runs.size(); ++i) {
                Run& run = runs[(i + f) % runs.size()];  // nobody is always first
                run.settings.time_s = session.settings_at(f).time_s;
                run.ms[f] = std::min(
                    run.ms[f], run.renderer->draw(camera, session.dynamic(f, size), run.settings, run.image).frame_ms);
            }
            progress.advance();
            if (lap != 0) continue;
            for (std::size_t i = 0; i < differences.size(); ++i) {
                EffectDifference& difference = differences[i];
                const double db = shading::compare_images(runs[0].image, runs[i + 1].image, 0).psnr_db;
                if (f > 0 && db >= difference.psnr_db) continue;
                difference.psnr_db = db;
                difference.frame = f;
                difference.with = runs[0].image;
                difference.without = runs[i + 1].image;
            }
        }
    }
    for (std::size_t i = 0; i < differences.size(); ++i) {
        std::vector<double> added(frames);
        for (std::size_t f = 0; f < frames; ++f) added[f] = runs[0].ms[f] - runs[i + 1].ms[f];
        differences[i].ms_with = median_of(runs[0].ms);
        differences[i].ms_without = median_of(runs[i + 1].ms);
        differences[i].ms_added = median_of(added);
    }
    return differences;
}

}  // namespace ff::tool
