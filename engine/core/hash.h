#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

namespace ff {

/// xxHash3, 64 bits, over bytes. The same on every machine.
[[nodiscard]] std::uint64_t hash_bytes(std::span<const std::byte> bytes, std::uint64_t seed = 0);

/// 128-bit content hash as 32 hex digits: names entries of the cook cache.
[[nodiscard]] std::string content_hash_hex(std::span<const std::byte> bytes);

}  // namespace ff
