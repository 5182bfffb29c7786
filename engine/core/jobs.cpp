#include "engine/core/jobs.h"

#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/global_control.h>
#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/task_arena.h>

#include <algorithm>

namespace ff {

struct WorkerLimit::Impl {
    explicit Impl(int workers)
        : control(oneapi::tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(workers)) {}
    oneapi::tbb::global_control control;
};

WorkerLimit::WorkerLimit(int workers) {
    if (workers > 0) impl_ = std::make_unique<Impl>(workers);
}
WorkerLimit::~WorkerLimit() = default;

int worker_count() {
    const auto allowed =
        oneapi::tbb::global_control::active_value(oneapi::tbb::global_control::max_allowed_parallelism);
    return std::max(1, std::min(static_cast<int>(allowed), oneapi::tbb::this_task_arena::max_concurrency()));
}

namespace detail {

void parallel_ranges(std::size_t count, std::size_t grain, LoopBody body, void* context) {
    if (count == 0) return;
    if (count <= grain || worker_count() == 1) {
        for (std::size_t begin = 0; begin < count; begin += grain) body(context, begin, std::min(count, begin + grain));
        return;
    }
    // Chunks, not elements, are TBB's range: chunk borders then depend on `grain` alone, not on how TBB splits.
    const std::size_t chunks = (count + grain - 1) / grain;
    oneapi::tbb::parallel_for(
        oneapi::tbb::blocked_range<std::size_t>(0, chunks, 1),
        [&](const oneapi::tbb::blocked_range<std::size_t>& range) {
            for (std::size_t chunk = range.begin(); chunk != range.end(); ++chunk)
                body(context, chunk * grain, std::min(count, (chunk + 1) * grain));
        },
        oneapi::tbb::simple_partitioner{});
}

}  // namespace detail
}  // namespace ff
