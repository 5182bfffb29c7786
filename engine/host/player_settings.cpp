#include "engine/host/player_settings.h"

#include <fmt/format.h>

#include <toml++/toml.h>
#include <algorithm>
#include <cmath>
#include <cstdlib>

namespace ff::host {
namespace {

/// Reads one table key by key and remembers the first thing that is wrong.
class SettingsReader {
  public:
    SettingsReader(const toml::table& table, std::string file) : table_(table), file_(std::move(file)) {}

    void number(const char* key, double low, double high, double& out) {
        const toml::node* node = find(key);
        if (node == nullptr) return;
        const auto value = node->value<double>();
        // 0 stands for the game's own choice, wherever it is a default.
        if (!value || !(*value == out || (*value >= low && *value <= high)))
            return fail(*node, fmt::format("{}: expected a number from {} to {}", key, low, high));
        out = *value + 0.0;  // no negative zero: it would be written as an integer, and read as another number
    }
    void integer(const char* key, int low, int high, int& out) {
        double value = out;
        number(key, low, high, value);
        out = int(std::lround(value));
    }
    void boolean(const char* key, bool& out) {
        const toml::node* node = find(key);
        if (node == nullptr) return;
        const auto value = node->value<bool>();
        if (!value) return fail(*node, fmt::format("{}: expected true or false", key));
        out = *value;
    }
    void triggers(const char* table_key, std::vector<loop::Action>& actions) {
        const toml::node* node = find(table_key);
        if (node == nullptr) return;
        const toml::table* keys = node->as_table();
        if (keys == nullptr) return fail(*node, fmt::format("{}: expected a table of actions", table_key));
        for (const auto& [name, value] : *keys) {
            const auto action = std::find_if(actions.begin(), actions.end(),
                                             [&](const loop::Action& a) { return a.name == name.str(); });
            if (action == actions.end()) return fail(value, fmt::format("there is no action '{}'", name.str()));
            const toml::array* list = value.as_array();
            if (list == nullptr || list->size() > std::size(action->triggers))
                return fail(value, fmt::format("{}: expected a list of at most {} keys", name.str(),
                                               std::size(action->triggers)));
            std::fill(std::begin(action->triggers), std::end(action->triggers), loop::Trigger{});
            for (std::size_t i = 0; i < list->size(); ++i) {
                const auto text = (*list)[i].value<std::string>();
                const auto trigger = loop::parse_trigger(text.value_or(""));
                if (!trigger) return fail(value, trigger.error().message);
                action->triggers[i] = *trigger;
            }
        }
    }
    void finish() {
        for (const auto& [key, value] : table_)
            if (std::find(known_.begin(), known_.end(), key.str()) == known_.end())
                fail(value, fmt::format("there is no setting '{}'", key.str()));
    }
    [[nodiscard]] const std::optional<Error>& error() const { return error_; }

  private:
    const toml::node* find(const char* key) {
        known_.emplace_back(key);
        return table_.get(key);
    }
    void fail(const toml::node& node, const std::string& what) {
        if (!error_) error_ = bad_input(fmt::format("{}:{}: {}", file_, node.source().begin.line, what));
    }

    const toml::table& table_;
    std::string file_;
    std::vector<std::string> known_;
    std::optional<Error> error_;
};

}  // namespace

PlayerSettings default_settings(std::span<const loop::Action> actions) {
    PlayerSettings settings;
    settings.actions.assign(actions.begin(), actions.end());
    return settings;
}

std::string to_text(const PlayerSettings& settings) {
    std::string text = fmt::format(
        "fov_deg = {}\nbudget_ms = {}\nerror_px = {}\nwidth = {}\nheight = {}\nfullscreen = {}\nvolume = "
        "{}\nmouse_speed = "
        "{}\ninvert_pitch = {}\n"
        "\n[keys]\n",
        settings.fov_deg, settings.budget_ms, settings.error_px, settings.width, settings.height, settings.fullscreen,
        settings.volume, settings.mouse_speed, settings.invert_pitch);
    for (const loop::Action& action : settings.actions) {
        text += action.name + " = [";
        const char* separator = "";
        for (const loop::Trigger& trigger : action.triggers) {
            if (trigger.device == loop::Trigger::Device::none) continue;
            text += fmt::format("{}\"{}\"", separator, trigger_name(trigger));
            separator = ", ";
        }
        text += "]\n";
    }
    return text;
}

Result<PlayerSettings> read_settings(const std::string& text, const std::string& file,
                                     std::span<const loop::Action> actions) {
    toml::table parsed;
    try {
        parsed = toml::parse(text, file);
    } catch (const toml::parse_error& error) {
        return bad_input(fmt::format("{}:{}: not TOML: {}", file, error.source().begin.line, error.description()));
    }
    PlayerSettings settings = default_settings(actions);
    SettingsReader reader(parsed, file);
    reader.number("fov_deg", 30, 110, settings.fov_deg);
    reader.number("budget_ms", 0, 1000, settings.budget_ms);
    reader.number("error_px", 0, 16, settings.error_px);
    reader.integer("width", 64, 8192, settings.width);
    reader.integer("height", 64, 8192, settings.height);
    reader.boolean("fullscreen", settings.fullscreen);
    reader.number("volume", 0, 1, settings.volume);
    reader.number("mouse_speed", 0.05, 20, settings.mouse_speed);
    reader.boolean("invert_pitch", settings.invert_pitch);
    reader.triggers("keys", settings.actions);
    reader.finish();
    if (reader.error()) return *reader.error();
    return settings;
}

std::filesystem::path player_folder(const std::string& game) {
    const char* data = std::getenv("XDG_DATA_HOME");
    if (data != nullptr && *data != '\0') return std::filesystem::path(data) / game;
    const char* home = std::getenv("HOME");
    return std::filesystem::path(home != nullptr ? home : ".") / ".local" / "share" / game;
}

}  // namespace ff::host
