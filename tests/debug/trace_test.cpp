// Traces as their readers see them: JSON, times that go forward, slices that nest.

#include "engine/debug/trace.h"

#include <gtest/gtest.h>

#include <map>
#include <nlohmann/json.hpp>
#include <vector>

#include "engine/core/work_clock.h"
#include "engine/frame/timed_pass.h"

namespace ff::debug {
namespace {

using nlohmann::json;

/// A frame with a few passes and an effect inside one of them.
frame::FrameStats small_frame() {
    frame::FrameStats stats;
    stats.log.begin_ns = steady_ns();
    { const frame::TimedPass pass(stats, frame::Pass::cast); }
    for (int i = 0; i < 2; ++i) {
        const frame::TimedPass pass(stats, frame::Pass::sun);
        const frame::TimedEffect effect(stats, effects::EffectId::sun_shadows);
    }
    stats.rays = 7;
    stats.log.end_ns = steady_ns();
    return stats;
}

TEST(Trace, is_json_with_times_that_go_forward_and_slices_that_nest) {
    Trace trace(4);
    for (const char* mode : {"hybrid", "ray\"cast"}) {
        trace.begin_process(mode);
        for (std::uint64_t f = 0; f < 2; ++f) trace.add(f, 0, small_frame());
    }
    const json parsed = json::parse(trace.to_json());
    double last = 0.0;
    std::map<std::pair<int, int>, std::vector<double>> open;  // ends of the slices around, by thread
    std::map<std::string, int> counts;
    for (const json& event : parsed.at("traceEvents")) {
        const std::string phase = event.at("ph");
        ++counts[phase + " " + event.at("name").get<std::string>()];
        if (phase == "M") continue;
        const double begin = event.at("ts");
        EXPECT_GE(begin, last);
        last = begin;
        if (phase != "X") continue;
        auto& ends = open[{event.at("pid").get<int>(), event.at("tid").get<int>()}];
        while (!ends.empty() && ends.back() <= begin) ends.pop_back();
        const double end = begin + event.at("dur").get<double>();
        if (!ends.empty()) {
            EXPECT_LE(end, ends.back() + 1e-6) << event;
        }
        if (event.at("cat") == "pass") {
            EXPECT_EQ(ends.size(), 1u) << "a pass lies in its frame: " << event;
        }
        ends.push_back(end);
    }
    EXPECT_EQ(counts["X frame 0"], 2);
    EXPECT_EQ(counts["X cast"], 4);
    EXPECT_EQ(counts["X sun"], 8);
    EXPECT_EQ(counts["X sun_shadows"], 8);
    EXPECT_EQ(counts["C rays"], 4);
    EXPECT_EQ(counts["C pixels by source"], 4);
    EXPECT_EQ(counts["M process_name"], 2);
    EXPECT_EQ(parsed["traceEvents"][3]["args"]["name"], "ray\"cast");
}

TEST(Trace, of_no_frames_is_still_one) {
    EXPECT_TRUE(json::parse(Trace(0).to_json()).at("traceEvents").empty());
}

TEST(SpanLog, keeps_what_fits_and_counts_the_rest) {
    frame::SpanLog log;
    for (std::size_t i = 0; i < frame::SpanLog::kCapacity + 3; ++i) log.add({});
    EXPECT_EQ(log.spans().size(), frame::SpanLog::kCapacity);
    EXPECT_EQ(log.dropped(), 3u);
}

}  // namespace
}  // namespace ff::debug
