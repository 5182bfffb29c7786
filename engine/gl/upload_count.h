#pragma once

#include <cstdint>

namespace ff::gl {

/// Bytes handed to OpenGL so far, as buffers and textures.
[[nodiscard]] std::uint64_t uploaded_bytes();

namespace detail {
void count_upload(std::uint64_t bytes);
}

}  // namespace ff::gl
