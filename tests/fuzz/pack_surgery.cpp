#include "tests/fuzz/pack_surgery.h"

#include <cstring>
#include <span>

#include "engine/assets/aligned_vector.h"
#include "engine/assets/pack_format.h"
#include "engine/assets/pack_generated.h"
#include "engine/core/hash.h"

namespace ff::test {
namespace {

using assets::PackHeader;

void fix_blocks(std::span<std::byte> pack, std::span<std::byte> table) {
    // An aligned copy: FlatBuffers reads numbers in place.
    std::vector<std::uint64_t> copy((table.size() + 7) / 8);
    std::memcpy(copy.data(), table.data(), table.size());
    auto* data = reinterpret_cast<std::uint8_t*>(copy.data());
    flatbuffers::Verifier verifier(data, table.size());
    if (!assets::disk::VerifyPackBuffer(verifier)) return;
    for (const assets::disk::Chunk* chunk : *assets::disk::GetPack(data)->chunks()) {
        if (!assets::is_aligned(*chunk->blocks())) continue;
        for (const assets::disk::Block* block : *chunk->blocks()) {
            if (block->offset() > pack.size() || block->stored_bytes() > pack.size() - block->offset()) continue;
            const assets::disk::Block fixed(block->offset(),
                                            hash_bytes(pack.subspan(block->offset(), block->stored_bytes())),
                                            block->stored_bytes(), block->raw_bytes());
            const auto at = reinterpret_cast<const std::uint8_t*>(block) - data;
            std::memcpy(table.data() + at, &fixed, sizeof fixed);
        }
    }
}

}  // namespace

void fix_hashes(std::vector<std::byte>& pack) {
    PackHeader header;
    if (pack.size() < sizeof header) return;
    std::memcpy(&header, pack.data(), sizeof header);
    std::memcpy(header.magic, assets::kPackMagic, sizeof header.magic);
    header.version = assets::kPackVersion;
    header.header_bytes = sizeof header;
    header.reserved = 0;
    header.file_bytes = pack.size();
    if (header.table_offset >= sizeof header && header.table_offset < pack.size()) {
        header.table_bytes = pack.size() - header.table_offset;
        const auto table = std::span(pack).subspan(header.table_offset);
        fix_blocks(pack, table);
        header.table_hash = hash_bytes(table);
    }
    header.header_hash = hash_bytes(std::as_bytes(std::span(&header, 1)).first(offsetof(PackHeader, header_hash)));
    std::memcpy(pack.data(), &header, sizeof header);
}

}  // namespace ff::test
