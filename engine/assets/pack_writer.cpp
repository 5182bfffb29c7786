#include "engine/assets/pack_writer.h"

#include <fmt/format.h>
#include <zstd.h>

#include <algorithm>
#include <bit>
#include <cstring>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "engine/assets/pack_format.h"
#include "engine/assets/pack_generated.h"
#include "engine/core/check.h"
#include "engine/core/hash.h"
#include "engine/core/jobs.h"
#include "engine/core/whole_file.h"

namespace ff::assets {
namespace {

static_assert(std::endian::native == std::endian::little, "packs are little-endian and are read in place");

/// The lowest level that still looks for matches: a tenth larger than level 1, a third faster to read where it counts
/// (packed floats); higher levels gain nothing (tests/bench/bench_pack).
constexpr int kZstdLevel = -1;

/// A block must shrink by a quarter to be worth decompressing.
constexpr std::size_t largest_worth_keeping(std::size_t raw_bytes) {
    return raw_bytes - raw_bytes / 4 - 1;
}

struct WrittenChunk {
    std::string name;
    std::uint32_t element_bytes = 0;
    std::uint64_t element_count = 0;
    std::vector<disk::Block> blocks;
};

}  // namespace

struct PackWriter::State {
    std::filesystem::path path;
    Compression compression = Compression::zstd;
    WholeFile file;
    std::uint64_t position = 0;
    std::uint64_t raw_bytes = 0;
    std::vector<WrittenChunk> chunks;

    State(const std::filesystem::path& pack, WholeFile whole_file) : path(pack), file(std::move(whole_file)) {}

    Status write(std::span<const std::byte> bytes) {
        FF_TRY(file.write(bytes));
        position += bytes.size();
        return {};
    }

    Status align() {
        constexpr std::byte kZeros[kPackAlignment]{};
        return write(std::span(kZeros, (kPackAlignment - position % kPackAlignment) % kPackAlignment));
    }
};

PackWriter::PackWriter(std::unique_ptr<State> state) : state_(std::move(state)) {}
PackWriter::PackWriter(PackWriter&&) noexcept = default;
PackWriter& PackWriter::operator=(PackWriter&&) noexcept = default;
PackWriter::~PackWriter() = default;

Result<PackWriter> PackWriter::create(const std::filesystem::path& path, Compression compression) {
    FF_ASSIGN(WholeFile file, WholeFile::create(path));
    auto state = std::make_unique<State>(path, std::move(file));
    state->compression = compression;
    const PackHeader empty{};  // until finish() the file is no pack
    FF_TRY(state->write(std::as_bytes(std::span(&empty, 1))));
    return PackWriter(std::move(state));
}

Status PackWriter::add(std::string_view name, std::size_t element_bytes, std::span<const std::byte> elements) {
    State& state = *state_;
    FF_CHECK(element_bytes > 0 && elements.size() % element_bytes == 0, "chunk {}: {} bytes are no array of {}", name,
             elements.size(), element_bytes);
    FF_CHECK(std::none_of(state.chunks.begin(), state.chunks.end(), [&](const auto& c) { return c.name == name; }),
             "chunk {} added twice", name);
    state.raw_bytes += elements.size();
    if (state.raw_bytes > kMaxRawBytes)
        return Error{ErrorKind::limit,
                     fmt::format("{}: the world has over {} bytes at chunk {}; a pack holds at most {}",
                                 state.path.string(), state.raw_bytes, name, kMaxRawBytes)};

    // A batch of blocks is compressed in parallel, then written in order: memory stays small, the bytes do not depend
    // on the number of workers.
    struct Packed {
        std::vector<std::byte> buffer;
        std::span<const std::byte> stored;
        std::uint64_t hash = 0;
    };
    const std::size_t block_count = (elements.size() + kBlockBytes - 1) / kBlockBytes;
    std::vector<Packed> batch(std::min<std::size_t>(block_count, static_cast<std::size_t>(worker_count()) * 8));
    WrittenChunk chunk{
        std::string(name), static_cast<std::uint32_t>(element_bytes), elements.size() / element_bytes, {}};
    chunk.blocks.reserve(block_count);
    const auto raw_block = [&](std::size_t block) {
        return elements.subspan(block * kBlockBytes, std::min(kBlockBytes, elements.size() - block * kBlockBytes));
    };
    for (std::size_t first = 0; first < block_count; first += batch.size()) {
        const std::size_t count = std::min(batch.size(), block_count - first);
        parallel_for(count, [&](std::size_t i) {
            Packed& packed = batch[i];
            const std::span<const std::byte> raw = raw_block(first + i);
            packed.stored = raw;
            if (state.compression == Compression::zstd) {
                packed.buffer.resize(ZSTD_compressBound(raw.size()));
                const std::size_t size =
                    ZSTD_compress(packed.buffer.data(), packed.buffer.size(), raw.data(), raw.size(), kZstdLevel);
                if (!ZSTD_isError(size) && size <= largest_worth_keeping(raw.size()))
                    packed.stored = std::span(packed.buffer).first(size);
            }
            packed.hash = hash_bytes(packed.stored);
        });
        for (std::size_t i = 0; i < count; ++i) {
            FF_TRY(state.align());
            chunk.blocks.emplace_back(state.position, batch[i].hash, static_cast<std::uint32_t>(batch[i].stored.size()),
                                      static_cast<std::uint32_t>(raw_block(first + i).size()));
            FF_TRY(state.write(batch[i].stored));
        }
    }
    state.chunks.push_back(std::move(chunk));
    return {};
}

Result<std::uint64_t> PackWriter::finish() {
    State& state = *state_;
    flatbuffers::FlatBufferBuilder builder;
    std::vector<flatbuffers::Offset<disk::Chunk>> chunks;
    for (const WrittenChunk& chunk : state.chunks) {
        const auto name = builder.CreateString(chunk.name);
        const auto blocks = builder.CreateVectorOfStructs(chunk.blocks);
        chunks.push_back(disk::CreateChunk(builder, name, chunk.element_bytes, chunk.element_count, blocks));
    }
    disk::FinishPackBuffer(builder, disk::CreatePack(builder, builder.CreateVector(chunks)));
    const auto table = std::as_bytes(std::span(builder.GetBufferPointer(), builder.GetSize()));

    FF_TRY(state.align());
    PackHeader header{};
    std::memcpy(header.magic, kPackMagic, sizeof kPackMagic);
    header.version = kPackVersion;
    header.header_bytes = sizeof(PackHeader);
    header.table_offset = state.position;
    header.table_bytes = table.size();
    header.table_hash = hash_bytes(table);
    header.file_bytes = state.position + table.size();
    const auto header_bytes = std::as_bytes(std::span(&header, 1));
    header.header_hash = hash_bytes(header_bytes.first(offsetof(PackHeader, header_hash)));
    FF_TRY(state.write(table));
    FF_TRY(state.file.write_at(0, header_bytes));
    FF_TRY(state.file.commit());
    return state.position;
}

}  // namespace ff::assets
