#include "engine/host/first_person.h"

#include <gtest/gtest.h>

#include <glm/geometric.hpp>

#include "engine/host/shown_model.h"
#include "tests/support/worlds.h"

namespace ff::host {
namespace {

constexpr std::int32_t kEast = 1'570'796;  // microradians

TEST(FirstPerson, walks_where_it_looks_and_no_faster_aslant) {
    loop::UserCommand command{.move_ahead = loop::UserCommand::kFull};
    EXPECT_LT(glm::distance(walking_input(command, 2.0f, false).velocity_m_s, Vec3(0, 0, -2)), 1e-5f);
    command.yaw_urad = kEast;
    EXPECT_LT(glm::distance(walking_input(command, 2.0f, false).velocity_m_s, Vec3(2, 0, 0)), 1e-5f);
    command.move_right = loop::UserCommand::kFull;
    EXPECT_NEAR(glm::length(walking_input(command, 2.0f, true).velocity_m_s), 2.0f, 1e-5f);
    EXPECT_TRUE(walking_input(command, 2.0f, true).jump);
}

TEST(FirstPerson, walking_actions_come_in_the_order_that_controls_want) {
    const auto actions = walking_actions();
    ASSERT_EQ(actions.size(), std::size_t(loop::kWalkActions));
    EXPECT_EQ(actions[loop::kAhead].name, "ahead");
    EXPECT_EQ(actions[loop::kRight].name, "right");
    EXPECT_EQ(loop::trigger_name(action("use", {"e", "pad x"}).triggers[1]), "pad x");
}

TEST(ShownModel, moves_and_turns_as_a_whole_about_its_place) {
    scene::WorldInfo info;
    info.name = "two parts";
    info.dynamic_instances = {{.mesh = 0, .position = {10, 0, 0}}, {.mesh = 0, .position = {10, 0, -3}}};
    const scene::NamedPlace place{{.position = {10, 0, 0}, .yaw = 0.0, .first_instance = 0, .instance_count = 2},
                                  "gate"};
    const scene::World world(test::make_city({.cells = 2}), std::move(info));
    GameView view;
    show_model(world, model_of(place), {100, 5, 0}, turn_of(kEast * 1e-6), 0.0, view);
    ASSERT_EQ(view.dynamic.size(), 2u);
    EXPECT_LT(glm::distance(view.dynamic[0].position, WorldPos(100, 5, 0)), 1e-5);
    // What lay north of the place lies east of it now.
    EXPECT_LT(glm::distance(view.dynamic[1].position, WorldPos(103, 5, 0)), 1e-5);
    EXPECT_TRUE(view.models.empty());
}

}  // namespace
}  // namespace ff::host
