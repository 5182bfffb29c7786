#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <utility>

#include "engine/core/log.h"
#include "engine/core/program_files.h"
#include "engine/core/write_file.h"
#include "tools/ff/commands.h"

namespace ff::tool {
namespace {

namespace fs = std::filesystem;

bool is_letter_or_digit(char c) {
    return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9');
}

/// What Debian allows as a package's name, and CMake as a target's.
bool is_name(const std::string& name) {
    return name.size() >= 2 && name.size() <= 60 && name[0] >= 'a' && name[0] <= 'z' && name.back() != '-' &&
           std::all_of(name.begin(), name.end(), [](char c) { return is_letter_or_digit(c) || c == '-'; });
}

/// "Lost Harbour" and "lost_harbour" become "lost-harbour".
std::string name_after(const fs::path& folder) {
    std::string name = fs::absolute(folder).lexically_normal().filename().string();
    if (name.empty()) name = fs::absolute(folder).lexically_normal().parent_path().filename().string();
    for (char& c : name) {
        c = char(std::tolower(static_cast<unsigned char>(c)));
        if (!is_letter_or_digit(c)) c = '-';
    }
    return name;
}

/// "lost-harbour" becomes "Lost Harbour".
std::string title_of(std::string name) {
    bool begins = true;
    for (char& c : name) {
        if (c == '-') c = ' ';
        if (begins) c = char(std::toupper(static_cast<unsigned char>(c)));
        begins = c == ' ';
    }
    return name;
}

void replace_all(std::string& text, const std::string& what, const std::string& by) {
    for (std::size_t at = text.find(what); at != std::string::npos; at = text.find(what, at + by.size()))
        text.replace(at, what.size(), by);
}

bool is_text(const fs::path& path) {
    constexpr std::array<std::string_view, 2> kBinary{".glb", ".png"};
    return std::find(kBinary.begin(), kBinary.end(), path.extension().string()) == kBinary.end();
}

/// Copies the template, with the game's own names in its texts.
Status fill(const fs::path& source, const fs::path& target, const std::string& name) {
    const std::array<std::pair<std::string, std::string>, 2> words{{{"@NAME@", name}, {"@TITLE@", title_of(name)}}};
    for (const fs::directory_entry& entry : fs::recursive_directory_iterator(source)) {
        const fs::path to = target / fs::relative(entry.path(), source);
        if (entry.is_directory()) {
            fs::create_directories(to);
        } else if (is_text(entry.path())) {
            FF_ASSIGN(std::string text, read_text_file(entry.path()));
            for (const auto& [word, by] : words) replace_all(text, word, by);
            fs::create_directories(to.parent_path());
            FF_TRY(write_file_whole(to, text));
        } else {
            fs::create_directories(to.parent_path());
            fs::copy_file(entry.path(), to);
        }
    }
    return {};
}

/// Beside the folder first, so that it appears whole or not at all.
Status make(const fs::path& source, const fs::path& folder, const std::string& name) {
    const fs::path part = folder.string() + fmt::format(".{}.part", getpid());
    fs::create_directories(part);
    if (Status filled = fill(source, part, name); !filled) {
        fs::remove_all(part);
        return filled;
    }
    fs::rename(part, folder);
    return {};
}

}  // namespace

Status run_new(const NewOptions& options) {
    try {
        const fs::path folder = fs::absolute(options.folder / "").parent_path().lexically_normal();
        if (fs::exists(folder) && !(fs::is_directory(folder) && fs::is_empty(folder)))
            return usage_error(
                fmt::format("{}: is there already, and not empty; nothing was changed", folder.string()));
        const std::string name = options.name.empty() ? name_after(folder) : options.name;
        if (!is_name(name))
            return usage_error(
                fmt::format("'{}' cannot name a game: expected 2 to 60 lower-case letters, digits and dashes, a letter "
                            "first, as --name lost-harbour",
                            name));
        FF_ASSIGN(const fs::path shared, shared_files());
        const fs::path source = shared / "farfield" / "template";
        if (!fs::is_directory(source))
            return failure(fmt::format("{}: the template is not there; is ff installed whole?", source.string()));
        FF_TRY(make(source, folder, name));
        log_info("{}: the game {}; its README.md says how to build, play, test and pack it", folder.string(), name);
        return {};
    } catch (const fs::filesystem_error& error) {
        return failure(error.what());
    }
}

}  // namespace ff::tool
