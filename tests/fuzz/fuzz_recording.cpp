// Recordings of any bytes. A checksum that has to fit keeps chance out, so every second input gets a header that does,
// and its bytes are records.

#include <cstdint>
#include <cstring>
#include <vector>

#include "engine/core/byte_stream.h"
#include "engine/core/check.h"
#include "engine/core/hash.h"
#include "engine/replay/record_kinds.h"
#include "engine/replay/recording.h"

namespace {

std::vector<std::byte> with_header(std::span<const std::byte> records) {
    std::vector<std::byte> bytes;
    ff::ByteWriter out(bytes);
    const std::string_view header =
        R"({"game": "beacons", "engine_version": "0.1", "pack": "p", "pack_hash": "0123456789abcdef", )"
        R"("seed": "0000000000000001", "ticks_per_second": 120, "settings": "", "start_bytes": 0})";
    out.raw(ff::replay::kMagic);
    out.fixed(ff::replay::Recording::kVersion, 4);
    out.fixed(header.size(), 4);
    out.raw(header);
    out.fixed(ff::hash_bytes(bytes), 8);
    bytes.insert(bytes.end(), records.begin(), records.end());
    return bytes;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    std::span<const std::byte> bytes(reinterpret_cast<const std::byte*>(data), size);
    std::vector<std::byte> own;
    if (size > 0 && (data[0] & 1) != 0) bytes = own = with_header(bytes.subspan(1));
    const auto recording = ff::replay::parse_recording(bytes, "fuzz.ffreplay");
    if (!recording) {
        FF_CHECK(recording.error().kind == ff::ErrorKind::bad_input, "{}", recording.error().message);
        return 0;
    }
    const std::size_t ticks = recording->commands.size(), states = recording->digests.size();
    FF_CHECK(ticks == states || ticks == states + 1, "{} ticks and {} states", ticks, states);
    for (const ff::replay::Marker& marker : recording->markers)
        FF_CHECK(marker.tick <= states, "a marker after the end, at {}", marker.tick);
    return 0;
}
