// A player's settings of any text; what is read must survive being written and read again.

#include <cstdint>
#include <string>

#include "engine/core/check.h"
#include "engine/host/player_settings.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace ff;
    const std::vector<loop::Action> actions{{"ahead", {*loop::parse_trigger("w")}},
                                            {"use", {*loop::parse_trigger("e"), *loop::parse_trigger("pad x")}}};
    const std::string text(reinterpret_cast<const char*>(data), size);
    const auto settings = host::read_settings(text, "settings.toml", actions);
    if (!settings) {
        FF_CHECK(settings.error().kind == ErrorKind::bad_input, "{}", settings.error().message);
        return 0;
    }
    const std::string written = host::to_text(*settings);
    const auto again = host::read_settings(written, "again.toml", actions);
    FF_CHECK(again, "written settings are refused: {}", again.error().message);
    FF_CHECK(host::to_text(*again) == written, "settings changed by being written");
    return 0;
}
