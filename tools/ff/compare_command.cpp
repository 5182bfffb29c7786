// ff compare: one session in two worlds, frame by frame in turn.

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <nlohmann/json.hpp>

#include "engine/budget/lap_table.h"
#include "engine/core/jobs.h"
#include "engine/core/log.h"
#include "engine/core/quantile.h"
#include "engine/scene/load_world.h"
#include "engine/shading/image_difference.h"
#include "game/beacons/beacons_game.h"
#include "tools/ff/frame_recorder.h"
#include "tools/ff/machine.h"
#include "tools/ff/replay_drawer.h"
#include "tools/ff/walk_lap.h"
#include "tools/page/page.h"
#include "tools/picture/picture_file.h"

namespace ff::tool {
namespace {

using nlohmann::json;

/// One of the two worlds.
struct Side {
    std::filesystem::path pack;
    std::unique_ptr<scene::World> world;
    std::unique_ptr<ReplayDrawer> drawer;
    report::FrameSeries series;
};

/// The frame that differs most, and all of them summed up.
struct Difference {
    double psnr_sum_db = 0.0, psnr_min_db = 99.0;
    std::size_t frame = 0;
    std::array<shading::Image, 2> images;
    std::optional<std::uint64_t> parted_tick;  ///< after which the two games' states differ

