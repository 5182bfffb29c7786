#include "engine/ecs/registry.h"

#include <algorithm>
#include <atomic>
#include <cstring>
#include <limits>

namespace ff::ecs {

Registry::Registry() {
    static std::atomic<std::uint64_t> registries{0};
    structure_version_ = ++registries << 40;
    find_archetype({});  // of entities without components
}

Registry::~Registry() {
    for (Resource& resource : resources_)
        if (resource.destroy) resource.destroy(resource.value);
}

TypeId Registry::next_bundle_id() {
    static std::atomic<TypeId> next{0};
    return next++;
}

std::uint32_t Registry::find_archetype(std::vector<const ComponentInfo*> components) {
    TypeSet types;
    for (const ComponentInfo* component : components) {
        FF_CHECK(!types.test(component->id), "an entity has each component type once");
        types.set(component->id);
    }
    const auto [entry, is_new] = archetype_of_.try_emplace(types, std::uint32_t(archetypes_.size()));
    if (is_new) {
        std::sort(components.begin(), components.end(),
                  [](const ComponentInfo* a, const ComponentInfo* b) { return a->id < b->id; });
        archetypes_.push_back(std::make_unique<Archetype>(std::move(components)));
    }
    return entry->second;
}

bool Registry::destroy(Entity entity) {
    check_not_iterating();
    if (!is_alive(entity)) return false;
    Slot& slot = slots_[entity.index];
    Archetype& home = *archetypes_[slot.archetype];
    home.destroy_components(slot.row);
    if (const Entity moved = home.fill_hole(slot.row)) slots_[moved.index].row = slot.row;
    --alive_;
    ++structure_version_;
    // A slot whose generations are used up is left alone, so that no handle ever comes back to life.
    if (slot.generation < std::numeric_limits<std::uint32_t>::max() - 1) {
        ++slot.generation;
        free_.push_back(entity.index);
    } else {
        slot.generation = 0;
    }
    return true;
}

void Registry::move_entity(Entity entity, std::uint32_t to) {
    Slot& slot = slots_[entity.index];
    Archetype& from_home = *archetypes_[slot.archetype];
    Archetype& to_home = *archetypes_[to];
    const Row old = slot.row, row = to_home.push(entity);
    const auto components = from_home.components();
    for (std::size_t i = 0; i < components.size(); ++i) {
        const ComponentInfo& info = *components[i];
        std::byte* const from = from_home.component(old, std::uint8_t(i));
        const std::uint8_t column = to_home.column_of(info.id);
        if (column == kNoColumn) {
            if (info.destroy) info.destroy(from);
        } else if (info.relocate) {
            info.relocate(to_home.component(row, column), from);
        } else {
            std::memcpy(to_home.component(row, column), from, info.size);
        }
    }
    if (const Entity moved = from_home.fill_hole(old)) slots_[moved.index].row = old;
    slot.archetype = to;
    slot.row = row;
    ++structure_version_;
}

void* Registry::add_erased(Entity entity, const ComponentInfo& info, void* component, MoveConstruct move) {
    if (!is_alive(entity)) return nullptr;
    Slot& slot = slots_[entity.index];
    std::uint8_t column = archetypes_[slot.archetype]->column_of(info.id);
    if (column != kNoColumn) {
        void* const old = archetypes_[slot.archetype]->component(slot.row, column);
        if (info.size == 0) return old;
        if (info.destroy) info.destroy(old);
        move(old, component);
        return old;
    }
    check_not_iterating();
    std::uint32_t to = archetypes_[slot.archetype]->added_to[info.id];
    if (to == Archetype::kNoEdge) {
        const auto components = archetypes_[slot.archetype]->components();
        std::vector<const ComponentInfo*> more(components.begin(), components.end());
        more.push_back(&info);
        to = find_archetype(std::move(more));
        archetypes_[slot.archetype]->added_to[info.id] = to;
    }
    move_entity(entity, to);
    column = archetypes_[to]->column_of(info.id);
    void* const place = archetypes_[to]->component(slot.row, column);
    if (info.size > 0) move(place, component);
    return place;
}

bool Registry::remove_erased(Entity entity, const ComponentInfo& info) {
    check_not_iterating();
    if (!is_alive(entity)) return false;
    Slot& slot = slots_[entity.index];
    if (archetypes_[slot.archetype]->column_of(info.id) == kNoColumn) return false;
    std::uint32_t to = archetypes_[slot.archetype]->removed_to[info.id];
    if (to == Archetype::kNoEdge) {
        std::vector<const ComponentInfo*> fewer;
        for (const ComponentInfo* component : archetypes_[slot.archetype]->components())
            if (component->id != info.id) fewer.push_back(component);
        to = find_archetype(std::move(fewer));
        archetypes_[slot.archetype]->removed_to[info.id] = to;
    }
    move_entity(entity, to);
    return true;
}

void Registry::swap_events() {
    for (const SwappedQueue& queue : event_queues_) queue.swap(queue.queue);
}

}  // namespace ff::ecs
