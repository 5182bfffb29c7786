// Packs of any bytes: once as they are, once with all hashes right. What loads is walked as casters would.

#include <cstdint>
#include <cstring>
#include <vector>

#include "engine/animation/dynamic_models.h"
#include "engine/core/check.h"
#include "engine/core/jobs.h"
#include "engine/scene/load_world.h"
#include "tests/fuzz/pack_surgery.h"
#include "tests/fuzz/touch_world.h"

namespace {

/// Moves all that moves, in a view of the world's middle.
void pose(ff::scene::World& world) {
    if (world.info().animation.models.empty()) return;
    ff::animation::DynamicModels models(world);
    auto states = ff::animation::initial_models(world.info().animation);
    for (const double time_s : {0.0, 0.7}) {
        ff::animation::set_time(world.info().animation, time_s, states);
        (void)models.pose(states, ff::make_view({.position = world.scene().origin}, 64, 48));
    }
}

/// Bombs that decompress to gigabytes are legal packs; they only cost the fuzzer its time.
constexpr std::uint64_t kMaxRawBytes = 64u << 20;

void load(const std::vector<std::byte>& bytes) {
    const auto reader = ff::assets::PackReader::from_bytes("fuzz.ffpack", bytes);
    if (!reader) {
        FF_CHECK(reader.error().kind == ff::ErrorKind::bad_input, "{}", reader.error().message);
        return;
    }
    std::uint64_t raw = 0;
    for (const auto& chunk : reader->chunks()) raw += chunk.raw_bytes() * (chunk.name == "mesh_leaves" ? 448 : 1);
    if (raw > kMaxRawBytes) return;
    const auto world = ff::scene::load_world(*reader);
    if (world) {
        ff::test::touch_world(**world);
        pose(**world);
    } else {
        FF_CHECK(world.error().kind == ff::ErrorKind::bad_input, "{}", world.error().message);
    }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    static const ff::WorkerLimit one_worker(1);  // repeatable, and no threads to leak
    std::vector<std::byte> bytes(size);
    if (size > 0) std::memcpy(bytes.data(), data, size);
    load(bytes);
    ff::test::fix_hashes(bytes);
    load(bytes);
    return 0;
}
