#include "engine/host/play.h"
#include "engine/host/play_alone.h"
#include "game/beacons/beacons_game.h"
#include "tools/ff/commands.h"
#include "tools/ff/session.h"
#include "tools/picture/picture_file.h"

namespace ff::tool {

Status run_play(const PlayOptions& options) {
    FF_ASSIGN(const std::filesystem::path pack, pack_of(options.pack));
    if (options.player)
        return host::play_alone(beacons::game_info(),
                                {.pack = pack,
                                 .folder = options.folder,
                                 .player = *options.player,
                                 .seed = options.seed,
                                 .ticks = std::uint64_t(options.minutes * 60.0 * host::kTicksPerSecond),
                                 .record = options.record,
                                 .recording = options.recording});
    return host::play(beacons::game_info(),
                      {.pack = pack,
                       .folder = options.folder,
                       .seed = options.seed,
                       .budget_ms = options.budget_ms,
                       .record = options.record,
                       .skip_title = options.skip_title,
                       .write_picture = [](const std::filesystem::path& path, const shading::Image& image) {
                           return write_image(path, image);
                       }});
}

}  // namespace ff::tool
