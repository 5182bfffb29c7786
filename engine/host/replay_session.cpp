#include "engine/host/replay_session.h"

#include <fmt/format.h>

namespace ff::host {

Result<ReplaySession> ReplaySession::begin(const GameInfo& info, const scene::World& world,
                                           const replay::Recording& recording, bool any_world) {
    const replay::SessionHeader& header = recording.header;
    if (header.game != info.name)
        return bad_input(fmt::format("recorded by the game '{}', this is '{}'", header.game, info.name));
    if (header.ticks_per_second != kTicksPerSecond)
        return bad_input(fmt::format("recorded with {} ticks a second; this program has {}", header.ticks_per_second,
                                     kTicksPerSecond));
    if (!any_world && header.pack_hash != world.statistics().pack_hash)
        return bad_input(fmt::format("recorded in '{}', of hash {:016x}; this world's is {:016x}", header.pack,
                                     header.pack_hash, world.statistics().pack_hash));
    FF_ASSIGN(std::unique_ptr<Game> game, info.begin(world, header.seed));
    if (!header.start.empty()) FF_TRY(game->load(header.start, info.save_version));
    return ReplaySession(std::move(game), recording);
}

bool ReplaySession::step() {
    if (tick_ >= recording_->commands.size()) return false;
    game_->tick(recording_->commands[tick_]);
    if (!divergence_ && tick_ < recording_->digests.size()) {
        const replay::StateDigest now = game_->digest();
        if (now != recording_->digests[tick_]) {
            divergence_ = {
                .tick = tick_, .entity = differing_entity(now, recording_->digests[tick_]), .description = {}};
            if (divergence_->entity) divergence_->description = game_->describe(*divergence_->entity);
        }
    }
    ++tick_;
    return true;
}

std::string to_text(const Divergence& divergence) {
    std::string text = fmt::format("differs first after tick {} ({:.2f} s)", divergence.tick,
                                   double(divergence.tick + 1) / kTicksPerSecond);
    if (divergence.entity) text += fmt::format(", in entity {}: {}", *divergence.entity, divergence.description);
    return text;
}

}  // namespace ff::host
