#include "tools/cook/walks.h"

#include <utility>

#include "engine/scene/walk.h"

namespace ff::cook {

Result<SourceWalk> read_walk_file(const std::filesystem::path& path, const std::string& name) {
    Result<scene::Walk> loaded = scene::load_walk(path);
    if (!loaded) return loaded.error();
    SourceWalk walk{.name = name, .fov_deg = loaded->fov_deg, .rate_hz = loaded->rate_hz};
    walk.frames.reserve(loaded->frames.size());
    for (const scene::WalkFrame& frame : loaded->frames)
        walk.frames.push_back({frame.position, frame.yaw_deg, frame.pitch_deg, frame.roll_deg});
    return walk;
}

}  // namespace ff::cook
