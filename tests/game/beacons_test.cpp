// The sample game's rules on a small town: played to its end, saved, recorded and played again.

#include "game/beacons/beacons_game.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "engine/core/jobs.h"
#include "engine/host/random_player.h"
#include "engine/host/replay_session.h"
#include "engine/host/session.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/worlds.h"

namespace ff::beacons {
namespace {

scene::Walk walk_between(const std::string& name, const WorldPos& a, const WorldPos& b) {
    scene::Walk walk{.name = name, .fov_deg = 60, .rate_hz = 30, .frames = {}};
    for (const WorldPos& p : {a, b}) walk.frames.push_back({p, 0, 0, 0});
    return walk;
}

/// A town with a gate, a cart, a boat, birds, and two beacons in its streets.
std::unique_ptr<scene::World> make_town() {
    scene::WorldInfo info;
    info.name = "town";
    info.spawn_position = {0.0, 0.0, 0.0};
    info.dynamic_instances.resize(3, {.mesh = 0, .position = {0.0, 0.0, -60.0}});
    info.places = {{{.position = {0.0, 0.0, -40.0}}, "beacon.1"},
                   {{.position = {0.0, 0.0, 40.0}}, "beacon.2"},
                   {{.position = {0.0, 0.0, 0.0}, .first_instance = 0, .instance_count = 1}, "cart.1"},
                   {{.position = {0.0, 0.0, 0.0}, .first_instance = 1, .instance_count = 1}, "boat.1"}};
    info.flocks = {{{.position = {0.0, 60.0, 0.0}, .first_instance = 2, .instance_count = 1}, 14, 45.0f}};
    info.walks = {walk_between("cart.1", {0.0, 0.0, -100.0}, {0.0, 0.0, 100.0}),
                  walk_between("boat.1", {-100.0, 0.0, 0.0}, {100.0, 0.0, 0.0})};
    return std::make_unique<scene::World>(test::make_city({.cells = 4}), std::move(info));
}

/// The same with recordings of what the game knows to play.
std::unique_ptr<scene::World> make_town_with_sounds() {
    const auto silent = make_town();
    scene::WorldInfo info = silent->info();
    info.sounds.clips = {{.name = "chime", .rate_hz = 8000, .samples = {1}},
                         {.name = "cart", .rate_hz = 8000, .samples = {1}}};
    return std::make_unique<scene::World>(test::make_city({.cells = 4}), std::move(info));
}

std::unique_ptr<host::Game> begin(const scene::World& world) {
    auto game = game_info().begin(world, 1);
    EXPECT_TRUE(game) << game.error().message;
    return std::move(*game);
}

TEST(Beacons, one_who_knows_the_way_wins) {
    const auto world = make_town();
    const auto game = begin(*world);
    const auto player = game_info().winner(*game, 1);
    for (int t = 0; t < 120 * host::kTicksPerSecond && game->stage() == host::Stage::playing; ++t)
        game->tick(player->next());
    EXPECT_EQ(game->stage(), host::Stage::won) << game->status();
    EXPECT_NE(game->end_text().find("All beacons burn"), std::string::npos);
    // Nothing goes on after the end.
    const std::uint64_t ticks = game->ticks();
    game->tick({});
    EXPECT_EQ(game->ticks(), ticks);
}

TEST(Beacons, a_beacon_that_is_lit_chimes_once_and_carts_creak_where_they_are) {
    const auto silent = make_town();
    const auto world = make_town_with_sounds();
    const auto game = begin(*world), without = begin(*silent);
    const auto player = game_info().winner(*game, 1);
    std::vector<double> chimes;
    host::GameView view;
    for (int t = 0; t < 120 * host::kTicksPerSecond && game->stage() == host::Stage::playing; ++t) {
        const loop::UserCommand command = player->next();
        game->tick(command);
        without->tick(command);
        game->show(0.0, view);
        for (const sound::SoundEvent& event : view.sound_events)
            if (std::find(chimes.begin(), chimes.end(), event.at_s) == chimes.end()) chimes.push_back(event.at_s);
        ASSERT_EQ(view.sounds.size(), 1u) << "the cart; there is no recording of a boat";
        EXPECT_EQ(view.sounds[0].source.clip, 1u);
        ASSERT_LE(view.sound_events.size(), 2u) << "they are forgotten";
    }
    EXPECT_EQ(game->stage(), host::Stage::won);
    EXPECT_EQ(chimes.size(), 2u);
    EXPECT_TRUE(game->digest() == without->digest()) << "what is heard changes no state";
    without->show(0.0, view);
    EXPECT_TRUE(view.sounds.empty() && view.sound_events.empty());
}

TEST(Beacons, who_does_nothing_loses_at_nightfall) {
    const auto world = make_town();
    const auto game = begin(*world);
    std::uint64_t ticks = 0;
    while (game->stage() == host::Stage::playing && ++ticks < 10'000'000) game->tick({});
    EXPECT_EQ(game->stage(), host::Stage::lost);
    host::GameView view;
    game->show(0.0, view);
    ASSERT_TRUE(view.sun);
    EXPECT_LT(view.sun->elevation, 0.0);
}

TEST(Beacons, the_spyglass_narrows_the_view_and_finds_a_beacon) {
    const auto world = make_town();
    const auto game = begin(*world);
    loop::UserCommand command{.buttons = 1u << 3};
    host::GameView view;
    // Looks north and a little up, where the first one stands.
    command.pitch_urad = std::int32_t(1e6 * std::atan2(5.7 - 1.65, 40.0));
    for (int t = 0; t < 4 * host::kTicksPerSecond; ++t) game->tick(command);
    game->show(0.0, view);
    EXPECT_NEAR(degrees_of(view.camera.vertical_fov), 5.0, 0.1);
    EXPECT_NE(game->status().find("1 spotted"), std::string::npos) << game->status();
    for (int t = 0; t < 4 * host::kTicksPerSecond; ++t) game->tick({});
    game->show(0.0, view);
    EXPECT_NEAR(degrees_of(view.camera.vertical_fov), 65.0, 0.5);
}

TEST(Beacons, frames_show_what_lies_between_two_ticks) {
    const auto world = make_town();
    const auto game = begin(*world);
    const loop::UserCommand walk{.move_ahead = loop::UserCommand::kFull};
    for (int t = 0; t < 200; ++t) game->tick(walk);
    host::GameView a, middle, b;
    game->show(0.0, a);
    game->show(0.5, middle);
    game->show(1.0, b);
    EXPECT_GT(glm::distance(a.camera.position, b.camera.position), 0.01);
    EXPECT_LT(glm::distance(0.5 * (a.camera.position + b.camera.position), middle.camera.position), 1e-9);
    ASSERT_EQ(a.dynamic.size(), middle.dynamic.size());
    for (std::size_t i = 0; i < a.dynamic.size(); ++i)
        EXPECT_LT(glm::distance(0.5 * (a.dynamic[i].position + b.dynamic[i].position), middle.dynamic[i].position),
                  1e-4);
}

TEST(Beacons, the_number_of_workers_changes_no_bit) {
    const auto world = make_town();
    std::vector<replay::StateDigest> digests[2];
    for (const int workers : {1, 2}) {
        const WorkerLimit limit(workers);
        const auto game = begin(*world);
        const auto player = host::make_random_player(game_info(), 5);
        for (int t = 0; t < 20 * host::kTicksPerSecond; ++t) {
            game->tick(player->next());
            digests[workers - 1].push_back(game->digest());
        }
    }
    EXPECT_EQ(digests[0], digests[1]);
}

TEST(Beacons, a_saved_game_goes_on_bit_for_bit) {
    const auto world = make_town();
    const auto game = begin(*world);
    const auto player = host::make_random_player(game_info(), 9);
    for (int t = 0; t < 10 * host::kTicksPerSecond; ++t) game->tick(player->next());
    const std::vector<std::byte> saved = game->save();
    const auto loaded = begin(*world);
    ASSERT_TRUE(loaded->load(saved, game_info().save_version));
    EXPECT_EQ(loaded->save(), saved);
    for (int t = 0; t < 10 * host::kTicksPerSecond; ++t) {
        const loop::UserCommand command = player->next();
        game->tick(command);
        loaded->tick(command);
        ASSERT_EQ(game->digest(), loaded->digest()) << "tick " << t;
    }
    // Damaged or foreign bytes are refused, and nothing changes.
    const replay::StateDigest before = loaded->digest();
    for (const std::size_t size : {std::size_t(0), std::size_t(7), saved.size() / 2, saved.size() - 1})
        EXPECT_FALSE(loaded->load(std::span(saved).first(size), game_info().save_version)) << size;
    EXPECT_FALSE(loaded->load(saved, game_info().save_version + 1));
    EXPECT_EQ(loaded->digest(), before);
}

TEST(Beacons, a_recording_plays_again_and_a_change_is_named) {
    const auto world = make_town();
    const test::TemporaryFolder folder;
    const auto path = folder / "beacons_test.ffreplay";
    auto session = host::Session::begin(game_info(), *world, {.seed = 1, .pack_name = "town", .recording = path});
    ASSERT_TRUE(session) << session.error().message;
    const auto player = host::make_random_player(game_info(), 3);
    for (int t = 0; t < 1000; ++t) (*session)->tick(player->next());
    ASSERT_TRUE((*session)->close());
    auto recording = replay::load_recording(path);
    ASSERT_TRUE(recording) << recording.error().message;

    auto again = host::ReplaySession::begin(game_info(), *world, *recording);
    ASSERT_TRUE(again) << again.error().message;
    while (again->step()) {
    }
    EXPECT_EQ(again->tick(), 1000u);
    EXPECT_FALSE(again->divergence());

    // Another command at tick 500 moves the player alone.
    recording->commands[500].move_ahead = std::int8_t(recording->commands[500].move_ahead > 0 ? -127 : 127);
    auto other = host::ReplaySession::begin(game_info(), *world, *recording);
    ASSERT_TRUE(other);
    while (other->step()) {
    }
    ASSERT_TRUE(other->divergence());
    EXPECT_EQ(other->divergence()->tick, 500u);
    EXPECT_NE(to_text(*other->divergence()).find("tick 500"), std::string::npos);

    recording->header.game = "chess";
    EXPECT_FALSE(host::ReplaySession::begin(game_info(), *world, *recording));
}

TEST(Beacons, a_random_player_breaks_nothing) {
    const auto world = make_town();
    for (const std::uint64_t seed : {1, 2, 3}) {
        const auto game = begin(*world);
        const auto player = host::make_random_player(game_info(), seed);
        host::GameView view;
        for (int t = 0; t < 60 * host::kTicksPerSecond; ++t) {
            game->tick(player->next());
            if (t % 4 != 0) continue;
            game->show(0.5, view);
            const WorldPos& p = view.camera.position;
            ASSERT_TRUE(std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z))
                << "seed " << seed << " tick " << t;
            ASSERT_GT(p.y, -50.0) << "fell through the world: seed " << seed << " tick " << t;
        }
    }
}

TEST(Beacons, who_walks_off_the_world_comes_back_to_where_he_stood) {
    const auto world = make_town();
    const auto game = begin(*world);
    const double edge = std::max(world->scene().bounds.high.x, world->scene().bounds.high.z);
    loop::UserCommand runs{.move_ahead = loop::UserCommand::kFull, .yaw_urad = 1'570'796};
    runs.buttons = 1u << 1;
    host::GameView view;
    double farthest = 0.0, lowest = 0.0;
    for (int t = 0; t < 120 * 120; ++t) {
        game->tick(runs);
        game->show(0.0, view);
        farthest = std::max(farthest, std::abs(view.camera.position.x));
        lowest = std::min(lowest, view.camera.position.y - world->scene().bounds.low.y);
    }
    EXPECT_GT(farthest, edge - 1.0) << "he did not get to the edge";
    EXPECT_GT(lowest, -40.0);
}

TEST(Beacons, a_world_without_ground_gets_some) {
    scene::WorldInfo info;
    info.name = "gap";
    info.spawn_position = {500.0, 3.0, 0.0};
    info.places = {{{.position = {500.0, 3.0, -40.0}}, "beacon.1"}};
    const scene::World world(test::make_city({.cells = 1}), std::move(info));
    const auto game = begin(world);
    for (int t = 0; t < 240; ++t) game->tick({.move_ahead = loop::UserCommand::kFull});
    host::GameView view;
    game->show(0.0, view);
    EXPECT_NEAR(view.camera.position.y, 3.0 + 1.65, 0.1);
    EXPECT_LT(view.camera.position.z, -3.0);
}

TEST(Beacons, loose_bodies_are_pushed_and_saved) {
    scene::SceneData data;
    data.materials.push_back(test::plain_material());
    scene::MeshSource floor, box;
    test::append_box(floor, Vec3(-50.0f, -1.0f, -50.0f), Vec3(50.0f, 0.0f, 50.0f), 1, 0);
    test::append_box(box, Vec3(-0.4f), Vec3(0.4f), 1, 0);
    const std::uint32_t floor_mesh = data.add_mesh(scene::prepare_mesh(floor, data.materials));
    const std::uint32_t box_mesh = data.add_mesh(scene::prepare_mesh(box, data.materials));
    data.add_instance(floor_mesh, WorldPos(0.0), Mat3(1.0f), 0);
    data.finish(64);
    scene::WorldInfo info;
    info.name = "yard";
    info.places = {{{.position = {0.0, 0.0, -45.0}}, "beacon.1"}};
    info.dynamic_instances = {{.mesh = box_mesh, .position = {0.0, 1.0, -3.0}}};
    info.loose_bodies = {{{.position = {0.0, 1.0, -3.0}, .instance_count = 1}, 5.0f}};
    const scene::World world(std::move(data), std::move(info));
    const auto game = begin(world);
    const auto box_place = [](host::Game& shown) {
        host::GameView view;
        shown.show(1.0, view);
        EXPECT_EQ(view.dynamic.size(), 1u);
        return view.dynamic[0].position;
    };
    const loop::UserCommand walk{.move_ahead = loop::UserCommand::kFull};
    for (int t = 0; t < 60; ++t) game->tick({});
    EXPECT_NEAR(box_place(*game).y, 0.4, 0.05) << "it has fallen";
    for (int t = 0; t < 3 * host::kTicksPerSecond; ++t) game->tick(walk);
    EXPECT_LT(box_place(*game).z, -3.5) << "it was pushed ahead";
    host::GameView view;
    game->show(0.0, view);
    EXPECT_TRUE(view.simulations[effects::EffectId::rigid_bodies].is_called_for);
    EXPECT_EQ(view.simulations[effects::EffectId::rigid_bodies].moving, 1u);
    EXPECT_FALSE(view.simulations[effects::EffectId::birds].is_called_for);

    const auto loaded = begin(world);
    ASSERT_TRUE(loaded->load(game->save(), game_info().save_version));
    EXPECT_EQ(box_place(*loaded), box_place(*game));
    for (int t = 0; t < 100; ++t) {
        game->tick(walk);
        loaded->tick(walk);
        ASSERT_EQ(game->digest(), loaded->digest()) << "tick " << t;
    }
}

TEST(Beacons, a_world_that_lacks_something_is_refused_by_name) {
    const scene::World empty(test::make_city({.cells = 1}), {.name = "bare"});
    const auto game = game_info().begin(empty, 1);
    ASSERT_FALSE(game);
    EXPECT_NE(game.error().message.find("beacon.1"), std::string::npos);
    scene::WorldInfo info{.name = "cartless"};
    info.places = {{{}, "beacon.1"}, {{}, "cart.1"}};
    const scene::World world(test::make_city({.cells = 1}), std::move(info));
    const auto refused = game_info().begin(world, 1);
    ASSERT_FALSE(refused);
    EXPECT_NE(refused.error().message.find("cart.1"), std::string::npos);
}

}  // namespace
}  // namespace ff::beacons
