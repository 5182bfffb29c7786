#pragma once
// Numbers as bytes, little-endian, for formats that are written by hand; what is read may be anything.

#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

namespace ff {

/// Appends to bytes that somebody else keeps.
class ByteWriter {
  public:
    explicit ByteWriter(std::vector<std::byte>& bytes) : bytes_(bytes) {}

    void byte(std::uint8_t value) { bytes_.push_back(std::byte(value)); }
    /// The lowest `size` bytes.
    void fixed(std::uint64_t value, int size) {
        for (int i = 0; i < size; ++i) byte(std::uint8_t(value >> (8 * i)));
    }
    /// In groups of seven bits, lowest first: small numbers take one byte.
    void grouped(std::uint64_t value) {
        for (; value >= 128; value >>= 7) byte(std::uint8_t(value | 128));
        byte(std::uint8_t(value));
    }
    void raw(std::span<const std::byte> bytes) { bytes_.insert(bytes_.end(), bytes.begin(), bytes.end()); }
    void raw(std::string_view text) { raw(std::as_bytes(std::span(text))); }
    /// A number or enum as its own bytes.
    template <class T>
    void value(T value) {
        static_assert(std::is_arithmetic_v<T> || std::is_enum_v<T>);
        if constexpr (std::is_same_v<T, double>)
            fixed(std::bit_cast<std::uint64_t>(value), 8);
        else if constexpr (std::is_same_v<T, float>)
            fixed(std::bit_cast<std::uint32_t>(value), 4);
        else
            fixed(std::uint64_t(value), int(sizeof(T)));
    }

  private:
    std::vector<std::byte>& bytes_;
};

/// Reads until the bytes end; from then on everything is 0 and ended() is true.
class ByteReader {
  public:
    explicit ByteReader(std::span<const std::byte> bytes) : bytes_(bytes) {}

    [[nodiscard]] std::size_t at() const { return at_; }
    [[nodiscard]] std::size_t left() const { return bytes_.size() - at_; }
    /// More was asked for than there is.
    [[nodiscard]] bool ended() const { return ended_; }

    std::uint8_t byte() {
        if (left() == 0) {
            ended_ = true;
            return 0;
        }
        return std::uint8_t(bytes_[at_++]);
    }
    std::uint64_t fixed(int size) {
        std::uint64_t value = 0;
        for (int i = 0; i < size; ++i) value |= std::uint64_t(byte()) << (8 * i);
        return value;
    }
    std::uint64_t grouped() {
        std::uint64_t value = 0;
        for (int shift = 0; shift < 64; shift += 7) {
            const std::uint8_t group = byte();
            value |= std::uint64_t(group & 127) << shift;
            if (group < 128) break;
        }
        return value;
    }
    /// Empty, and ended, where fewer are left.
    std::span<const std::byte> raw(std::uint64_t size) {
        if (size > left()) {
            ended_ = true;
            return {};
        }
        at_ += std::size_t(size);
        return bytes_.subspan(at_ - std::size_t(size), std::size_t(size));
    }
    std::string text(std::uint64_t size) {
        const auto bytes = raw(size);
        return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
    }
    template <class T>
    void value(T& out) {
        static_assert(std::is_arithmetic_v<T> || std::is_enum_v<T>);
        if constexpr (std::is_same_v<T, double>)
            out = std::bit_cast<double>(fixed(8));
        else if constexpr (std::is_same_v<T, float>)
            out = std::bit_cast<float>(std::uint32_t(fixed(4)));
        else if constexpr (std::is_same_v<T, bool>)
            out = byte() != 0;
        else
            out = T(fixed(int(sizeof(T))));
    }

  private:
    std::span<const std::byte> bytes_;
    std::size_t at_ = 0;
    bool ended_ = false;
};

}  // namespace ff
