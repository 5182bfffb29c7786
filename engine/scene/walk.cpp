#include "engine/scene/walk.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <nlohmann/json.hpp>
#include <span>

#include "engine/core/write_file.h"

namespace ff::scene {
namespace {

using nlohmann::json;

constexpr std::array<std::string_view, 4> kWalkKeys{"format", "fov_deg", "rate_hz", "frames"};
constexpr std::array<std::string_view, 4> kFrameKeys{"p", "yaw_deg", "pitch_deg", "roll_deg"};
constexpr std::size_t kMaxTextBytes = std::size_t(1) << 30;

/// Feeds the parser and knows the line of the last token: its last character but for the one that ended it.
struct LineCounter {
    std::size_t line = 1, last_line = 1;
};
class CountingIterator {
  public:
    using iterator_category = std::input_iterator_tag;
    using value_type = char;
    using difference_type = std::ptrdiff_t;
    using pointer = const char*;
    using reference = const char&;

    CountingIterator(const char* at, LineCounter* counter) : at_(at), counter_(counter) {}
    reference operator*() const { return *at_; }
    CountingIterator& operator++() {
        counter_->last_line = counter_->line;
        if (*at_ == '\n') ++counter_->line;
        ++at_;
        return *this;
    }
    CountingIterator operator++(int) {
        CountingIterator old = *this;
        ++*this;
        return old;
    }
    bool operator==(const CountingIterator& other) const { return at_ == other.at_; }

  private:
    const char* at_;
    LineCounter* counter_;
};

/// Insertions, deletions and exchanges that lead from one word to the other (Levenshtein 1966).
std::size_t edit_distance(std::string_view a, std::string_view b) {
    std::vector<std::size_t> row(b.size() + 1);
    for (std::size_t j = 0; j <= b.size(); ++j) row[j] = j;
    for (std::size_t i = 1; i <= a.size(); ++i) {
        std::size_t diagonal = row[0];
        row[0] = i;
        for (std::size_t j = 1; j <= b.size(); ++j) {
            const std::size_t above = row[j];
            row[j] = std::min({above + 1, row[j - 1] + 1, diagonal + (a[i - 1] != b[j - 1])});
            diagonal = above;
        }
    }
    return row[b.size()];
}

/// Of words of unlike lengths: 0 for the same, 1 for nothing in common.
double unlikeness(std::string_view a, std::string_view b) {
    return static_cast<double>(edit_distance(a, b)) /
           static_cast<double>(std::max({a.size(), b.size(), std::size_t(1)}));
}

std::string_view nearest_of(std::span<const std::string_view> names, std::string_view name) {
    return *std::min_element(names.begin(), names.end(), [&](std::string_view a, std::string_view b) {
        return unlikeness(a, name) < unlikeness(b, name);
    });
}

/// Takes nlohmann's events one by one: no tree of a million frames, a line for every message, duplicate keys seen.
class WalkHandler {
  public:
    WalkHandler(Walk& walk, const LineCounter& lines) : walk_(walk), lines_(lines) {}

    [[nodiscard]] const std::string& problem() const { return problem_; }

    // The events of nlohmann::json_sax; false ends the parse.
    bool null() { return wrong("null"); }
    bool boolean(bool value) { return wrong(value ? "true" : "false"); }
    bool number_integer(json::number_integer_t value) { return number(static_cast<double>(value)); }
    bool number_unsigned(json::number_unsigned_t value) { return number(static_cast<double>(value)); }
    bool number_float(json::number_float_t value, const std::string&) { return number(value); }
    bool string(std::string& value) { return wrong(fmt::format("\"{:.40}\"", value)); }
    bool binary(json::binary_t&) { return wrong("binary data"); }
    bool start_object(std::size_t);
    bool end_object();
    bool key(std::string& key);
    bool start_array(std::size_t);
    bool end_array();
    bool parse_error(std::size_t, const std::string&, const json::exception& error) {
        std::string_view what = error.what();
        if (const auto bracket = what.find("] "); bracket != what.npos) what.remove_prefix(bracket + 2);
        return fail(fmt::format("no JSON: {}", what));
    }

  private:
    enum class Place { start, walk, frames, frame, position, end };

    bool number(double value);
    bool wrong(std::string_view found) { return fail(fmt::format("{}: {}; expected {}", where(), found, expected())); }
    bool fail(std::string what) {
        if (problem_.empty()) problem_ = fmt::format("{}: {}", lines_.last_line, what);
        return false;
    }
    [[nodiscard]] std::string where() const;
    [[nodiscard]] std::string_view expected() const;
    bool all_seen(std::span<const std::string_view> keys, const std::array<bool, 4>& seen);

