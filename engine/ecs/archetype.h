#pragma once
// All entities that have exactly the same component types, in chunks: one array per component, so that a loop over
// some of them reads nothing else and vectorises.
//
//   chunk (32 KiB, aligned to 64):  Entity[capacity] | A[capacity] | B[capacity] | ...   each array aligned to 64
//
// Rows are dense: only the last used chunk is not full; a removed row is filled by the very last one.

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "engine/ecs/component.h"
#include "engine/ecs/entity.h"

namespace ff::ecs {

inline constexpr std::size_t kChunkBytes = 32 * 1024;
inline constexpr std::uint8_t kNoColumn = 0xFF;

/// Where an entity's components are.
struct Row {
    std::uint32_t chunk = 0;
    std::uint32_t index = 0;  ///< within the chunk
};

class Archetype {
  public:
    /// @param components  sorted by id, without repetition, at most 254
    explicit Archetype(std::vector<const ComponentInfo*> components);
    ~Archetype();
    Archetype(const Archetype&) = delete;
    Archetype& operator=(const Archetype&) = delete;

    [[nodiscard]] const TypeSet& types() const { return types_; }
    [[nodiscard]] std::span<const ComponentInfo* const> components() const { return components_; }
    [[nodiscard]] std::size_t size() const { return size_; }
    [[nodiscard]] std::uint32_t capacity() const { return capacity_; }  ///< rows a chunk
    [[nodiscard]] std::size_t chunk_count() const { return (size_ + capacity_ - 1) / capacity_; }
    [[nodiscard]] std::uint32_t chunk_size(std::size_t chunk) const {
        return std::uint32_t(std::min<std::size_t>(capacity_, size_ - chunk * capacity_));
    }

    /// kNoColumn where the archetype does not have the type.
    [[nodiscard]] std::uint8_t column_of(TypeId type) const { return column_of_[type]; }
    [[nodiscard]] Entity* entities(std::size_t chunk) { return reinterpret_cast<Entity*>(chunks_[chunk]); }
    /// First element of a column in a chunk.
    [[nodiscard]] std::byte* column(std::size_t chunk, std::uint8_t column) {
        return chunks_[chunk] + offsets_[column];
    }
    [[nodiscard]] std::byte* component(Row row, std::uint8_t column) {
        return chunks_[row.chunk] + offsets_[column] + std::size_t(row.index) * components_[column]->size;
    }

    /// A new last row whose components are raw memory: the caller constructs all of them.
    Row push(Entity entity) {
        if (last_free_ == capacity_ || chunks_.empty()) open_chunk();
        const Row row{last_chunk_, last_free_++};
        ++size_;
        entities(row.chunk)[row.index] = entity;
        return row;
    }
    /// Fills a row whose components are gone (moved or destroyed) with the last one.
    /// @return the entity that lives there now; null when the row was the last.
    Entity fill_hole(Row row);
    void destroy_components(Row row);

    /// Cached destinations when one type is added or removed; kNoEdge until known.
    static constexpr std::uint32_t kNoEdge = 0xFFFFFFFFu;
    std::vector<std::uint32_t> added_to, removed_to;  ///< [TypeId]

  private:
    struct FreeSlab {
        std::size_t alignment;
        void operator()(std::byte* slab) const;
    };
    void open_chunk();

    std::vector<const ComponentInfo*> components_;
    TypeSet types_;
    std::uint8_t column_of_[kMaxTypes];
    std::vector<std::uint32_t> offsets_;  ///< bytes from the chunk's start, per column
    std::uint32_t capacity_ = 0;
    std::vector<std::byte*> chunks_;  ///< used ones first; kept for reuse
    /// What chunks are cut from: the first few alone, the others from slabs of a huge page, which saves a large world
    /// most of its page faults and address translations.
    std::vector<std::unique_ptr<std::byte, FreeSlab>> slabs_;
    std::size_t size_ = 0;
    std::uint32_t last_chunk_ = 0, last_free_ = 0;  ///< the chunk being filled and its first free row
};

}  // namespace ff::ecs
