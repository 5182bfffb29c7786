#pragma once

#include <string_view>

#include "engine/core/result.h"
#include "engine/gl/object.h"

namespace ff::gl {

namespace detail {
void delete_program(GLuint id);
}

/// A linked vertex and fragment shader, with a geometry shader between them where one is named.
class Program {
  public:
    Program() = default;
    /// Compiles and links shaders by their names: embedded, or of use_shader_folder().
    /// @param vertex, fragment  names in engine/shaders
    /// @param geometry          likewise; empty: none
    /// @param defines           lines put after #version, e.g. "#define ALPHA_MASK\n"
    /// Errors: no such shader; the compiler's words, each with the source lines that they point at.
    static Result<Program> make(std::string_view vertex, std::string_view fragment, std::string_view defines = {},
                                std::string_view geometry = {});

    /// The same from texts; the names are for messages.
    struct Stage {
        std::string_view name, text;
    };
    static Result<Program> compile(Stage vertex, Stage fragment, std::string_view defines = {}, Stage geometry = {});

    [[nodiscard]] GLuint id() const { return object_.id(); }
    /// Location of a uniform; -1 (which GL ignores) where the program does not use it.
    [[nodiscard]] GLint uniform(const char* name) const { return glGetUniformLocation(id(), name); }

  private:
    Object<detail::delete_program> object_;
};

}  // namespace ff::gl
