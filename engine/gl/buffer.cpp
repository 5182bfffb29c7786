#include "engine/gl/buffer.h"

#include <fmt/core.h>

#include <algorithm>
#include <utility>

#include "engine/core/check.h"
#include "engine/gl/upload_count.h"

namespace ff::gl {

void detail::delete_buffer(GLuint id) {
    glDeleteBuffers(1, &id);
}

namespace {
GLuint create_buffer() {
    GLuint id = 0;
    glCreateBuffers(1, &id);
    return id;
}
}  // namespace

Result<Buffer> Buffer::make(std::uint64_t bytes) {
    Buffer buffer;
    buffer.object_ = Object<detail::delete_buffer>(create_buffer());
    buffer.bytes_ = bytes;
    while (glGetError() != GL_NO_ERROR) {
    }
    // GL has no empty buffers.
    glNamedBufferStorage(buffer.id(), GLsizeiptr(std::max<std::uint64_t>(bytes, 16)), nullptr, GL_DYNAMIC_STORAGE_BIT);
    if (glGetError() != GL_NO_ERROR)
        return failure(fmt::format(
            "the GL driver has no room for a buffer of {} MiB; use a smaller world, or more memory", bytes >> 20));
    return buffer;
}

void Buffer::write(std::uint64_t offset, std::span<const std::byte> bytes) {
    FF_CHECK(offset + bytes.size() <= bytes_, "{} bytes at {} of a buffer of {}", bytes.size(), offset, bytes_);
    detail::count_upload(bytes.size());
    // In pieces: some drivers stage the whole of a call in system memory.
    constexpr std::size_t kPiece = 16u << 20;
    for (std::size_t done = 0; done < bytes.size(); done += kPiece) {
        const std::size_t piece = std::min(kPiece, bytes.size() - done);
        glNamedBufferSubData(id(), GLintptr(offset + done), GLsizeiptr(piece), bytes.data() + done);
    }
}

StreamBuffer::StreamBuffer(StreamBuffer&& other) noexcept {
    *this = std::move(other);
}

StreamBuffer& StreamBuffer::operator=(StreamBuffer&& other) noexcept {
    std::swap(object_, other.object_);
    std::swap(mapped_, other.mapped_);
    std::swap(segment_bytes_, other.segment_bytes_);
    std::swap(segment_, other.segment_);
    std::swap(fences_, other.fences_);
    return *this;
}

StreamBuffer::~StreamBuffer() {
    for (GLsync fence : fences_)
        if (fence) glDeleteSync(fence);
}

void StreamBuffer::wait(GLsync& fence) {
    if (!fence) return;
    constexpr GLuint64 kSecond = 1'000'000'000;
    while (glClientWaitSync(fence, GL_SYNC_FLUSH_COMMANDS_BIT, kSecond) == GL_TIMEOUT_EXPIRED) {
    }
    glDeleteSync(fence);
    fence = nullptr;
}

std::span<std::byte> StreamBuffer::begin(std::uint64_t bytes) {
    detail::count_upload(bytes);
    if (bytes > segment_bytes_ || mapped_ == nullptr) {
        for (GLsync& fence : fences_) wait(fence);
        // Twice what is asked, so that a slowly growing view does not make a buffer every frame.
        segment_bytes_ = (std::max<std::uint64_t>(2 * bytes, 64u << 10) + 255) / 256 * 256;
        object_ = Object<detail::delete_buffer>(create_buffer());
        constexpr GLbitfield kFlags = GL_MAP_WRITE_BIT | GL_MAP_PERSISTENT_BIT | GL_MAP_COHERENT_BIT;
        const auto size = GLsizeiptr(segment_bytes_ * fences_.size());
        glNamedBufferStorage(id(), size, nullptr, kFlags);
        mapped_ = static_cast<std::byte*>(glMapNamedBufferRange(id(), 0, size, kFlags));
        FF_CHECK(mapped_ != nullptr, "the GL driver maps no buffer of {} bytes", size);
        segment_ = 0;
    } else {
        segment_ = (segment_ + 1) % int(fences_.size());
        wait(fences_[segment_]);
    }
    return {mapped_ + offset(), segment_bytes_};
}

void StreamBuffer::end() {
    if (fences_[segment_]) glDeleteSync(fences_[segment_]);
    fences_[segment_] = glFenceSync(GL_SYNC_GPU_COMMANDS_COMPLETE, 0);
}

}  // namespace ff::gl
