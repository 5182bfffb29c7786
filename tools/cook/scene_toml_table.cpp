#include "tools/cook/scene_toml_table.h"

#include <fmt/core.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <sstream>

namespace ff::cook {
namespace {

/// Edits (insert, remove, change) that turn a into b.
std::size_t edit_distance(const std::string& a, const std::string& b) {
    std::vector<std::size_t> row(b.size() + 1);
    std::iota(row.begin(), row.end(), std::size_t(0));
    for (std::size_t i = 1; i <= a.size(); ++i) {
        std::size_t diagonal = row[0];
        row[0] = i;
        for (std::size_t j = 1; j <= b.size(); ++j) {
            const std::size_t changed = diagonal + (a[i - 1] == b[j - 1] ? 0 : 1);
            diagonal = row[j];
            row[j] = std::min({row[j] + 1, row[j - 1] + 1, changed});
        }
    }
    return row[b.size()];
}

std::string written(const toml::node& node) {
    std::ostringstream out;
    node.visit([&](const auto& value) { out << value; });
    std::string text = out.str();
    if (text.size() > 60) text = text.substr(0, 57) + "...";
    return text;
}

std::string range_text(double low, double high) {
    return fmt::format("a number in [{:g}, {:g}]", low, high);
}

bool in_range(const std::optional<double>& value, double low, double high) {
    return value && std::isfinite(*value) && *value >= low && *value <= high;
}

}  // namespace

void TomlReport::fail(const toml::source_region& place, const std::string& text) {
    if (!error) error = bad_input(fmt::format("{}:{}: {}", file.string(), place.begin.line, text));
}

const toml::node* TomlTable::find(const std::string& key) {
    known_.push_back(key);
    return table_.get(key);
}

void TomlTable::expect(const std::string& key, const toml::node& node, const std::string& expected) {
    report_.fail(node.source(), fmt::format("{} {} = {}; expected {}", name_, key, written(node), expected));
}

void TomlTable::fail(const std::string& key, const std::string& text) {
    const toml::node* node = table_.get(key);
    report_.fail(node ? node->source() : table_.source(), fmt::format("{} {}: {}", name_, key, text));
}

bool TomlTable::has(const std::string& key) {
    return find(key) != nullptr;
}

double TomlTable::number(const std::string& key, double fallback, double low, double high) {
    return optional_number(key, low, high).value_or(fallback);
}

std::optional<double> TomlTable::optional_number(const std::string& key, double low, double high) {
    const toml::node* node = find(key);
    if (!node) return std::nullopt;
    const std::optional<double> value = node->is_number() ? node->value<double>() : std::nullopt;
    if (in_range(value, low, high)) return value;
    expect(key, *node, range_text(low, high));
    return std::nullopt;
}

std::int64_t TomlTable::integer(const std::string& key, std::int64_t fallback, std::int64_t low, std::int64_t high) {
    const toml::node* node = find(key);
    if (!node) return fallback;
    const std::optional<std::int64_t> value = node->is_integer() ? node->value<std::int64_t>() : std::nullopt;
    if (value && *value >= low && *value <= high) return *value;
    expect(key, *node, fmt::format("a whole number in [{}, {}]", low, high));
    return fallback;
}

bool TomlTable::boolean(const std::string& key, bool fallback) {
    const toml::node* node = find(key);
    if (!node) return fallback;
    if (node->is_boolean()) return node->value<bool>().value_or(fallback);
    expect(key, *node, "true or false");
    return fallback;
}

std::string TomlTable::text(const std::string& key, const std::string& fallback) {
    const toml::node* node = find(key);
    if (!node) return fallback;
    const std::optional<std::string> value = node->value<std::string>();
    if (value && !value->empty()) return *value;
    expect(key, *node, "a text in quotes");
    return fallback;
}

std::size_t TomlTable::choice(const std::string& key, std::size_t fallback, const std::vector<std::string>& choices) {
    const toml::node* node = find(key);
    if (!node) return fallback;
    const auto found = std::find(choices.begin(), choices.end(), node->value<std::string>().value_or(""));
    if (found != choices.end()) return std::size_t(found - choices.begin());
    expect(key, *node, fmt::format("one of \"{}\"", fmt::join(choices, "\", \"")));
    return fallback;
}

std::filesystem::path TomlTable::file(const std::string& key, bool required) {
    const toml::node* node = find(key);
    if (!node) {
        if (required) fail(key, "missing; expected the path of a file");
        return {};
    }
    const std::optional<std::string> value = node->value<std::string>();
    if (!value || value->empty()) {
        expect(key, *node, "the path of a file");
        return {};
    }
    const std::filesystem::path path = report_.file.parent_path() / *value;
    std::error_code ignored;
    if (!std::filesystem::is_regular_file(path, ignored))
        expect(key, *node, "a file; there is none at " + path.string());
    return path;
}

std::vector<std::filesystem::path> TomlTable::files(const std::string& key) {
    const toml::node* node = find(key);
    if (!node) return {};
    std::vector<std::filesystem::path> paths;
    const toml::array* list = node->as_array();
    if (!list || list->empty()) {
        expect(key, *node, "a list of files");
        return {};
    }
    for (const toml::node& item : *list) {
        const std::filesystem::path path = report_.file.parent_path() / item.value<std::string>().value_or("");
        std::error_code ignored;
        if (!item.is_string() || !std::filesystem::is_regular_file(path, ignored))
            expect(key, item, "a file; there is none at " + path.string());
        paths.push_back(path);
    }
    return paths;
}

std::vector<double> TomlTable::numbers(const std::string& key, std::size_t least, std::size_t most, double low,
                                       double high) {
    const toml::node* node = find(key);
    if (!node) return {};
    const std::string count = least == most ? fmt::format("{}", least) : fmt::format("{} to {}", least, most);
    const std::string expected = fmt::format("{} numbers in [{:g}, {:g}]", count, low, high);
    const toml::array* list = node->as_array();
    if (!list || list->size() < least || list->size() > most) {
        expect(key, *node, expected);
        return {};
    }
    std::vector<double> values;
    for (const toml::node& item : *list) {
        const std::optional<double> value = item.is_number() ? item.value<double>() : std::nullopt;
        if (!in_range(value, low, high)) {
            expect(key, *node, expected);
            return {};
        }
        values.push_back(*value);
    }
    return values;
}

std::vector<std::vector<double>> TomlTable::points(const std::string& key, std::size_t least, std::size_t most) {
    const toml::node* node = find(key);
    if (!node) return {};
    const std::string expected = fmt::format("a list of points of {} to {} numbers", least, most);
    std::vector<std::vector<double>> out;
    const toml::array* list = node->as_array();
    if (!list) {
        expect(key, *node, expected);
        return {};
    }
    for (const toml::node& item : *list) {
        const toml::array* point = item.as_array();
        std::vector<double> values;
        if (point)
            for (const toml::node& v : *point) {
                const std::optional<double> value = v.is_number() ? v.value<double>() : std::nullopt;
                if (in_range(value, -1e7, 1e7)) values.push_back(*value);
            }
        if (!point || values.size() != point->size() || values.size() < least || values.size() > most) {
            expect(key, item, expected);
            return {};
        }
        out.push_back(std::move(values));
    }
    return out;
}

const toml::table* TomlTable::table(const std::string& key) {
    const toml::node* node = find(key);
    if (!node) return nullptr;
    if (!node->is_table()) expect(key, *node, fmt::format("a table, [{}]", key));
    return node->as_table();
}

std::vector<const toml::table*> TomlTable::tables(const std::string& key) {
    const toml::node* node = find(key);
    if (!node) return {};
    std::vector<const toml::table*> out;
    if (const toml::array* list = node->as_array())
        for (const toml::node& item : *list)
            if (item.is_table()) out.push_back(item.as_table());
    if (out.empty()) expect(key, *node, fmt::format("tables, [[{}]]", key));
    return out;
}

void TomlTable::finish() {
    for (const auto& [key, node] : table_) {
        const std::string name(key.str());
        if (std::find(known_.begin(), known_.end(), name) != known_.end()) continue;
        const auto nearest = std::min_element(known_.begin(), known_.end(), [&](const auto& a, const auto& b) {
            return edit_distance(name, a) < edit_distance(name, b);
        });
        report_.fail(key.source(),
                     fmt::format("{} {}: unknown key; the nearest known one is {}", name_, name, *nearest));
        return;
    }
}

}  // namespace ff::cook
