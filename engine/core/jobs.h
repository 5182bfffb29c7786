#pragma once
// Parallel loops over TBB. Iterations write disjoint slots, so the number of workers never changes a result.

#include <algorithm>
#include <cstddef>
#include <memory>
#include <type_traits>

namespace ff {

/// Limits the workers of every parallel loop of the process while it lives. 0: as many as the machine has.
class WorkerLimit {
  public:
    explicit WorkerLimit(int workers);
    ~WorkerLimit();
    WorkerLimit(const WorkerLimit&) = delete;
    WorkerLimit& operator=(const WorkerLimit&) = delete;

  private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

/// Workers that a parallel loop may use now, the calling thread included; at least 1.
[[nodiscard]] int worker_count();

namespace detail {
using LoopBody = void (*)(void* context, std::size_t begin, std::size_t end);
void parallel_ranges(std::size_t count, std::size_t grain, LoopBody body, void* context);
}  // namespace detail

/// Calls body(begin, end) for disjoint ranges that cover [0, count), each of at most `grain` elements
/// (the last may be shorter); returns when all are done. Allocates nothing that lasts.
template <class Body>
void parallel_ranges(std::size_t count, std::size_t grain, Body&& body) {
    detail::parallel_ranges(
        count, grain,
        [](void* context, std::size_t begin, std::size_t end) {
            (*static_cast<std::remove_reference_t<Body>*>(context))(begin, end);
        },
        const_cast<void*>(static_cast<const void*>(&body)));
}

/// A grain of at most `most` for `count` elements that differ in their work: a short list is cut up more finely, so
/// that no worker waits long for the last of another's. The same for any number of workers.
[[nodiscard]] constexpr std::size_t uneven_grain(std::size_t count, std::size_t most) {
    constexpr std::size_t kLeastTasks = 12;
    return std::clamp<std::size_t>((count + kLeastTasks - 1) / kLeastTasks, 1, most);
}

/// Calls body(i) for every i of [0, count), each as a task of its own: for work that is large or uneven.
template <class Body>
void parallel_for(std::size_t count, Body&& body) {
    parallel_ranges(count, 1, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) body(i);
    });
}

}  // namespace ff
