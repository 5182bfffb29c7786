#pragma once
// Reading a TOML table so that the code that reads it is its schema: what nobody asked for is an unknown key.

#include <toml++/toml.h>
#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "engine/core/result.h"

namespace ff::cook {

/// Where the reading of one file stands: the first error is kept, later ones follow from it.
struct TomlReport {
    std::filesystem::path file;
    std::optional<Error> error;
    void fail(const toml::source_region& place, const std::string& text);
};

/// One table. Getters return what is written, or the default; mistakes go to the report with line and key.
class TomlTable {
  public:
    /// @param name  as the reader knows it: `[terrain]`
    TomlTable(const toml::table& table, std::string name, TomlReport& report)
        : table_(table), name_(std::move(name)), report_(report) {}

    [[nodiscard]] bool has(const std::string& key);
    double number(const std::string& key, double fallback, double low, double high);
    std::optional<double> optional_number(const std::string& key, double low, double high);
    std::int64_t integer(const std::string& key, std::int64_t fallback, std::int64_t low, std::int64_t high);
    bool boolean(const std::string& key, bool fallback);
    std::string text(const std::string& key, const std::string& fallback);
    /// The index of the text in `choices`.
    std::size_t choice(const std::string& key, std::size_t fallback, const std::vector<std::string>& choices);
    /// A file, relative to the scene's folder; empty where absent. Must exist.
    std::filesystem::path file(const std::string& key, bool required = false);
    std::vector<std::filesystem::path> files(const std::string& key);
    /// An array of between `least` and `most` numbers; empty where absent.
    std::vector<double> numbers(const std::string& key, std::size_t least, std::size_t most, double low, double high);
    /// An array of arrays of numbers.
    std::vector<std::vector<double>> points(const std::string& key, std::size_t least, std::size_t most);

    /// A sub-table, nullptr where absent; and an array of tables, empty where absent.
    const toml::table* table(const std::string& key);
    std::vector<const toml::table*> tables(const std::string& key);

    void fail(const std::string& key, const std::string& text);
    /// Call last: names the first key that nothing asked for, and the nearest known one.
    void finish();

  private:
    const toml::node* find(const std::string& key);
    void expect(const std::string& key, const toml::node& node, const std::string& expected);

    const toml::table& table_;
    std::string name_;
    TomlReport& report_;
    std::vector<std::string> known_;
};

}  // namespace ff::cook
