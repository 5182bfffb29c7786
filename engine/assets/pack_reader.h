#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "engine/assets/mapped_file.h"
#include "engine/core/result.h"

namespace ff::assets {

/// Reads a pack. open() checks header, table and every gap; read() checks and decompresses the blocks. Together they
/// look at every byte of the file: what differs in one bit from what the writer wrote is an Error of kind bad_input
/// that says file, offset, what was found, what was expected and what to do.
class PackReader {
  public:
    struct Chunk {
        std::string name;
        std::uint32_t element_bytes = 0;
        std::uint64_t element_count = 0;
        std::uint64_t stored_bytes = 0;
        std::uint64_t offset = 0;  ///< of its first block, or where it would lie; for messages
        [[nodiscard]] std::uint64_t raw_bytes() const { return element_count * element_bytes; }

      private:
        friend class PackReader;
        std::size_t first_block = 0, block_count = 0;
    };

    /// Where read() puts a chunk.
    struct Target {
        std::string_view name;
        std::span<std::byte> out;  ///< exactly the chunk's raw_bytes()
    };

    static Result<PackReader> open(const std::filesystem::path& path);
    /// The same on bytes in memory, which must outlive the reader; `name` stands for the file in messages.
    static Result<PackReader> from_bytes(std::string name, std::span<const std::byte> bytes);

    /// In the file's order.
    [[nodiscard]] std::span<const Chunk> chunks() const { return chunks_; }
    [[nodiscard]] const Chunk* find(std::string_view name) const;
    [[nodiscard]] std::uint64_t file_bytes() const { return bytes_.size(); }
    [[nodiscard]] const std::string& file_name() const { return name_; }
    /// Names the contents: packs that differ anywhere have different ones.
    [[nodiscard]] std::uint64_t content_hash() const { return content_hash_; }

    /// Fills all targets, blocks in parallel; a chunk that is not there or of another size is our own mistake (ask
    /// find() first). On an error the targets' contents are unspecified; of several bad blocks the first is named.
    Status read(std::span<const Target> targets) const;

    /// An error at a chunk's place in the file: `FILE@OFFSET (chunk NAME): <what>; cook the world again`.
    [[nodiscard]] Error error_in(const Chunk& chunk, std::string_view what) const;

  private:
    struct Block {
        std::uint64_t offset = 0, hash = 0;
        std::uint32_t stored_bytes = 0, raw_bytes = 0;
    };

    PackReader() = default;
    Status read_header_and_table();
    Status add_chunk(const void* disk_chunk, std::uint64_t& end, std::uint64_t& raw_total);
    Status check_gap(std::uint64_t begin, std::uint64_t end) const;
    Status read_block(const Block& block, std::span<std::byte> out) const;
    [[nodiscard]] Error error_at(std::uint64_t offset, std::string_view what) const;

    std::string name_;
    std::uint64_t content_hash_ = 0;
    MappedFile file_;
    std::span<const std::byte> bytes_;
    std::vector<Chunk> chunks_;
    std::vector<Block> blocks_;
};

}  // namespace ff::assets