    Walk& walk_;
    const LineCounter& lines_;
    std::string problem_;
    Place place_ = Place::start;
    std::string_view key_;  ///< of kWalkKeys or kFrameKeys
    std::array<bool, 4> walk_seen_{}, frame_seen_{};
    WalkFrame frame_;
    int coordinate_ = 0;
};

std::string WalkHandler::where() const {
    switch (place_) {
        case Place::start:
        case Place::end:
            return "the file";
        case Place::walk:
            return std::string(key_);
        case Place::frames:
            return fmt::format("frames[{}]", walk_.frames.size());
        case Place::frame:
            return fmt::format("frames[{}].{}", walk_.frames.size(), key_);
        case Place::position:
            return fmt::format("frames[{}].p[{}]", walk_.frames.size(), coordinate_);
    }
    return {};
}

std::string_view WalkHandler::expected() const {
    switch (place_) {
        case Place::start:
            return "an object {\"format\": 1, \"fov_deg\", \"rate_hz\", \"frames\"}";
        case Place::walk:
            if (key_ == "frames") return "an array of frames";
            return key_ == "format" ? "1" : "a number";
        case Place::frames:
            return "an object {\"p\": [x, y, z], \"yaw_deg\", \"pitch_deg\", \"roll_deg\"}";
        case Place::frame:
            return key_ == "p" ? "an array of three numbers, metres" : "a number of degrees";
        case Place::position:
            return "three numbers, metres";
        case Place::end:
            return "nothing more";
    }
    return {};
}

bool WalkHandler::number(double value) {
    if (place_ == Place::walk && key_ == "format")
        return value == 1.0 || fail(fmt::format("format: {}; expected 1, the format that this program reads", value));
    if (place_ == Place::walk && key_ == "fov_deg") {
        walk_.fov_deg = value;
    } else if (place_ == Place::walk && key_ == "rate_hz") {
        walk_.rate_hz = value;
    } else if (place_ == Place::frame && key_ == "yaw_deg") {
        frame_.yaw_deg = value;
    } else if (place_ == Place::frame && key_ == "pitch_deg") {
        frame_.pitch_deg = value;
    } else if (place_ == Place::frame && key_ == "roll_deg") {
        frame_.roll_deg = value;
    } else if (place_ == Place::position && coordinate_ < 3) {
        frame_.position[coordinate_++] = value;
    } else {
        return wrong(fmt::format("the number {}", value));
    }
    return true;
}

bool WalkHandler::start_object(std::size_t) {
    if (place_ == Place::start) {
        place_ = Place::walk;
    } else if (place_ == Place::frames) {
        if (walk_.frames.size() == kMaxWalkFrames)
            return fail(fmt::format("frames: more than {}; expected at most as many", kMaxWalkFrames));
        place_ = Place::frame;
        frame_ = {};
        frame_seen_ = {};
    } else {
        return wrong("an object");
    }
    return true;
}

bool WalkHandler::key(std::string& key) {
    const bool in_frame = place_ == Place::frame;
    const auto& known = in_frame ? kFrameKeys : kWalkKeys;
    const std::string at = in_frame ? where().substr(0, where().find('.')) : std::string("the walk");
    const auto found = std::find(known.begin(), known.end(), key);
    if (found == known.end())
        return fail(fmt::format("{}: unknown key \"{:.40}\"; the nearest known one is \"{}\"", at, key,
                                nearest_of(known, std::string_view(key).substr(0, 64))));
    bool& seen = (in_frame ? frame_seen_ : walk_seen_)[std::size_t(found - known.begin())];
    if (seen) return fail(fmt::format("{}: key \"{}\" stands twice; expected once", at, key));
    seen = true;
    key_ = *found;
    return true;
}

bool WalkHandler::all_seen(std::span<const std::string_view> keys, const std::array<bool, 4>& seen) {
    for (std::size_t i = 0; i < keys.size(); ++i) {
        if (seen[i]) continue;
        return place_ == Place::walk
                   ? fail(fmt::format("the walk has no \"{}\"; expected one", keys[i]))
                   : fail(fmt::format("frames[{}] has no \"{}\"; expected one", walk_.frames.size(), keys[i]));
    }
    return true;
}

bool WalkHandler::end_object() {
    if (place_ == Place::walk) {
        if (!all_seen(kWalkKeys, walk_seen_)) return false;
        place_ = Place::end;
        return true;
    }
    // Angles default to 0; a frame without a place is a mistake.
    if (!all_seen(std::span(kFrameKeys).first(1), frame_seen_)) return false;
    walk_.frames.push_back(frame_);
    place_ = Place::frames;
    return true;
}

bool WalkHandler::start_array(std::size_t) {
    if (place_ == Place::walk && key_ == "frames") {
        place_ = Place::frames;
    } else if (place_ == Place::frame && key_ == "p") {
        place_ = Place::position;
        coordinate_ = 0;
    } else {
        return wrong("an array");
    }
    return true;
}

bool WalkHandler::end_array() {
    if (place_ == Place::position) {
        if (coordinate_ != 3) return wrong(fmt::format("the end after {} numbers", coordinate_));
        place_ = Place::frame;
    } else {
        place_ = Place::walk;
    }
    return true;
}

bool is_within(double value, double low, double high) {
    return value >= low && value <= high;  // false for a NaN
}

}  // namespace

Camera Walk::camera(std::size_t frame) const {
    const WalkFrame& f = frames[frame];
    return {f.position, radians_of(f.yaw_deg), radians_of(f.pitch_deg), radians_of(f.roll_deg), radians_of(fov_deg)};
}

std::string find_walk_problem(const Walk& walk) {
    constexpr double kMaxAngle = 1e6;
    if (!is_within(walk.fov_deg, 1.0, 170.0))
        return fmt::format("fov_deg: {}; expected degrees in [1, 170]", walk.fov_deg);
    if (!(walk.rate_hz > 0.0 && walk.rate_hz <= 1e4))
        return fmt::format("rate_hz: {}; expected frames per second in (0, 10000]", walk.rate_hz);
    if (walk.frames.empty() || walk.frames.size() > kMaxWalkFrames)
        return fmt::format("frames: {} of them; expected 1 to {}", walk.frames.size(), kMaxWalkFrames);
    for (std::size_t i = 0; i < walk.frames.size(); ++i) {
        const WalkFrame& frame = walk.frames[i];
        for (int axis = 0; axis < 3; ++axis)
            if (!is_within(frame.position[axis], -kMaxWorldCoordinate, kMaxWorldCoordinate))
                return fmt::format("frames[{}].p[{}]: {}; expected metres within {:g} of the origin", i, axis,
                                   frame.position[axis], kMaxWorldCoordinate);
        if (!is_within(frame.yaw_deg, -kMaxAngle, kMaxAngle))
            return fmt::format("frames[{}].yaw_deg: {}; expected degrees within {:g} of 0", i, frame.yaw_deg,
                               kMaxAngle);
        if (!is_within(frame.pitch_deg, -90.0, 90.0))
            return fmt::format("frames[{}].pitch_deg: {}; expected degrees in [-90, 90]", i, frame.pitch_deg);
        if (!is_within(frame.roll_deg, -kMaxAngle, kMaxAngle))
            return fmt::format("frames[{}].roll_deg: {}; expected degrees within {:g} of 0", i, frame.roll_deg,
                               kMaxAngle);
    }
    return {};
}

Result<Walk> parse_walk(std::string_view text, const std::string& file, std::string name) {
    if (text.size() > kMaxTextBytes)
        return bad_input(fmt::format("{}: {} bytes; expected a walk of at most {}", file, text.size(), kMaxTextBytes));
    Walk walk;
    walk.name = std::move(name);
    LineCounter lines;
    WalkHandler handler(walk, lines);
    const bool parsed = json::sax_parse(CountingIterator(text.data(), &lines),
                                        CountingIterator(text.data() + text.size(), &lines), &handler);
    if (!parsed) return bad_input(fmt::format("{}:{}", file, handler.problem()));
    if (const std::string problem = find_walk_problem(walk); !problem.empty())
        return bad_input(fmt::format("{}: {}", file, problem));
    return walk;
}

Result<Walk> load_walk(const std::filesystem::path& path) {
    FF_ASSIGN(const std::string text, read_text_file(path));
    std::string name = path.filename().string();
    name = name.substr(0, name.find('.'));
    return parse_walk(text, path.string(), std::move(name));
}

std::string walk_to_json(const Walk& walk) {
    fmt::memory_buffer out;
    fmt::format_to(std::back_inserter(out), "{{\"format\": 1, \"fov_deg\": {}, \"rate_hz\": {}, \"frames\": [",
                   walk.fov_deg, walk.rate_hz);
    std::string_view separator = "\n";
    for (const WalkFrame& f : walk.frames) {
        fmt::format_to(std::back_inserter(out),
                       "{}{{\"p\": [{}, {}, {}], \"yaw_deg\": {}, \"pitch_deg\": {}, \"roll_deg\": {}}}", separator,
                       f.position.x, f.position.y, f.position.z, f.yaw_deg, f.pitch_deg, f.roll_deg);
        separator = ",\n";
    }
    fmt::format_to(std::back_inserter(out), "\n]}}\n");
    return fmt::to_string(out);
}

}  // namespace ff::scene
