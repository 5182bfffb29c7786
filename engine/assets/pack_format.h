#pragma once
// The bytes of a pack (`*.ffpack`), little-endian:
//
//   0        PackHeader                                           64 bytes
//   64       blocks of all chunks, in the table's order           each starts at a multiple of 64
//   ...      the table (FlatBuffers, pack.fbs)                    starts at a multiple of 64, ends the file
//
// Gaps are zero and shorter than 64 bytes, so every byte of the file is either hashed or known. A chunk is an array
// of equal elements, cut into blocks of kBlockBytes (the last is shorter); each block is stored as it is or
// compressed by zstd, whichever reads faster.

#include <cstddef>
#include <cstdint>

namespace ff::assets {

/// Grows whenever the meaning of any byte changes, here or in the scene's chunks. Packs are cooked again, not
/// converted.
inline constexpr std::uint32_t kPackVersion = 1;
inline constexpr char kPackMagic[8] = {'F', 'F', 'P', 'A', 'C', 'K', '\r', '\n'};
inline constexpr std::size_t kPackAlignment = 64;
/// Small enough that a block stays in the cache between hash and decompression, large enough that zstd finds matches.
inline constexpr std::size_t kBlockBytes = std::size_t(1) << 20;
/// Limits that nothing real comes near; counts beyond them are refused before anything is allocated.
inline constexpr std::uint64_t kMaxRawBytes = std::uint64_t(1) << 36;  ///< of all chunks, 64 GiB
inline constexpr std::uint64_t kMaxTableBytes = std::uint64_t(1) << 26;

struct PackHeader {
    char magic[8];
    std::uint32_t version;
    std::uint32_t header_bytes;  ///< sizeof(PackHeader)
    std::uint64_t file_bytes;
    std::uint64_t table_offset;
    std::uint64_t table_bytes;
    std::uint64_t table_hash;   ///< xxHash3 of the table
    std::uint64_t reserved;     ///< 0
    std::uint64_t header_hash;  ///< xxHash3 of the 56 bytes before it
};
static_assert(sizeof(PackHeader) == 64);

}  // namespace ff::assets
