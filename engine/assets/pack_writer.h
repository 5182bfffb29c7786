#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string_view>
#include <type_traits>

#include "engine/core/result.h"

namespace ff::assets {

enum class Compression : std::uint8_t {
    zstd,  ///< blocks that shrink too little to pay for their decompression are stored as they are
    none,  ///< every block stored as it is: what the fuzzers start from
};

/// Writes a pack chunk by chunk, whole or not at all: into a neighbour of `path`, which finish() renames. Holds no
/// chunk longer than its add() lasts. The bytes depend on the chunks alone, not on the number of workers.
class PackWriter {
  public:
    static Result<PackWriter> create(const std::filesystem::path& path, Compression compression = Compression::zstd);
    PackWriter(PackWriter&&) noexcept;
    PackWriter& operator=(PackWriter&&) noexcept;
    /// What was not finished leaves no trace.
    ~PackWriter();

    /// Appends an array. Names are unique; the elements' bytes are written as they lie in memory, so they must have
    /// no padding and no pointers.
    Status add(std::string_view name, std::size_t element_bytes, std::span<const std::byte> elements);
    template <class T>
    Status add(std::string_view name, std::span<const T> elements) {
        static_assert(std::is_trivially_copyable_v<T>);
        return add(name, sizeof(T), std::as_bytes(elements));
    }

    /// Writes table and header, syncs, renames. Returns the size of the file, bytes.
    Result<std::uint64_t> finish();

  private:
    struct State;
    explicit PackWriter(std::unique_ptr<State> state);
    std::unique_ptr<State> state_;
};

}  // namespace ff::assets
