#include "engine/ecs/archetype.h"

#include <sys/mman.h>

#include <algorithm>
#include <atomic>
#include <cstring>
#include <new>

#include "engine/core/check.h"

namespace ff::ecs {
namespace {
constexpr std::size_t kChunkAlignment = 64;
constexpr std::size_t kSlabBytes = 2 * 1024 * 1024;

std::size_t aligned(std::size_t offset) {
    return (offset + kChunkAlignment - 1) / kChunkAlignment * kChunkAlignment;
}
}  // namespace

namespace detail {
TypeId next_type_id() {
    static std::atomic<TypeId> next{0};
    const TypeId id = next++;
    FF_CHECK(id < kMaxTypes, "more than {} component, resource and event types", kMaxTypes);
    return id;
}
}  // namespace detail

Archetype::Archetype(std::vector<const ComponentInfo*> components) : components_(std::move(components)) {
    FF_CHECK(components_.size() < kNoColumn, "{} components in one entity", components_.size());
    std::fill(std::begin(column_of_), std::end(column_of_), kNoColumn);
    std::size_t row_bytes = sizeof(Entity);
    for (std::size_t i = 0; i < components_.size(); ++i) {
        types_.set(components_[i]->id);
        column_of_[components_[i]->id] = std::uint8_t(i);
        row_bytes += components_[i]->size;
    }
    const std::size_t slack = kChunkAlignment * (components_.size() + 1);
    FF_CHECK(row_bytes + slack <= kChunkBytes, "an entity of {} bytes; a chunk holds {}", row_bytes, kChunkBytes);
    capacity_ = std::uint32_t((kChunkBytes - slack) / row_bytes);
    std::size_t offset = aligned(sizeof(Entity) * capacity_);
    for (const ComponentInfo* component : components_) {
        offsets_.push_back(std::uint32_t(offset));
        offset = aligned(offset + std::size_t(component->size) * capacity_);
    }
    added_to.assign(kMaxTypes, kNoEdge);
    removed_to.assign(kMaxTypes, kNoEdge);
}

Archetype::~Archetype() {
    for (std::size_t column = 0; column < components_.size(); ++column) {
        if (!components_[column]->destroy) continue;
        for (std::size_t chunk = 0; chunk < chunk_count(); ++chunk)
            for (std::uint32_t row = 0; row < chunk_size(chunk); ++row)
                components_[column]->destroy(component({std::uint32_t(chunk), row}, std::uint8_t(column)));
    }
}

void Archetype::FreeSlab::operator()(std::byte* slab) const {
    ::operator delete(slab, std::align_val_t(alignment));
}

void Archetype::open_chunk() {
    last_chunk_ = std::uint32_t(size_ / capacity_);
    last_free_ = std::uint32_t(size_ % capacity_);
    if (last_chunk_ < chunks_.size()) return;
    const bool large = chunks_.size() >= kSlabBytes / kChunkBytes;
    const std::size_t bytes = large ? kSlabBytes : kChunkBytes, alignment = large ? kSlabBytes : kChunkAlignment;
    auto* const slab = static_cast<std::byte*>(::operator new(bytes, std::align_val_t(alignment)));
    slabs_.emplace_back(slab, FreeSlab{alignment});
    if (large) madvise(slab, bytes, MADV_HUGEPAGE);  // advice: works as well without
    for (std::size_t offset = 0; offset < bytes; offset += kChunkBytes) chunks_.push_back(slab + offset);
}

Entity Archetype::fill_hole(Row row) {
    if (last_free_ == 0) {  // the chunk being filled is empty: the last row is in the one before
        --last_chunk_;
        last_free_ = capacity_;
    }
    const Row last{last_chunk_, --last_free_};
    --size_;
    if (last.chunk == row.chunk && last.index == row.index) return {};
    const Entity moved = entities(last.chunk)[last.index];
    entities(row.chunk)[row.index] = moved;
    for (std::size_t i = 0; i < components_.size(); ++i) {
        std::byte* const to = component(row, std::uint8_t(i));
        std::byte* const from = component(last, std::uint8_t(i));
        if (components_[i]->relocate)
            components_[i]->relocate(to, from);
        else
            std::memcpy(to, from, components_[i]->size);
    }
    return moved;
}

void Archetype::destroy_components(Row row) {
    for (std::size_t i = 0; i < components_.size(); ++i)
        if (components_[i]->destroy) components_[i]->destroy(component(row, std::uint8_t(i)));
}

}  // namespace ff::ecs
