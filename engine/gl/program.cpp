#include "engine/gl/program.h"

#include <fmt/core.h>

#include <algorithm>
#include <charconv>
#include <set>
#include <string>
#include <vector>

#include "engine/gl/shader_folder.h"

namespace ff::gl {

void detail::delete_program(GLuint id) {
    glDeleteProgram(id);
}

namespace {

void delete_shader(GLuint id) {
    glDeleteShader(id);
}
using Shader = Object<delete_shader>;

std::vector<std::string_view> lines_of(std::string_view text) {
    std::vector<std::string_view> lines;
    while (!text.empty()) {
        const std::size_t end = text.find('\n');
        lines.push_back(text.substr(0, end));
        if (end == std::string_view::npos) break;
        text.remove_prefix(end + 1);
    }
    return lines;
}

/// The compiler's log, and after it the source lines that its `0:LINE(` or `0(LINE)` point at: includes have moved
/// them away from where the author knows them.
std::string readable_log(std::string_view name, std::string_view log, std::string_view text) {
    const auto lines = lines_of(text);
    std::set<std::size_t> named;
    for (std::string_view line : lines_of(log)) {
        std::size_t at = line.find_first_of(":(");
        if (at == std::string_view::npos) continue;
        std::size_t number = 0;
        std::from_chars(line.data() + at + 1, line.data() + line.size(), number);
        if (number >= 1 && number <= lines.size()) named.insert(number);
    }
    std::string out = fmt::format("shader {}:\n{}", name, log);
    for (std::size_t number : named) out += fmt::format("\n  {:4}: {}", number, lines[number - 1]);
    return out;
}

Result<Shader> compile_stage(GLenum kind, Program::Stage stage, std::string_view defines) {
    const std::size_t first_line_end = std::min(stage.text.find('\n'), stage.text.size() - 1) + 1;
    if (!stage.text.starts_with("#version"))
        return failure(fmt::format("shader {}: the first line must be #version", stage.name));
    std::string text(stage.text.substr(0, first_line_end));
    text += defines;
    text += stage.text.substr(first_line_end);

    Shader shader(glCreateShader(kind));
    const char* source = text.c_str();
    glShaderSource(shader.id(), 1, &source, nullptr);
    glCompileShader(shader.id());
    GLint good = 0;
    glGetShaderiv(shader.id(), GL_COMPILE_STATUS, &good);
    if (!good) {
        GLint length = 0;
        glGetShaderiv(shader.id(), GL_INFO_LOG_LENGTH, &length);
        std::string log(std::size_t(std::max(length, 1)), '\0');
        glGetShaderInfoLog(shader.id(), length, &length, log.data());
        log.resize(std::size_t(std::max(length, 0)));
        return failure(readable_log(stage.name, log, text));
    }
    return shader;
}

}  // namespace

Result<Program> Program::compile(Stage vertex, Stage fragment, std::string_view defines, Stage geometry) {
    if (vertex.text.empty()) return failure(fmt::format("shader {}: empty", vertex.name));
    if (fragment.text.empty()) return failure(fmt::format("shader {}: empty", fragment.name));
    FF_ASSIGN(const Shader vertex_shader, compile_stage(GL_VERTEX_SHADER, vertex, defines));
    FF_ASSIGN(const Shader fragment_shader, compile_stage(GL_FRAGMENT_SHADER, fragment, defines));
    Shader geometry_shader;
    if (!geometry.name.empty()) {
        if (geometry.text.empty()) return failure(fmt::format("shader {}: empty", geometry.name));
        FF_ASSIGN(geometry_shader, compile_stage(GL_GEOMETRY_SHADER, geometry, defines));
    }
    Program program;
    program.object_ = Object<detail::delete_program>(glCreateProgram());
    glAttachShader(program.id(), vertex_shader.id());
    glAttachShader(program.id(), fragment_shader.id());
    if (geometry_shader.id() != 0) glAttachShader(program.id(), geometry_shader.id());
    glLinkProgram(program.id());
    GLint good = 0;
    glGetProgramiv(program.id(), GL_LINK_STATUS, &good);
    if (!good) {
        GLint length = 0;
        glGetProgramiv(program.id(), GL_INFO_LOG_LENGTH, &length);
        std::string log(std::size_t(std::max(length, 1)), '\0');
        glGetProgramInfoLog(program.id(), length, &length, log.data());
        log.resize(std::size_t(std::max(length, 0)));
        return failure(fmt::format("linking {} with {}:\n{}", vertex.name, fragment.name, log));
    }
    glDetachShader(program.id(), vertex_shader.id());
    glDetachShader(program.id(), fragment_shader.id());
    if (geometry_shader.id() != 0) glDetachShader(program.id(), geometry_shader.id());
    return program;
}

Result<Program> Program::make(std::string_view vertex, std::string_view fragment, std::string_view defines,
                              std::string_view geometry) {
    FF_ASSIGN(const std::string vertex_text, shader_text(vertex));
    FF_ASSIGN(const std::string fragment_text, shader_text(fragment));
    std::string geometry_text;
    if (!geometry.empty()) {
        FF_ASSIGN(geometry_text, shader_text(geometry));
    }
    return compile({vertex, vertex_text}, {fragment, fragment_text}, defines, {geometry, geometry_text});
}

}  // namespace ff::gl
