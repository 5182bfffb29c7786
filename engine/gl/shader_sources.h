#pragma once

#include <string_view>

namespace ff::gl {

/// The text of engine/shaders/NAME as it was when the program was built, #includes resolved; empty if there is none.
[[nodiscard]] std::string_view shader_source(std::string_view name);

}  // namespace ff::gl
