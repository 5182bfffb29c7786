#include "tools/cook/walks_cache.h"

#include "tools/cook/cook_bytes.h"
#include "tools/cook/geometry_hash.h"

namespace ff::cook {
namespace {

// Bump when the walks or the spawn point change for the same world.
constexpr const char* kStep = "walks 1";

void write_walks(const WorldSource& world, ByteWriter& out) {
    out.value(world.spawn_position);
    out.value(world.spawn_yaw_deg);
    out.value(std::uint64_t{world.walks.size()});
    for (const SourceWalk& walk : world.walks) {
        out.text(walk.name);
        out.value(walk.fov_deg);
        out.value(walk.rate_hz);
        out.array(walk.frames);
    }
}

}  // namespace

CacheKey walks_key(WorldSource& world, bool has_spawn) {
    // Of materials, whether a triangle blocks the way or is foliage.
    std::vector<std::uint32_t> flags;
    for (const scene::Material& material : world.materials) flags.push_back(material.flags);
    ByteWriter given;
    write_walks(world, given);
    return CacheKey(kStep).add(hash_geometry(world)).add_array(flags).add_value(has_spawn).add(given.bytes());
}

bool find_walks(const CacheKey& key, CookCache& cache, WorldSource& world) {
    const auto found = cache.find(key);
    if (!found) return false;
    ByteReader in(*found);
    in.value(world.spawn_position);
    in.value(world.spawn_yaw_deg);
    std::uint64_t count = 0;
    in.value(count);
    world.walks.clear();
    for (std::uint64_t i = 0; i < count; ++i) {
        SourceWalk& walk = world.walks.emplace_back();
        in.text(walk.name);
        in.value(walk.fov_deg);
        in.value(walk.rate_hz);
        in.array(walk.frames);
    }
    return true;
}

void store_walks(const CacheKey& key, const WorldSource& world, CookCache& cache) {
    ByteWriter out;
    write_walks(world, out);
    cache.store(key, out.bytes());
}

}  // namespace ff::cook
