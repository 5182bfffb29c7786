#include "engine/gl/shader_folder.h"

#include <fmt/format.h>

#include <set>

#include "engine/core/write_file.h"
#include "engine/gl/shader_sources.h"

namespace ff::gl {
namespace {

std::filesystem::path& shader_folder() {
    static std::filesystem::path folder;
    return folder;
}

/// What engine/gl/embed_shaders.cmake does at build time: each include once in a program's text.
Result<std::string> resolve(const std::filesystem::path& path, std::set<std::string>& seen) {
    seen.insert(path.filename().string());
    FF_ASSIGN(const std::string text, read_text_file(path));
    constexpr std::string_view kInclude = "#include \"";
    std::string out;
    for (std::size_t at = 0; at < text.size();) {
        const std::size_t end = std::min(text.find('\n', at), text.size());
        const std::string_view line = std::string_view(text).substr(at, end - at);
        at = end + 1;
        if (!line.starts_with(kInclude)) {
            out.append(line).append("\n");
            continue;
        }
        const std::string included(line.substr(kInclude.size(), line.rfind('"') - kInclude.size()));
        if (seen.contains(included)) continue;
        FF_ASSIGN(const std::string inner, resolve(path.parent_path() / included, seen));
        out += fmt::format("// begin {0}\n{1}// end {0}\n", included, inner);
    }
    return out;
}

}  // namespace

void use_shader_folder(const std::filesystem::path& folder) {
    shader_folder() = folder;
}

Result<std::string> shader_text(std::string_view name) {
    const std::filesystem::path path = shader_folder() / name;
    std::error_code ignored;
    if (shader_folder().empty() || !std::filesystem::exists(path, ignored)) return std::string(shader_source(name));
    std::set<std::string> seen;
    return resolve(path, seen);
}

}  // namespace ff::gl