    void add(std::size_t at, const shading::Image& a, const shading::Image& b) {
        const double db = shading::compare_images(a, b, 0).psnr_db;
        psnr_sum_db += db;
        if (!images[0].pixels.empty() && db >= psnr_min_db) return;
        psnr_min_db = db;
        frame = at;
        images = {a, b};
    }
};

/// Where two pictures differ: black where they do not, over red and yellow to white at 64 levels of 255.
shading::Image map_of(const shading::Image& a, const shading::Image& b) {
    constexpr float kWhite = 64.0f;
    shading::Image map;
    map.resize(a.width, a.height);
    for (int y = 0; y < a.height; ++y)
        for (int x = 0; x < a.width; ++x) {
            const std::size_t at = std::size_t(y) * std::size_t(a.stride) + std::size_t(x);
            int most = 0;
            for (int c = 0; c < 24; c += 8)
                most = std::max(most, std::abs(int(a.pixels[at] >> c & 255u) - int(b.pixels[at] >> c & 255u)));
            const float heat = 3.0f * float(most) / kWhite;
            std::uint32_t pixel = 0xFF000000u;
            for (int c = 0; c < 3; ++c)
                pixel |= std::uint32_t(std::lround(255.0f * std::clamp(heat - float(c), 0.0f, 1.0f))) << 8 * c;
            map.pixels[std::size_t(y) * std::size_t(map.stride) + std::size_t(x)] = pixel;
        }
    return map;
}

/// Replays the session once in both worlds.
Status replay_lap(const CompareOptions& options, const replay::Recording& recording, std::uint64_t end,
                  std::array<Side, 2>& sides, budget::LapTable& table, Difference& difference) {
    const host::GameInfo& info = beacons::game_info();
    std::vector<host::ReplaySession> sessions;
    for (Side& side : sides) {
        side.drawer->reset();
        auto session = host::ReplaySession::begin(info, *side.world, recording, true);
        if (!session)
            return bad_input(
                fmt::format("{} in {}: {}", options.recording.string(), side.pack.string(), session.error().message));
        sessions.push_back(std::move(*session));
    }
    const bool is_first_lap = table.laps() == 0;
    table.add_lap();
    for (std::size_t f = 0; f < table.frames(); ++f) {
        // What is seen comes from the first world, so it is shown before either is drawn.
        host::GameView view;
        sessions[0].game().show(0.0, view);
        for (std::size_t i = 0; i < sides.size(); ++i) {
            const std::size_t s = (i + f) % sides.size();
            FF_TRY(sides[s].drawer->draw_from(view, sessions[s].game()));
            table.at(f, s) = sides[s].drawer->frame_ms();
        }
        if (is_first_lap) {
            for (Side& side : sides)
                side.series.add(view.camera, 0.0, report::work_of(side.drawer->stats(), side.drawer->allocations(), 0),
                                side.drawer->stats());
            difference.add(f, sides[0].drawer->image(), sides[1].drawer->image());
        }
        for (std::uint64_t t = 0; t < kTicksPerFrame && sessions[0].tick() < end; ++t) {
            for (host::ReplaySession& session : sessions) session.step();
            if (!difference.parted_tick && sessions[0].game().digest() != sessions[1].game().digest())
                difference.parted_tick = sessions[0].tick() - 1;
        }
    }
    return {};
}

json times_of(const std::vector<double>& ms) {
    return {
        {"median", median_of(ms)}, {"p99", quantile_of(ms, 0.99)}, {"max", *std::max_element(ms.begin(), ms.end())}};
}

Status write_pictures(const CompareOptions& options, const Difference& difference, json& report) {
    std::error_code error;
    std::filesystem::create_directories(options.out, error);
    if (error) return failure(fmt::format("{}: cannot create: {}", options.out.string(), error.message()));
    const shading::Image map = map_of(difference.images[0], difference.images[1]);
    const std::pair<const char*, const shading::Image*> pictures[] = {
        {"a", &difference.images[0]}, {"b", &difference.images[1]}, {"difference", &map}};
    for (const auto& [name, image] : pictures) {
        FF_TRY(write_image(options.out / fmt::format("{}.png", name), *image));
        FF_ASSIGN(report["image"][name], page::picture_url(*image));
    }
    return {};
}

}  // namespace

Status run_compare(const CompareOptions& options) {
    FF_ASSIGN(const replay::Recording recording, replay::load_recording(options.recording));
    const std::uint64_t end = std::min<std::uint64_t>(options.until.value_or(UINT64_MAX), recording.commands.size());
    const std::size_t frames = end / kTicksPerFrame;
    if (frames <= kWarmUpFrames)
        return bad_input(fmt::format("{}: {} ticks are {} frames; expected more than {}, for those do not count",
                                     options.recording.string(), end, frames, kWarmUpFrames));
    std::array<Side, 2> sides{{{.pack = {}, .world = {}, .drawer = {}, .series = report::FrameSeries(frames)},
                               {.pack = {}, .world = {}, .drawer = {}, .series = report::FrameSeries(frames)}}};
    for (std::size_t s = 0; s < sides.size(); ++s) {
        FF_ASSIGN(sides[s].pack, pack_of(options.packs[s]));
        FF_ASSIGN(sides[s].world, scene::load_world(sides[s].pack));
        sides[s].drawer = std::make_unique<ReplayDrawer>(*sides[s].world, options.size, options.budget_ms);
    }
    if (recording.header.pack_hash != sides[0].world->statistics().pack_hash)
        log_warning("{}: recorded in '{}', not in {}: the player may run into other things", options.recording.string(),
                    recording.header.pack, sides[0].pack.string());

    budget::LapTable table(frames, sides.size());
    Difference difference;
    {
        Progress progress("comparing", std::uint64_t(options.laps));
        for (int lap = 0; lap < options.laps; ++lap) {
            FF_TRY(replay_lap(options, recording, end, sides, table, difference));
            progress.advance();
        }
    }

    json report{{"kind", "compare"},
                {"recording", options.recording.string()},
                {"machine", {{"cpu", cpu_name()}, {"threads", worker_count()}}},
                {"settings",
                 {{"laps", options.laps},
                  {"width", options.size.width},
                  {"height", options.size.height},
                  {"budget_ms", options.budget_ms},
                  {"frame_ms", "a frame's time is the least of its laps"}}},
                {"packs", json::array()},
                {"parted_tick", difference.parted_tick ? json(*difference.parted_tick) : json(nullptr)},
                {"image",
                 {{"psnr_db_mean", difference.psnr_sum_db / double(frames)},
                  {"psnr_db_min", difference.psnr_min_db},
                  {"worst_frame", difference.frame}}}};
    std::array<std::vector<double>, 2> ms;
    std::vector<double> ratios;
    for (std::size_t f = 0; f < frames; ++f) {
        for (std::size_t s = 0; s < sides.size(); ++s) {
            sides[s].series.set_ms(f, table.least(f, s));
            if (f >= kWarmUpFrames) ms[s].push_back(table.least(f, s));
        }
        if (f >= kWarmUpFrames) ratios.push_back(ms[1].back() / ms[0].back());
    }
    for (std::size_t s = 0; s < sides.size(); ++s)
        report["packs"].push_back({{"pack", sides[s].pack.string()},
                                   {"scene", sides[s].world->info().name},
                                   {"triangles", sides[s].world->statistics().triangles},
                                   {"frame_ms", times_of(ms[s])},
                                   {"frames", sides[s].series.to_json()}});
    report["ratio"] = {{"median", median_of(ms[1]) / median_of(ms[0])},
                       {"p99", quantile_of(ms[1], 0.99) / quantile_of(ms[0], 0.99)},
                       {"median_of_frames", median_of(ratios)}};
    FF_TRY(write_pictures(options, difference, report));

    if (options.json) {
        fmt::print("{}\n", report.dump(1));
    } else {
        fmt::print("{:<10} {:>10} {:>10} {:>10}\n", "frame, ms", "median", "p99", "worst");
        for (std::size_t s = 0; s < sides.size(); ++s) {
            const json times = times_of(ms[s]);
            fmt::print("{:<10} {:>10.2f} {:>10.2f} {:>10.2f}  {}\n", s == 0 ? "a" : "b", times["median"].get<double>(),
                       times["p99"].get<double>(), times["max"].get<double>(), sides[s].pack.string());
        }
        fmt::print("{:<10} {:>10.3f} {:>10.3f}\nimages: {:.1f} dB in the mean, {:.1f} dB in frame {}\n", "b / a",
                   report["ratio"]["median"].get<double>(), report["ratio"]["p99"].get<double>(),
                   difference.psnr_sum_db / double(frames), difference.psnr_min_db, difference.frame);
    }
    if (difference.parted_tick)
        log_info(
            "the sessions part after tick {}: the player or something else that moves met what the other pack "
            "does not have",
            *difference.parted_tick);
    log_info("{}: a.png, b.png and difference.png of frame {}", std::filesystem::absolute(options.out).string(),
             difference.frame);
    return {};
}

}  // namespace ff::tool
