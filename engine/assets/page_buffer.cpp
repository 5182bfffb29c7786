#include "engine/assets/page_buffer.h"

#include <fmt/format.h>
#include <sys/mman.h>

#include <cerrno>
#include <cstring>
#include <utility>

namespace ff::assets {

Result<PageBuffer> PageBuffer::allocate(std::size_t bytes) {
    PageBuffer buffer;
    if (bytes == 0) return buffer;
    void* data = ::mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (data == MAP_FAILED)
        return failure(fmt::format("out of memory: {} bytes asked for: {}", bytes, std::strerror(errno)));
    buffer.bytes_ = {static_cast<std::byte*>(data), bytes};
    return buffer;
}

PageBuffer::PageBuffer(PageBuffer&& other) noexcept : bytes_(std::exchange(other.bytes_, {})) {}

PageBuffer& PageBuffer::operator=(PageBuffer&& other) noexcept {
    std::swap(bytes_, other.bytes_);
    return *this;
}

PageBuffer::~PageBuffer() {
    if (!bytes_.empty()) ::munmap(bytes_.data(), bytes_.size());
}

}  // namespace ff::assets
