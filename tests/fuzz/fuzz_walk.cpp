// Walk files of any text; what is read must survive being written and read again.

#include <cstdint>
#include <string_view>

#include "engine/core/check.h"
#include "engine/scene/walk.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    const std::string_view text(reinterpret_cast<const char*>(data), size);
    const auto walk = ff::scene::parse_walk(text, "fuzz.walk.json", "fuzz");
    if (!walk) {
        FF_CHECK(walk.error().kind == ff::ErrorKind::bad_input, "{}", walk.error().message);
        return 0;
    }
    const auto again = ff::scene::parse_walk(ff::scene::walk_to_json(*walk), "again.walk.json", "fuzz");
    FF_CHECK(again && *again == *walk, "a walk changed by being written");
    for (std::size_t i = 0; i < walk->frames.size(); ++i) (void)walk->camera(i);
    return 0;
}
