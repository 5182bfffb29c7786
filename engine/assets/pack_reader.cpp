#include "engine/assets/pack_reader.h"

#include <fmt/format.h>
#include <zstd.h>

#include <algorithm>
#include <cstring>
#include <utility>

#include "engine/assets/aligned_vector.h"
#include "engine/assets/pack_format.h"
#include "engine/assets/pack_generated.h"
#include "engine/core/check.h"
#include "engine/core/hash.h"
#include "engine/core/jobs.h"

namespace ff::assets {
namespace {

constexpr std::size_t kMaxNameLength = 64;
constexpr std::uint32_t kMaxElementBytes = 4096;
/// zstd cannot shrink 128 KiB to less than 4 bytes, so a block that claims more than this is a lie.
constexpr std::uint64_t kMaxShrink = 32768;

}  // namespace

Result<PackReader> PackReader::open(const std::filesystem::path& path) {
    FF_ASSIGN(MappedFile file, MappedFile::open(path));
    PackReader reader;
    reader.name_ = path.string();
    reader.bytes_ = file.bytes();
    reader.file_ = std::move(file);
    FF_TRY(reader.read_header_and_table());
    return reader;
}

Result<PackReader> PackReader::from_bytes(std::string name, std::span<const std::byte> bytes) {
    PackReader reader;
    reader.name_ = std::move(name);
    reader.bytes_ = bytes;
    FF_TRY(reader.read_header_and_table());
    return reader;
}

const PackReader::Chunk* PackReader::find(std::string_view name) const {
    const auto found = std::find_if(chunks_.begin(), chunks_.end(), [&](const Chunk& c) { return c.name == name; });
    return found == chunks_.end() ? nullptr : &*found;
}

Error PackReader::error_at(std::uint64_t offset, std::string_view what) const {
    return bad_input(fmt::format("{}@{}: {}; cook the world again", name_, offset, what));
}

Error PackReader::error_in(const Chunk& chunk, std::string_view what) const {
    return bad_input(fmt::format("{}@{} (chunk {}): {}; cook the world again", name_, chunk.offset, chunk.name, what));
}

Status PackReader::read_header_and_table() {
    PackHeader header;
    // Magic and version come first: an older pack should be called that, not broken.
    if (bytes_.size() < sizeof header)
        return error_at(bytes_.size(), fmt::format("the file ends here; expected a header of {} bytes", sizeof header));
    std::memcpy(&header, bytes_.data(), sizeof header);
    if (std::memcmp(header.magic, kPackMagic, sizeof kPackMagic) != 0)
        return error_at(0, "not a pack; expected a file that begins with FFPACK");
    if (header.version != kPackVersion)
        return error_at(offsetof(PackHeader, version),
                        fmt::format("pack version {}; this program reads version {}", header.version, kPackVersion));
    const std::uint64_t header_hash = hash_bytes(bytes_.first(offsetof(PackHeader, header_hash)));
    if (header.header_hash != header_hash)
        return error_at(
            0, fmt::format("the header is damaged: hash {:016x}; expected {:016x}", header_hash, header.header_hash));
    if (header.header_bytes != sizeof header || header.reserved != 0)
        return error_at(offsetof(PackHeader, header_bytes),
                        fmt::format("header of {} bytes, reserved field {}; expected {} and 0", header.header_bytes,
                                    header.reserved, sizeof header));
    if (header.file_bytes != bytes_.size())
        return error_at(std::min<std::uint64_t>(header.file_bytes, bytes_.size()),
                        fmt::format("the file has {} bytes; expected {}", bytes_.size(), header.file_bytes));
    if (header.table_bytes == 0 || header.table_bytes > kMaxTableBytes ||
        header.table_bytes > bytes_.size() - sizeof header ||
        header.table_offset != bytes_.size() - header.table_bytes || header.table_offset % kPackAlignment != 0)
        return error_at(offsetof(PackHeader, table_offset),
                        fmt::format("a table of {} bytes at {}; expected it to end the file of {} bytes, at a "
                                    "multiple of {}",
                                    header.table_bytes, header.table_offset, bytes_.size(), kPackAlignment));

    // A copy, so that it is aligned wherever the bytes came from. The verifier looks at every offset in it.
    const auto table_bytes = bytes_.subspan(header.table_offset, header.table_bytes);
    content_hash_ = header.table_hash;
    if (const std::uint64_t hash = hash_bytes(table_bytes); hash != header.table_hash)
        return error_at(header.table_offset,
                        fmt::format("the table is damaged: hash {:016x}; expected {:016x}", hash, header.table_hash));
    std::vector<std::uint64_t> table((table_bytes.size() + 7) / 8);
    std::memcpy(table.data(), table_bytes.data(), table_bytes.size());
    const auto* table_data = reinterpret_cast<const std::uint8_t*>(table.data());
    flatbuffers::Verifier verifier(table_data, table_bytes.size());
    if (!disk::VerifyPackBuffer(verifier))
        return error_at(header.table_offset, "the table is malformed; expected a FlatBuffer of pack.fbs");

    std::uint64_t end = sizeof header;
    std::uint64_t raw_total = 0;
    for (const disk::Chunk* chunk : *disk::GetPack(table_data)->chunks()) FF_TRY(add_chunk(chunk, end, raw_total));
    return check_gap(end, header.table_offset);
}

/// Checks one chunk's description against the file and appends it. `end` is where the bytes before it end.
Status PackReader::add_chunk(const void* disk_chunk, std::uint64_t& end, std::uint64_t& raw_total) {
    const auto& source = *static_cast<const disk::Chunk*>(disk_chunk);
    Chunk chunk;
    chunk.name = source.name()->str();
    chunk.element_bytes = source.element_bytes();
    chunk.element_count = source.element_count();
    chunk.offset = end;
    chunk.first_block = blocks_.size();
    chunk.block_count = source.blocks()->size();
    const bool readable =
        std::all_of(chunk.name.begin(), chunk.name.end(), [](char c) { return (c >= 'a' && c <= 'z') || c == '_'; });
    if (chunk.name.empty() || chunk.name.size() > kMaxNameLength || !readable || find(chunk.name))
        return error_at(end, fmt::format("chunk {} has a name of {} bytes that is unreadable or taken; expected a "
                                         "name of its own, of a to z and _",
                                         chunks_.size(), chunk.name.size()));
    if (chunk.element_bytes == 0 || chunk.element_bytes > kMaxElementBytes ||
        chunk.element_count > (kMaxRawBytes - raw_total) / chunk.element_bytes)
        return error_in(chunk, fmt::format("{} elements of {} bytes; a pack holds at most {} bytes in all",
                                           chunk.element_count, chunk.element_bytes, kMaxRawBytes));
    if (!is_aligned(*source.blocks()))
        return error_in(chunk, "its blocks are described at an odd place in the table; expected a multiple of 8");
    const std::uint64_t raw_bytes = chunk.raw_bytes();
    raw_total += raw_bytes;
    if (const std::uint64_t blocks = (raw_bytes + kBlockBytes - 1) / kBlockBytes; blocks != chunk.block_count)
        return error_in(chunk,
                        fmt::format("{} blocks; expected {} for {} bytes", chunk.block_count, blocks, raw_bytes));

    std::uint64_t left = raw_bytes;
    for (const disk::Block* described : *source.blocks()) {
        const Block block{described->offset(), described->hash(), described->stored_bytes(), described->raw_bytes()};
        const std::uint64_t raw = std::min<std::uint64_t>(left, kBlockBytes);
        if (block.raw_bytes != raw || block.stored_bytes == 0 || block.stored_bytes > raw ||
            raw / block.stored_bytes > kMaxShrink)
            return error_in(chunk, fmt::format("a block of {} bytes, stored in {}; expected {} bytes stored in at "
                                               "most as many",
                                               block.raw_bytes, block.stored_bytes, raw));
        if (block.offset % kPackAlignment != 0 || block.offset < end || block.offset - end >= kPackAlignment ||
            block.offset > bytes_.size() || block.stored_bytes > bytes_.size() - block.offset)
            return error_in(chunk, fmt::format("a block at {} of {} bytes; expected it right after {}, in a file of "
                                               "{} bytes",
                                               block.offset, block.stored_bytes, end, bytes_.size()));
        FF_TRY(check_gap(end, block.offset));
        if (blocks_.size() == chunk.first_block) chunk.offset = block.offset;
        blocks_.push_back(block);
        end = block.offset + block.stored_bytes;
        left -= raw;
        chunk.stored_bytes += block.stored_bytes;
    }
    chunks_.push_back(std::move(chunk));
    return {};
}

Status PackReader::check_gap(std::uint64_t begin, std::uint64_t end) const {
    if (begin > end || end - begin >= kPackAlignment)
        return error_at(begin, fmt::format("the next part begins at {}; expected it right after", end));
    for (std::uint64_t i = begin; i < end; ++i)
        if (bytes_[i] != std::byte{0})
            return error_at(
                i, fmt::format("byte {:#04x} between two blocks; expected 0", std::to_integer<unsigned>(bytes_[i])));
    return {};
}

Status PackReader::read_block(const Block& block, std::span<std::byte> out) const {
    const auto stored = bytes_.subspan(block.offset, block.stored_bytes);
    if (const std::uint64_t hash = hash_bytes(stored); hash != block.hash)
        return error_at(block.offset, fmt::format("a block of {} bytes is damaged: hash {:016x}; expected {:016x}",
                                                  block.stored_bytes, hash, block.hash));
    if (block.stored_bytes == block.raw_bytes) {
        std::memcpy(out.data(), stored.data(), stored.size());
        return {};
    }
    const std::size_t size = ZSTD_decompress(out.data(), out.size(), stored.data(), stored.size());
    if (ZSTD_isError(size))
        return error_at(block.offset, fmt::format("a block does not decompress: {}", ZSTD_getErrorName(size)));
    if (size != out.size())
        return error_at(block.offset, fmt::format("a block decompresses to {} bytes; expected {}", size, out.size()));
    return {};
}

Status PackReader::read(std::span<const Target> targets) const {
    // One flat list of blocks, so that small chunks do not leave workers idle.
    struct Task {
        const Block* block;
        std::span<std::byte> out;
    };
    std::vector<Task> tasks;
    for (const Target& target : targets) {
        const Chunk* chunk = find(target.name);
        FF_CHECK(chunk && target.out.size() == chunk->raw_bytes(), "chunk {}: {} bytes to read into", target.name,
                 target.out.size());
        std::size_t done = 0;
        for (std::size_t i = 0; i < chunk->block_count; ++i) {
            const Block& block = blocks_[chunk->first_block + i];
            tasks.push_back({&block, target.out.subspan(done, block.raw_bytes)});
            done += block.raw_bytes;
        }
    }
    std::vector<Status> statuses(tasks.size());
    parallel_for(tasks.size(), [&](std::size_t i) { statuses[i] = read_block(*tasks[i].block, tasks[i].out); });
    for (const Status& status : statuses) FF_TRY(status);
    return {};
}

}  // namespace ff::assets
