#include "engine/host/first_person.h"

#include <cmath>
#include <glm/geometric.hpp>
#include <iterator>

#include "engine/core/check.h"

namespace ff::host {

loop::Action action(std::string name, std::initializer_list<const char*> triggers) {
    loop::Action made{.name = std::move(name)};
    FF_CHECK(triggers.size() <= std::size(made.triggers), "{}: {} keys; at most {}", made.name, triggers.size(),
             std::size(made.triggers));
    std::size_t i = 0;
    for (const char* text : triggers) {
        const auto trigger = loop::parse_trigger(text);
        FF_CHECK(trigger.has_value(), "{}: {}", made.name, trigger.error().message);
        made.triggers[i++] = *trigger;
    }
    return made;
}

std::vector<loop::Action> walking_actions() {
    return {action("ahead", {"w"}), action("back", {"s"}), action("left", {"a"}), action("right", {"d"})};
}

physics::CharacterInput walking_input(const loop::UserCommand& command, float speed_m_s, bool jump) {
    const double yaw = command.yaw_urad * 1e-6;
    Vec3 wish(float(command.move_right), 0.0f, float(-command.move_ahead));
    wish /= float(loop::UserCommand::kFull);
    if (const float length = glm::length(wish); length > 1.0f) wish /= length;
    wish *= speed_m_s;
    const auto sin = float(std::sin(yaw)), cos = float(std::cos(yaw));
    return {.velocity_m_s = {wish.x * cos - wish.z * sin, 0.0f, wish.x * sin + wish.z * cos},
            .jump = jump,
            .crouch = false};
}

Camera eyes_above(const WorldPos& feet, double eye_height_m, const loop::UserCommand& command, double fov) {
    return {.position = feet + DVec3(0.0, eye_height_m, 0.0),
            .yaw = command.yaw_urad * 1e-6,
            .pitch = command.pitch_urad * 1e-6,
            .roll = 0.0,
            .vertical_fov = fov};
}

}  // namespace ff::host
