#pragma once

#include <memory>
#include <string>

#include "engine/core/result.h"
#include "engine/scene/walk.h"
#include "engine/scene/world.h"

namespace ff::bench {

/// A pack and one of its walks, for benches on real content.
struct PackWalk {
    std::unique_ptr<scene::World> world;
    const scene::Walk* walk = nullptr;  ///< the world's
};

/// Errors: those of load_world; no such walk.
Result<PackWalk> open_pack_walk(const std::string& pack, const std::string& walk_name);

}  // namespace ff::bench
