#pragma once
// Arrays to the bytes of a cache entry and back. Entries are verified by their hash before they are read: what comes
// out is what went in, so reading only checks what keeps it within the bytes.

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "engine/core/check.h"

namespace ff::cook {

class ByteWriter {
  public:
    template <class T>
    requires std::is_trivially_copyable_v<T>
    void value(const T& v) { append(std::as_bytes(std::span(&v, 1))); }
    template <class T>
    requires std::is_trivially_copyable_v<T>
    void array(const std::vector<T>& values) {
        value(std::uint64_t{values.size()});
        append(std::as_bytes(std::span(values)));
    }
    void text(const std::string& text) {
        value(std::uint64_t{text.size()});
        append(std::as_bytes(std::span(text)));
    }
    void reserve(std::size_t bytes) { bytes_.reserve(bytes); }
    [[nodiscard]] const std::vector<std::byte>& bytes() const { return bytes_; }
    [[nodiscard]] std::vector<std::byte> take() { return std::move(bytes_); }

  private:
    void append(std::span<const std::byte> bytes) { bytes_.insert(bytes_.end(), bytes.begin(), bytes.end()); }
    std::vector<std::byte> bytes_;
};

class ByteReader {
  public:
    /// @param bytes  written by a ByteWriter; must outlive the reader
    explicit ByteReader(std::span<const std::byte> bytes) : rest_(bytes) {}

    template <class T>
    requires std::is_trivially_copyable_v<T>
    void value(T& v) { take(&v, 1); }
    template <class T>
    requires std::is_trivially_copyable_v<T>
    void array(std::vector<T>& values) {
        values.resize(count_of(sizeof(T)));
        take(values.data(), values.size());
    }
    void text(std::string& text) {
        text.resize(count_of(1));
        take(text.data(), text.size());
    }

  private:
    std::size_t count_of(std::size_t element_bytes) {
        std::uint64_t count = 0;
        value(count);
        FF_CHECK(count <= rest_.size() / element_bytes, "{} elements in {} bytes", count, rest_.size());
        return count;
    }
    template <class T>
    void take(T* to, std::size_t count) {
        FF_CHECK(count * sizeof(T) <= rest_.size(), "{} of {} bytes", count * sizeof(T), rest_.size());
        if (count > 0) std::memcpy(static_cast<void*>(to), rest_.data(), count * sizeof(T));
        rest_ = rest_.subspan(count * sizeof(T));
    }
    std::span<const std::byte> rest_;
};

}  // namespace ff::cook
