#include "engine/gl/shader_folder.h"
#include "engine/host/play.h"
#include "engine/host/play_alone.h"
#include "game/beacons/beacons_game.h"
#include "tools/ff/commands.h"
#include "tools/ff/session.h"
#include "tools/ff/source_watcher.h"
#include "tools/picture/picture_file.h"

namespace ff::tool {

Status run_play(const PlayOptions& options) {
    FF_ASSIGN(const CookedSource cooked, cooked_source(options.pack));
    if (options.player)
        return host::play_alone(beacons::game_info(),
                                {.pack = cooked.pack,
                                 .folder = options.folder,
                                 .player = *options.player,
                                 .seed = options.seed,
                                 .ticks = std::uint64_t(options.minutes * 60.0 * host::kTicksPerSecond),
                                 .record = options.record,
                                 .recording = options.recording});
    gl::use_shader_folder(options.shaders);
    std::optional<SourceWatcher> watcher;
    if (!cooked.inputs.empty() || !options.shaders.empty())
        watcher.emplace(options.pack, cooked.pack, cooked.inputs, options.shaders);
    return host::play(beacons::game_info(),
                      {.pack = cooked.pack,
                       .folder = options.folder,
                       .seed = options.seed,
                       .budget_ms = options.budget_ms,
                       .record = options.record,
                       .skip_title = options.skip_title,
                       .changes = [&]() { return watcher ? watcher->poll() : std::nullopt; },
                       .write_picture = [](const std::filesystem::path& path,
                                           const shading::Image& image) { return write_image(path, image); }});
}

}  // namespace ff::tool
