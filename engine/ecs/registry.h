#pragma once
// Entities, their components, and the process-wide things that systems share (resources, events).
//
// Threads: structural changes (create, destroy, add, remove) by one thread, while nobody iterates; systems record them
// in Commands instead. Different components may be read and written by different threads at once; see Schedule.

#include <array>
#include <atomic>
#include <memory>
#include <new>
#include <span>
#include <tuple>
#include <unordered_map>
#include <utility>
#include <vector>

#include "engine/core/check.h"
#include "engine/core/jobs.h"
#include "engine/ecs/archetype.h"
#include "engine/ecs/entity.h"
#include "engine/ecs/events.h"

namespace ff::ecs {

/// In a query: only entities that lack T.
template <class T>
struct Without {};

class Registry {
  public:
    Registry();
    ~Registry();
    Registry(const Registry&) = delete;
    Registry& operator=(const Registry&) = delete;

    /// A new entity with these components, all of different types.
    template <class... Components>
    Entity create(Components... components) {
        check_not_iterating();
        const std::uint32_t archetype = archetype_of_bundle<Components...>();
        Archetype& home = *archetypes_[archetype];
        const Entity entity = take_slot();
        const Row row = home.push(entity);
        slots_[entity.index].archetype = archetype;
        slots_[entity.index].row = row;
        (construct(home, row, std::move(components)), ...);
        return entity;
    }

    /// @return false, and nothing happens, where the entity is not alive.
    bool destroy(Entity entity);
    [[nodiscard]] bool is_alive(Entity entity) const {
        return entity.index < slots_.size() && slots_[entity.index].generation == entity.generation &&
               entity.generation != 0;
    }
    /// Entities alive.
    [[nodiscard]] std::size_t size() const { return alive_; }

    /// The component of an entity; null where the entity is not alive or has none. Valid until the next structural
    /// change.
    template <class T>
    [[nodiscard]] T* get(Entity entity) {
        if (!is_alive(entity)) return nullptr;
        const Slot& slot = slots_[entity.index];
        Archetype& home = *archetypes_[slot.archetype];
        const std::uint8_t column = home.column_of(type_id<T>());
        return column == kNoColumn ? nullptr : std::launder(reinterpret_cast<T*>(home.component(slot.row, column)));
    }
    template <class T>
    [[nodiscard]] const T* get(Entity entity) const {
        return const_cast<Registry*>(this)->get<T>(entity);
    }
    template <class T>
    [[nodiscard]] bool has(Entity entity) const {
        return get<T>(entity) != nullptr;
    }

    /// Gives an entity a component, or replaces the one it has.
    /// @return the component; null where the entity is not alive.
    template <class T>
    T* add(Entity entity, T component) {
        return static_cast<T*>(add_erased(entity, component_info<T>(), &component,
                                          [](void* to, void* from) { new (to) T(std::move(*static_cast<T*>(from))); }));
    }
    /// @return false where the entity is not alive or has none.
    template <class T>
    bool remove(Entity entity) {
        return remove_erased(entity, component_info<T>());
    }

    /// Calls body(entities, a, b, ...) with spans of equal length for each chunk of the entities that have all of the
    /// types; `const T` reads, `T` writes, `Without<T>` gives no span. The order is the same for the same history.
    template <class... Terms, class Body>
    void each_chunk(Body&& body) {
        const IterationGuard guard(*this);
        for_matching<Terms...>([&](Archetype& home) {
            for (std::size_t chunk = 0; chunk < home.chunk_count(); ++chunk) call_chunk<Terms...>(home, chunk, body);
        });
    }
    /// Calls body(a, b, ...) for each such entity.
    template <class... Terms, class Body>
    void each(Body&& body) {
        each_chunk<Terms...>([&](std::span<const Entity> entities, auto... columns) {
            for (std::size_t i = 0; i < entities.size(); ++i) body(columns[i]...);
        });
    }
    /// Like each_chunk, with chunks spread over the workers: body runs on many threads at once, for different entities.
    template <class... Terms, class Body>
    void each_chunk_parallel(Body&& body);

    /// A process-wide value: made on first use.
    template <class T>
    T& resource() {
        auto& slot = resources_[type_id<T>()];
        if (!slot.value) slot = {new T(), [](void* value) { delete static_cast<T*>(value); }};
        return *static_cast<T*>(slot.value);
    }

    /// The queue of one type of event; a resource, too.
    template <class T>
    EventQueue<T>& events() {
        const TypeId id = type_id<EventQueue<T>>();
        if (!resources_[id].value)
            event_queues_.push_back(
                {&resource<EventQueue<T>>(), [](void* queue) { static_cast<EventQueue<T>*>(queue)->swap(); }});
        return resource<EventQueue<T>>();
    }
    /// Ends a tick: what was sent since the last call can be read until the next.
    void swap_events();

    /// Grows with every structural change; equal means that rows and pointers are where they were. No two registries
    /// ever have the same.
    [[nodiscard]] std::uint64_t structure_version() const { return structure_version_; }

