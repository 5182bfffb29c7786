#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "engine/core/result.h"
#include "engine/gl/object.h"

namespace ff::gl {

namespace detail {
void delete_buffer(GLuint id);
}

/// Memory of the GPU, of a fixed size.
class Buffer {
  public:
    Buffer() = default;
    /// Uninitialised; written by write(). Errors: the driver has no such amount of memory.
    static Result<Buffer> make(std::uint64_t bytes);

    /// Copies into [offset, offset + bytes.size()).
    void write(std::uint64_t offset, std::span<const std::byte> bytes);
    [[nodiscard]] GLuint id() const { return object_.id(); }
    [[nodiscard]] std::uint64_t size_bytes() const { return bytes_; }

  private:
    Object<detail::delete_buffer> object_;
    std::uint64_t bytes_ = 0;
};

/// Data that is new every frame. Three persistently mapped segments take turns, so that the CPU writes one while the
/// GPU still reads the last two; a fence guards each. Grows (by a new buffer) when a frame asks for more.
class StreamBuffer {
  public:
    StreamBuffer() = default;
    StreamBuffer(StreamBuffer&&) noexcept;
    StreamBuffer& operator=(StreamBuffer&&) noexcept;
    ~StreamBuffer();

    /// The next segment, at least `bytes` long, to be written by the caller before the draw that reads it. Waits if the
    /// GPU is more than two frames behind.
    std::span<std::byte> begin(std::uint64_t bytes);
    /// After the last draw that reads the segment.
    void end();

    [[nodiscard]] GLuint id() const { return object_.id(); }
    /// Where the current segment starts in the buffer; a multiple of 256.
    [[nodiscard]] std::uint64_t offset() const { return std::uint64_t(segment_) * segment_bytes_; }

  private:
    void wait(GLsync& fence);

    Object<detail::delete_buffer> object_;
    std::byte* mapped_ = nullptr;
    std::uint64_t segment_bytes_ = 0;
    int segment_ = 0;
    std::array<GLsync, 3> fences_{};
};

}  // namespace ff::gl
