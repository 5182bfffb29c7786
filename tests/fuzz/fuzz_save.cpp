// Saved games of any bytes; every second input gets the checksum that it needs. What is read can be written and is the
// same again.

#include <cstdint>
#include <cstring>
#include <vector>

#include "engine/core/check.h"
#include "engine/core/hash.h"
#include "engine/loop/save_game.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    const auto* first = reinterpret_cast<const std::byte*>(data);
    std::vector<std::byte> bytes(first, first + size);
    if (size >= 16 && (data[size - 1] & 1) != 0) {
        const std::uint64_t hash = ff::hash_bytes(std::span(bytes).first(size - 8));
        std::memcpy(bytes.data() + size - 8, &hash, 8);
    }
    const auto save = ff::loop::parse_save(bytes, "fuzz.save", "beacons", 3);
    if (!save) {
        FF_CHECK(save.error().kind == ff::ErrorKind::bad_input, "{}", save.error().message);
        return 0;
    }
    FF_CHECK(save->game == "beacons" && save->version <= 3, "another game's, version {}", save->version);
    FF_CHECK(save->state.size() < size, "a state of {} bytes from {}", save->state.size(), size);
    return 0;
}