    /// For Commands: as add and remove, without the type.
    using MoveConstruct = void (*)(void* to, void* from);
    void* add_erased(Entity entity, const ComponentInfo& info, void* component, MoveConstruct move);
    bool remove_erased(Entity entity, const ComponentInfo& info);

  private:
    struct Slot {
        std::uint32_t generation = 0;
        std::uint32_t archetype = 0;
        Row row;
    };
    struct Resource {
        void* value = nullptr;
        void (*destroy)(void*) = nullptr;
    };
    struct SwappedQueue {
        void* queue;
        void (*swap)(void*);
    };
    /// Structural changes are refused while one lives.
    struct IterationGuard {
        explicit IterationGuard(Registry& r) : registry(r) { registry.iterating_.fetch_add(1); }
        ~IterationGuard() { registry.iterating_.fetch_sub(1); }
        Registry& registry;
    };

    void check_not_iterating() const {
        FF_CHECK(iterating_.load(std::memory_order_relaxed) == 0,
                 "entities change while they are iterated; record the change in Commands");
    }

    Entity take_slot() {
        ++alive_;
        ++structure_version_;
        if (free_.empty()) {
            slots_.push_back({1, 0, {}});
            return {std::uint32_t(slots_.size() - 1), 1};
        }
        const std::uint32_t index = free_.back();
        free_.pop_back();
        return {index, slots_[index].generation};
    }

    template <class T>
    static void construct(Archetype& home, Row row, T&& component) {
        if constexpr (!std::is_empty_v<T>)
            new (home.component(row, home.column_of(type_id<T>()))) T(std::forward<T>(component));
    }

    template <class... Components>
    std::uint32_t archetype_of_bundle() {
        const TypeId bundle = bundle_id<std::tuple<Components...>>();
        if (bundle >= bundle_archetypes_.size()) bundle_archetypes_.resize(bundle + 1, Archetype::kNoEdge);
        if (bundle_archetypes_[bundle] == Archetype::kNoEdge)
            bundle_archetypes_[bundle] = find_archetype({&component_info<Components>()...});
        return bundle_archetypes_[bundle];
    }
    template <class List>
    static TypeId bundle_id() {
        static const TypeId id = next_bundle_id();
        return id;
    }
    static TypeId next_bundle_id();
    std::uint32_t find_archetype(std::vector<const ComponentInfo*> components);
    /// Moves what both have; components that `to` lacks are destroyed, those it has more are raw memory.
    void move_entity(Entity entity, std::uint32_t to);

    template <class Term>
    struct TermOf {
        using Type = std::remove_const_t<Term>;
        static constexpr bool kExcludes = false;
    };
    template <class T>
    struct TermOf<Without<T>> {
        using Type = T;
        static constexpr bool kExcludes = true;
    };
    template <class Term>
    static auto span_of(Archetype& home, std::size_t chunk) {
        if constexpr (TermOf<Term>::kExcludes) {
            return std::tuple<>();
        } else {
            using T = typename TermOf<Term>::Type;
            static_assert(!std::is_empty_v<T>, "a tag has no data to iterate; ask has<T>() or use it in Without");
            T* const first = std::launder(reinterpret_cast<T*>(home.column(chunk, home.column_of(type_id<T>()))));
            return std::tuple<std::span<Term>>(std::span<Term>(first, home.chunk_size(chunk)));
        }
    }
    template <class... Terms, class Body>
    static void call_chunk(Archetype& home, std::size_t chunk, Body& body) {
        const std::span<const Entity> entities(home.entities(chunk), home.chunk_size(chunk));
        std::apply([&](auto... columns) { body(entities, columns...); },
                   std::tuple_cat(span_of<Terms>(home, chunk)...));
    }
    template <class... Terms, class Visit>
    void for_matching(Visit&& visit) {
        TypeSet with, without;
        ((TermOf<Terms>::kExcludes ? without : with).set(type_id<typename TermOf<Terms>::Type>()), ...);
        for (const auto& home : archetypes_)
            if (home->size() > 0 && (home->types() & with) == with && (home->types() & without).none()) visit(*home);
    }

    std::vector<Slot> slots_;
    std::vector<std::uint32_t> free_;  ///< last in, first out
    std::size_t alive_ = 0;
    std::uint64_t structure_version_ = 0;
    std::atomic<int> iterating_{0};
    std::vector<std::unique_ptr<Archetype>> archetypes_;  ///< in order of first use
    std::unordered_map<TypeSet, std::uint32_t> archetype_of_;
    std::vector<std::uint32_t> bundle_archetypes_;
    std::array<Resource, kMaxTypes> resources_{};
    std::vector<SwappedQueue> event_queues_;
};

template <class... Terms, class Body>
void Registry::each_chunk_parallel(Body&& body) {
    const IterationGuard guard(*this);
    for_matching<Terms...>([&](Archetype& home) {
        parallel_ranges(home.chunk_count(), 8, [&](std::size_t begin, std::size_t end) {
            for (std::size_t chunk = begin; chunk < end; ++chunk) call_chunk<Terms...>(home, chunk, body);
        });
    });
}

}  // namespace ff::ecs
