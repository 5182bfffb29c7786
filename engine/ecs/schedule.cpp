#include "engine/ecs/schedule.h"

#include <oneapi/tbb/task_group.h>

#include <atomic>

#include "engine/core/jobs.h"

namespace ff::ecs {

struct Schedule::Node {
    std::string name;
    Access access;
    System system;
    Commands commands;
    std::vector<std::uint32_t> predecessors, successors;  ///< since the last barrier
    std::atomic<std::uint32_t> waiting_for{0};
};

Schedule::Schedule() = default;
Schedule::~Schedule() = default;

void Schedule::add(std::string name, Access access, System system) {
    auto node = std::make_unique<Node>();
    node->name = std::move(name);
    node->access = std::move(access);
    node->system = std::move(system);
    const std::size_t id = systems_.size();
    for (std::size_t other = barriers_.empty() ? 0 : barriers_.back(); other < id; ++other)
        if (systems_[other]->access.conflicts_with(node->access)) {
            node->predecessors.push_back(std::uint32_t(other));
            systems_[other]->successors.push_back(std::uint32_t(id));
        }
    systems_.push_back(std::move(node));
}

void Schedule::add_barrier() {
    barriers_.push_back(systems_.size());
}

std::span<const std::uint32_t> Schedule::predecessors(std::size_t system) const {
    return systems_[system]->predecessors;
}

void Schedule::run(Registry& registry) {
    for (const auto& node : systems_) node->access.prepare(registry);
    std::size_t begin = 0;
    for (const std::size_t barrier : barriers_) {
        run_range(registry, begin, barrier);
        begin = barrier;
    }
    run_range(registry, begin, systems_.size());
}

struct Schedule::Run {
    Schedule& schedule;
    Registry& registry;
    oneapi::tbb::task_group tasks;

    void call(std::size_t id) {
        Node& node = *schedule.systems_[id];
        SystemContext context(registry, node.commands, node.access, node.name);
        node.system(context);
    }
    void start(std::size_t id) {
        tasks.run([this, id] {
            call(id);
            for (const std::uint32_t next : schedule.systems_[id]->successors)
                if (schedule.systems_[next]->waiting_for.fetch_sub(1) == 1) start(next);
        });
    }
};

void Schedule::run_range(Registry& registry, std::size_t begin, std::size_t end) {
    Run run{*this, registry, {}};
    if (worker_count() == 1 || end - begin == 1) {
        for (std::size_t id = begin; id < end; ++id) run.call(id);
    } else {
        for (std::size_t id = begin; id < end; ++id)
            systems_[id]->waiting_for = std::uint32_t(systems_[id]->predecessors.size());
        for (std::size_t id = begin; id < end; ++id)
            if (systems_[id]->predecessors.empty()) run.start(id);
        run.tasks.wait();
    }
    for (std::size_t id = begin; id < end; ++id) systems_[id]->commands.apply(registry);
}

}  // namespace ff::ecs
