#include "engine/budget/budget_file.h"

#include <fmt/format.h>

#include <toml++/toml.h>
#include <algorithm>
#include <cmath>

namespace ff::budget {
namespace {

constexpr double kMostMs = 1e6, kMostWork = 1e15;

std::string list_of(std::span<const std::string_view> names) {
    std::string text;
    for (const std::string_view name : names) text += fmt::format("{}{}", text.empty() ? "" : ", ", name);
    return text;
}

bool contains(std::span<const std::string_view> names, std::string_view name) {
    return std::find(names.begin(), names.end(), name) != names.end();
}

/// Reads the tables and remembers the first thing that is wrong.
class BudgetReader {
  public:
    BudgetReader(const std::string& file, const Names& names) : file_(file), names_(names) {}

    void read(const toml::table& root) {
        constexpr std::string_view kKeys[] = {"format", "calibration_ms", "time", "passes", "effects", "work"};
        bool has_format = false;
        for (const auto& [key, node] : in_order(root)) {
            if (key == "format") {
                has_format = true;
                if (node->value<std::int64_t>() != 1) fail(*node, "format: expected 1, which this build reads");
            } else if (key == "calibration_ms") {
                budget_.calibration_ms = number(key, *node, 1e-6, kMostMs);
            } else if (key == "time") {
                limits(key, *node, LimitKind::time, kTimeKeys, kMostMs);
            } else if (key == "work") {
                limits(key, *node, LimitKind::work, kWorkKeys, kMostWork);
            } else if (key == "passes") {
                tables(key, *node, LimitKind::pass, names_.passes);
            } else if (key == "effects") {
                tables(key, *node, LimitKind::effect, names_.effects);
            } else {
                fail(*node, fmt::format("'{}' is unknown; expected {}", key, list_of(kKeys)));
            }
        }
        if (!has_format) fail_at(1, "no 'format'; expected format = 1");
        if (budget_.limits.empty())
            fail_at(1, "nothing is limited; expected [time], [passes.NAME], [effects.NAME] or [work]");
    }
    Result<Budget> result() && {
        if (error_) return *error_;
        return std::move(budget_);
    }

  private:
    using Entry = std::pair<std::string_view, const toml::node*>;

    /// Keys as the file orders them: toml++ sorts them by name.
    static std::vector<Entry> in_order(const toml::table& table) {
        std::vector<Entry> entries;
        for (const auto& [key, node] : table) entries.emplace_back(key.str(), &node);
        std::stable_sort(entries.begin(), entries.end(), [](const Entry& a, const Entry& b) {
            const auto &x = a.second->source().begin, &y = b.second->source().begin;
            return x.line != y.line ? x.line < y.line : x.column < y.column;
        });
        return entries;
    }

    double number(std::string_view name, const toml::node& node, double low, double high) {
        const auto value = node.value<double>();
        if (value && *value >= low && *value <= high) return *value;
        fail(node, fmt::format("{}: expected a number from {} to {}", name, low, high));
        return 0.0;
    }
    void limit(const std::string& name, std::string key, const toml::node& node, LimitKind kind, double most) {
        const double value = number(name, node, 0.0, most);
        budget_.limits.push_back(
            {.kind = kind, .key = std::move(key), .value = value, .line = int(node.source().begin.line)});
    }
    void limits(std::string_view name, const toml::node& node, LimitKind kind, std::span<const std::string_view> known,
                double most) {
        const toml::table* table = node.as_table();
        if (table == nullptr) return fail(node, fmt::format("{}: expected a table, [{}]", name, name));
        for (const auto& [key, value] : in_order(*table)) {
            if (contains(known, key))
                limit(fmt::format("{}.{}", name, key), std::string(key), *value, kind, most);
            else
                fail(*value, fmt::format("[{}]: '{}' is unknown; expected {}", name, key, list_of(known)));
        }
    }
    void tables(std::string_view name, const toml::node& node, LimitKind kind,
                std::span<const std::string_view> known) {
        const toml::table* table = node.as_table();
        if (table == nullptr) return fail(node, fmt::format("{}: expected tables, [{}.NAME]", name, name));
        for (const auto& [key, value] : in_order(*table)) {
            const toml::table* one = value->as_table();
            if (!contains(known, key))
                fail(*value, fmt::format("[{}]: '{}' is unknown; expected {}", name, key, list_of(known)));
            else if (one == nullptr || one->empty())
                fail(*value, fmt::format("{0}.{1}: expected [{0}.{1}] with ms = NUMBER", name, key));
            else
                for (const auto& [inner, number_node] : in_order(*one)) {
                    if (inner == "ms")
                        limit(fmt::format("{}.{}.ms", name, key), std::string(key), *number_node, kind, kMostMs);
                    else
                        fail(*number_node, fmt::format("[{}.{}]: '{}' is unknown; expected ms", name, key, inner));
                }
        }
    }
    void fail(const toml::node& node, const std::string& what) { fail_at(int(node.source().begin.line), what); }
    void fail_at(int line, const std::string& what) {
        if (!error_) error_ = bad_input(fmt::format("{}:{}: {}", file_, line, what));
    }

    std::string file_;
    Names names_;
    Budget budget_;
    std::optional<Error> error_;
};

}  // namespace

std::string Limit::name() const {
    switch (kind) {
        case LimitKind::time:
            return "time." + key;
        case LimitKind::pass:
            return "passes." + key + ".ms";
        case LimitKind::effect:
            return "effects." + key + ".ms";
        case LimitKind::work:
            break;
    }
    return "work." + key;
}

Result<Budget> parse_budget(std::string_view text, const std::string& file, const Names& names) {
    toml::table root;
    try {
        root = toml::parse(text, file);
    } catch (const toml::parse_error& error) {
        return bad_input(fmt::format("{}:{}: not TOML: {}", file, error.source().begin.line, error.description()));
    }
    BudgetReader reader(file, names);
    reader.read(root);
    return std::move(reader).result();
}

std::string to_text(const Budget& budget, std::string_view comment) {
    std::string text = comment.empty() ? std::string() : fmt::format("# {}\n", comment);
    text += "format = 1\n";
    if (budget.calibration_ms) text += fmt::format("calibration_ms = {}\n", *budget.calibration_ms);
    const auto write = [&](LimitKind kind, std::string_view table) {
        bool has_head = false;
        for (const Limit& limit : budget.limits) {
            if (limit.kind != kind) continue;
            if (!has_head) text += fmt::format("\n[{}]\n", table);
            has_head = true;
            text += fmt::format("{} = {}\n", limit.key + (table == "passes" || table == "effects" ? ".ms" : ""),
                                limit.value);
        }
    };
    write(LimitKind::time, "time");
    write(LimitKind::pass, "passes");
    write(LimitKind::effect, "effects");
    write(LimitKind::work, "work");
    return text;
}

}  // namespace ff::budget
