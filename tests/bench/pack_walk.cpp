#include "tests/bench/pack_walk.h"

#include <fmt/format.h>

#include "engine/scene/load_world.h"

namespace ff::bench {

Result<PackWalk> open_pack_walk(const std::string& pack, const std::string& walk_name) {
    PackWalk opened;
    FF_ASSIGN(opened.world, scene::load_world(pack));
    opened.walk = opened.world->find_walk(walk_name);
    if (opened.walk == nullptr) return bad_input(fmt::format("{}: no walk '{}'", pack, walk_name));
    return opened;
}

}  // namespace ff::bench
