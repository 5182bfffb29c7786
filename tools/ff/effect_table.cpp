#include "tools/ff/effect_table.h"

#include <fmt/format.h>

#include <algorithm>

#include "engine/core/write_file.h"

namespace ff::tool {
namespace {

std::string row_of(const effects::Effect& effect, const EffectWalk& walk, const EffectDifference* difference) {
    const EffectSum& sum = walk.of[std::size_t(effect.id)];
    std::string row = fmt::format("| {} | {} | ", effect.name, effect.called_by);
    if (difference == nullptr)
        return row + fmt::format("off: {} | - | - | - | 0 ms, 0 rays, 0 allocations |  |  |\n", sum.decision.reason);
    const effects::Work& idle = difference->own_without;
    row += difference->is_called
               ? fmt::format("{} of {} frames", sum.frames_in[std::size_t(effects::State::active)], walk.frames)
               : std::string("put into all frames");
    row += fmt::format(" | {:+.2f} | {:.0f} | {:.1f} dB |", difference->ms_added, difference->rays_per_frame,
                       difference->psnr_db);
    row += fmt::format(" {} ms, {} rays, {} allocations |", idle.ms, idle.rays, idle.allocations);
    return row + fmt::format(" ![with]({0}_with.png) | ![without]({0}_without.png) |\n", effect.name);
}

}  // namespace

Status write_effect_table(const std::filesystem::path& page, const TablePlace& place, int laps, const EffectWalk& walk,
                          std::span<const EffectDifference> differences) {
    std::string text = fmt::format(
        "# Effects along the walk `{}` of `{}`\n\n"
        "{} frames. Each effect's frames are drawn with it and without it, one after the other, in {} laps; a frame's\n"
        "time is the least of its laps, and what an effect adds is the median frame's difference. `changes` is the\n"
        "picture that it changes most. Without it: what frames spend on it that it is not called for in.\n\n"
        "Frames: median {:.1f} ms, p99 {:.1f}, worst {:.1f}. Effects came or went in {} of them: p99 of these and the "
        "two\n"
        "after each {:.1f} ms. At most {} heap allocations in any frame that no effect came in.\n\n"
        "| effect | called for by | active in | ms added | rays a frame | changes | without it | with | without |\n"
        "|---|---|---|---|---|---|---|---|---|\n",
        place.walk, place.scene, walk.frames, laps, walk.median_ms, walk.p99_ms, walk.max_ms, walk.changes,
        walk.change_p99_ms, walk.most_allocations);
    for (const effects::Effect& effect : effects::registry()) {
        const auto difference = std::find_if(differences.begin(), differences.end(),
                                             [&](const EffectDifference& d) { return d.id == effect.id; });
        text += row_of(effect, walk, difference == differences.end() ? nullptr : &*difference);
    }
    return write_file_whole(page, text);
}

}  // namespace ff::tool
