#include "engine/debug/trace.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "engine/effects/registry.h"

namespace ff::debug {
namespace {

constexpr int kFrameThread = 1, kEffectThread = 2;

std::string quoted(std::string_view text) {
    std::string out = "\"";
    for (const char c : text) {
        if (c == '"' || c == '\\') out += '\\';
        out += static_cast<unsigned char>(c) < 0x20 ? ' ' : c;
    }
    return out + '"';
}

/// Events of one process as text, each with the time by which they are sorted.
class Events {
  public:
    explicit Events(std::int64_t zero_ns) : zero_ns_(zero_ns) {}

    void name(std::string_view what, std::size_t process, int thread, std::string_view name) {
        lines_.emplace_back(zero_ns_, fmt::format("{{\"ph\":\"M\",\"name\":\"{}\",\"pid\":{},\"tid\":{},\"args\":{{"
                                                  "\"name\":{}}}}}",
                                                  what, process + 1, thread, quoted(name)));
    }
    void slice(std::string_view name, std::string_view category, std::size_t process, int thread, std::int64_t begin_ns,
               std::int64_t end_ns, std::string_view args = {}) {
        lines_.emplace_back(
            begin_ns,
            fmt::format("{{\"ph\":\"X\",\"name\":{},\"cat\":\"{}\",\"pid\":{},\"tid\":{},\"ts\":{:.3f},\"dur\":{:.3f}"
                        ",\"args\":{{{}}}}}",
                        quoted(name), category, process + 1, thread, microseconds(begin_ns),
                        1e-3 * double(end_ns - begin_ns), args));
    }
    /// @param series  "name":value, ...
    void counter(std::string_view name, std::size_t process, std::int64_t at_ns, std::string_view series) {
        if (!series.empty())
            lines_.emplace_back(
                at_ns, fmt::format("{{\"ph\":\"C\",\"name\":\"{}\",\"pid\":{},\"ts\":{:.3f},\"args\":{{{}}}}}", name,
                                   process + 1, microseconds(at_ns), series));
    }
    [[nodiscard]] std::string text() && {
        std::stable_sort(lines_.begin(), lines_.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
        std::string text = "{\"displayTimeUnit\":\"ms\",\"traceEvents\":[\n";
        for (std::size_t i = 0; i < lines_.size(); ++i)
            text += lines_[i].second + (i + 1 < lines_.size() ? ",\n" : "\n");
        return text + "]}\n";
    }

  private:
    [[nodiscard]] double microseconds(std::int64_t ns) const { return 1e-3 * double(ns - zero_ns_); }

    std::int64_t zero_ns_;
    std::vector<std::pair<std::int64_t, std::string>> lines_;
};

/// "name":value, ...
template <class Value>
std::string series_of(std::span<const std::string_view> names, Value&& value) {
    std::string text;
    for (std::size_t i = 0; i < names.size(); ++i)
        text += fmt::format("{}\"{}\":{:.4f}", text.empty() ? "" : ",", names[i], value(i));
    return text;
}

}  // namespace

void Trace::add(std::uint64_t number, std::uint64_t allocations, const frame::FrameStats& stats) {
    if (processes_.empty()) begin_process("frames");
    frames_.push_back({processes_.size() - 1, number, allocations, stats});
}

std::string Trace::to_json() const {
    if (frames_.empty()) return "{\"displayTimeUnit\":\"ms\",\"traceEvents\":[]}\n";
    Events events(frames_.front().stats.log.begin_ns);
    for (std::size_t p = 0; p < processes_.size(); ++p) {
        events.name("process_name", p, kFrameThread, processes_[p]);
        events.name("thread_name", p, kFrameThread, "frames");
        events.name("thread_name", p, kEffectThread, "effects");
    }
    constexpr std::array<std::string_view, 6> kSources{"near",     "sky",      "panorama",
                                                       "verified", "cast hit", "cast missed"};
    constexpr std::array<std::string_view, 2> kRays{"pixels", "sun"};
    std::array<std::string_view, effects::kEffectCount> effect_names;
    for (const effects::Effect& effect : effects::registry()) effect_names[std::size_t(effect.id)] = effect.name;
    for (const Frame& frame : frames_) {
        const frame::FrameStats& stats = frame.stats;
        const std::int64_t begin_ns = stats.log.begin_ns;
        std::string args = fmt::format("\"resolution\":{:.4f},\"effects\":\"", stats.resolution);
        for (std::size_t e = 0; e < effects::kEffectCount; ++e)
            if (stats.effects.of[e].state != effects::State::off)
                args += fmt::format("{} {}; ", effect_names[e],
                                    effects::kStateNames[std::size_t(stats.effects.of[e].state)]);
        events.slice(fmt::format("frame {}", frame.number), "frame", frame.process, kFrameThread, begin_ns,
                     stats.log.end_ns, args + "\"");
        for (const frame::Span& span : stats.log.spans())
            events.slice(span.is_effect ? effect_names[span.index] : frame::kPassNames[span.index],
                         span.is_effect ? "effect" : "pass", frame.process,
                         span.is_effect ? kEffectThread : kFrameThread, span.begin_ns, span.end_ns);

        events.counter("passes, ms", frame.process, begin_ns,
                       series_of(frame::kPassNames, [&](std::size_t i) { return stats.pass_ms[i]; }));
        events.counter("effects, ms", frame.process, begin_ns,
                       series_of(effect_names, [&](std::size_t i) { return stats.effect_work[i].ms; }));
        const frame::PixelCounts& pixels = stats.pixels;
        const std::array<std::uint64_t, 6> sources{pixels.near_field, pixels.sky,      pixels.panorama,
                                                   pixels.verified,   pixels.cast_hit, pixels.cast_miss};
        events.counter("pixels by source", frame.process, begin_ns,
                       series_of(kSources, [&](std::size_t i) { return double(sources[i]); }));
        const std::array<std::uint64_t, 2> rays{stats.rays, stats.sun_rays};
        events.counter("rays", frame.process, begin_ns,
                       series_of(kRays, [&](std::size_t i) { return double(rays[i]); }));
        events.counter("allocations", frame.process, begin_ns, fmt::format("\"heap\":{}", frame.allocations));
        events.counter("resolution", frame.process, begin_ns, fmt::format("\"share\":{:.4f}", stats.resolution));
        if (std::isfinite(stats.near_m))
            events.counter("near distance, m", frame.process, begin_ns, fmt::format("\"near\":{:.2f}", stats.near_m));
    }
    return std::move(events).text();
}

}  // namespace ff::debug
