#include "engine/gl/upload_count.h"

#include <atomic>

namespace ff::gl {
namespace {
std::atomic<std::uint64_t> g_uploaded_bytes{0};
}

std::uint64_t uploaded_bytes() {
    return g_uploaded_bytes.load(std::memory_order_relaxed);
}

void detail::count_upload(std::uint64_t bytes) {
    g_uploaded_bytes.fetch_add(bytes, std::memory_order_relaxed);
}

}  // namespace ff::gl
