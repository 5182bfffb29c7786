#pragma once

#include <cstddef>
#include <span>

#include "engine/core/result.h"

namespace ff::assets {

/// Zeroed memory straight from the system. Nothing is touched before it is written, so the threads that fill it share
/// the page faults (with std::vector one thread would clear gigabytes first). Ordinary pages: on virtual machines whose
/// host gives memory only when it is touched, huge pages took up to five times as long to fill for the first time.
class PageBuffer {
  public:
    /// Errors: failure where the system has no such memory. 0 bytes are an empty buffer.
    static Result<PageBuffer> allocate(std::size_t bytes);

    PageBuffer() = default;
    PageBuffer(PageBuffer&& other) noexcept;
    PageBuffer& operator=(PageBuffer&& other) noexcept;
    ~PageBuffer();

    /// Starts at a multiple of the page size.
    [[nodiscard]] std::span<std::byte> bytes() { return bytes_; }
    [[nodiscard]] std::span<const std::byte> bytes() const { return bytes_; }

  private:
    std::span<std::byte> bytes_;
};

}  // namespace ff::assets
