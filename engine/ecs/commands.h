#pragma once
// Structural changes recorded now and made later, when nobody iterates.

#include <cstddef>
#include <cstdint>
#include <memory>
#include <new>
#include <tuple>
#include <utility>
#include <vector>

#include "engine/ecs/registry.h"

namespace ff::ecs {

/// A list of changes. What concerns an entity that is no longer alive when its turn comes is skipped.
/// Threads: one; Schedule gives every system its own and applies them in the systems' order.
class Commands {
  public:
    Commands() = default;
    ~Commands() { clear(); }
    Commands(Commands&&) noexcept = default;
    Commands& operator=(Commands&&) = delete;
    Commands(const Commands&) = delete;

    /// @return a stand-in for the entity to come, which only this list's later commands understand; it is not alive,
    ///         and must not be stored in components.
    template <class... Components>
    Entity create(Components... components) {
        record({}, std::tuple<Components...>(std::move(components)...),
               [](Registry& registry, Entity, std::tuple<Components...>& bundle) {
                   return std::apply([&](Components&... each) { return registry.create(std::move(each)...); }, bundle);
               });
        return {created_count_++, kPending};
    }
    void destroy(Entity entity) {
        record(entity, Nothing{}, [](Registry& registry, Entity target, Nothing&) {
            registry.destroy(target);
            return Entity{};
        });
    }
    template <class T>
    void add(Entity entity, T component) {
        record(entity, std::move(component), [](Registry& registry, Entity target, T& value) {
            registry.add<T>(target, std::move(value));
            return Entity{};
        });
    }
    template <class T>
    void remove(Entity entity) {
        record(entity, Nothing{}, [](Registry& registry, Entity target, Nothing&) {
            registry.remove<T>(target);
            return Entity{};
        });
    }

    /// Makes all changes in the order they were recorded, and forgets them.
    void apply(Registry& registry);
    /// Forgets them.
    void clear();
    [[nodiscard]] bool empty() const { return commands_.empty(); }

  private:
    static constexpr std::uint32_t kPending = 0xFFFFFFFFu;  ///< a generation that no entity reaches
    static constexpr std::size_t kBlockBytes = 16 * 1024;
    struct Nothing {};
    struct Command {
        Entity target;
        void* payload;
        Entity (*run)(Registry&, Entity target, void* payload);
        void (*drop)(void* payload);
    };
    struct Block {
        std::unique_ptr<std::byte[]> bytes;
        std::size_t size = 0, used = 0;
    };

    template <class Payload, class Run>
    void record(Entity target, Payload payload, Run) {
        void* const place = new (allocate(sizeof(Payload), alignof(Payload))) Payload(std::move(payload));
        commands_.push_back({target, place,
                             [](Registry& registry, Entity resolved, void* stored) {
                                 return Run{}(registry, resolved, *static_cast<Payload*>(stored));
                             },
                             [](void* stored) { static_cast<Payload*>(stored)->~Payload(); }});
    }
    void* allocate(std::size_t size, std::size_t alignment);

    std::vector<Command> commands_;
    std::vector<Block> blocks_;  ///< kept for the next tick
    std::size_t block_ = 0;      ///< being filled
    std::uint32_t created_count_ = 0;
    std::vector<Entity> created_;
};

}  // namespace ff::ecs
