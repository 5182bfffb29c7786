#pragma once
// Systems that say what they read and write, run in parallel where that cannot be noticed.
//
// Two systems conflict when one writes what the other reads or writes. Conflicting ones run in the order they were
// added; all others at the same time. Structural changes are recorded per system and applied in the systems' order at
// the next barrier. So the result is that of running the systems one after the other, for any number of workers.

#include <functional>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "engine/ecs/commands.h"
#include "engine/ecs/registry.h"

namespace ff::ecs {

/// What a system touches; using anything else is a failed check.
class Access {
  public:
    template <class... Components>
    Access& read() {
        (reads_.set(type_id<Components>()), ...);
        return *this;
    }
    template <class... Components>
    Access& write() {
        (writes_.set(type_id<Components>()), ...);
        return *this;
    }
    template <class... Resources>
    Access& read_resource() {
        (prepare_.push_back([](Registry& r) { r.resource<Resources>(); }), ...);
        return read<Resources...>();
    }
    template <class... Resources>
    Access& write_resource() {
        (prepare_.push_back([](Registry& r) { r.resource<Resources>(); }), ...);
        return write<Resources...>();
    }
    template <class... Events>
    Access& send() {
        (prepare_.push_back([](Registry& r) { r.events<Events>(); }), ...);
        return write<EventQueue<Events>...>();
    }
    /// Reads the tick before's events, so it conflicts with nobody who sends.
    template <class... Events>
    Access& receive() {
        (prepare_.push_back([](Registry& r) { r.events<Events>(); }), ...);
        return read<Received<Events>...>();
    }

    [[nodiscard]] bool conflicts_with(const Access& other) const {
        return (writes_ & (other.reads_ | other.writes_)).any() || (other.writes_ & reads_).any();
    }
    template <class T>
    [[nodiscard]] bool may_read() const {
        return reads_.test(type_id<T>()) || writes_.test(type_id<T>());
    }
    template <class T>
    [[nodiscard]] bool may_write() const {
        return writes_.test(type_id<T>());
    }
    void prepare(Registry& registry) const {
        for (const auto make : prepare_) make(registry);
    }
    template <class>
    struct Received {};

  private:
    TypeSet reads_, writes_;
    std::vector<void (*)(Registry&)> prepare_;  ///< makes resources and queues before systems run in parallel
};

/// What a system may do: everything goes through here, and is held against what it declared.
class SystemContext {
  public:
    SystemContext(Registry& registry, Commands& commands, const Access& access, std::string_view name)
        : registry_(registry), commands_(commands), access_(access), name_(name) {}

    template <class... Terms, class Body>
    void each_chunk(Body&& body) {
        (check_term<Terms>(), ...);
        registry_.each_chunk<Terms...>(body);
    }
    template <class... Terms, class Body>
    void each(Body&& body) {
        (check_term<Terms>(), ...);
        registry_.each<Terms...>(body);
    }
    /// Commands and events may not be used in the body: many threads run it.
    template <class... Terms, class Body>
    void each_chunk_parallel(Body&& body) {
        (check_term<Terms>(), ...);
        registry_.each_chunk_parallel<Terms...>(body);
    }
    /// `get<const T>` reads, `get<T>` writes. Null as in Registry.
    template <class T>
    [[nodiscard]] T* get(Entity entity) {
        check_term<T>();
        return registry_.get<std::remove_const_t<T>>(entity);
    }
    [[nodiscard]] bool is_alive(Entity entity) const { return registry_.is_alive(entity); }
    template <class T>
    [[nodiscard]] T& resource() {
        check_term<T>();
        return registry_.resource<std::remove_const_t<T>>();
    }
    template <class Event>
    void send(Event event) {
        check_term<EventQueue<Event>>();
        registry_.events<Event>().send(std::move(event));
    }
    template <class Event>
    [[nodiscard]] std::span<const Event> received() {
        check_term<const Access::Received<Event>>();
        return registry_.events<Event>().read();
    }
    [[nodiscard]] Commands& commands() { return commands_; }

  private:
    template <class Term>
    struct IsWithout : std::false_type {};
    template <class T>
    struct IsWithout<Without<T>> : std::true_type {};
    template <class Term>
    void check_term() const {
        if constexpr (!IsWithout<Term>::value) {
            using T = std::remove_const_t<Term>;
            FF_CHECK(std::is_const_v<Term> ? access_.may_read<T>() : access_.may_write<T>(),
                     "system '{}' {} something that it did not declare", name_,
                     std::is_const_v<Term> ? "reads" : "writes");
        }
    }
    Registry& registry_;
    Commands& commands_;
    const Access& access_;
    std::string_view name_;
};

using System = std::function<void(SystemContext&)>;

/// Threads: run() uses the workers of jobs.h; one run at a time.
class Schedule {
  public:
    Schedule();
    ~Schedule();
    Schedule(const Schedule&) = delete;
    Schedule& operator=(const Schedule&) = delete;

    /// Adds a system after all others.
    void add(std::string name, Access access, System system);
    /// What was recorded before it is applied before anything after it runs. There is one at the end of every run.
    void add_barrier();
    /// Runs every system once.
    void run(Registry& registry);

    [[nodiscard]] std::size_t size() const { return systems_.size(); }
    /// Systems, by the order they were added, that must end before this one starts; barriers apart.
    [[nodiscard]] std::span<const std::uint32_t> predecessors(std::size_t system) const;

  private:
    struct Node;
    struct Run;
    void run_range(Registry& registry, std::size_t begin, std::size_t end);
    std::vector<std::unique_ptr<Node>> systems_;
    std::vector<std::size_t> barriers_;  ///< number of systems before each
};

}  // namespace ff::ecs
