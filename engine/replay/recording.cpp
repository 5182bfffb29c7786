#include "engine/replay/recording.h"

#include <fmt/format.h>

#include <charconv>
#include <cstring>
#include <fstream>
#include <limits>
#include <nlohmann/json.hpp>

#include "engine/core/byte_stream.h"
#include "engine/core/hash.h"
#include "engine/replay/record_kinds.h"

namespace ff::replay {
namespace {

Result<std::uint64_t> hex_field(const nlohmann::json& object, const char* key, const std::string& name) {
    const std::string text = object.value(key, std::string());
    std::uint64_t value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value, 16);
    if (text.empty() || error != std::errc() || end != text.data() + text.size())
        return bad_input(fmt::format("{}: header: '{}' is '{}'; expected a hexadecimal number", name, key, text));
    return value;
}

Result<SessionHeader> read_header(ByteReader& in, std::span<const std::byte> bytes, const std::string& name) {
    const auto magic = in.raw(kMagic.size());
    if (magic.size() != kMagic.size() || std::memcmp(magic.data(), kMagic.data(), kMagic.size()) != 0)
        return bad_input(fmt::format("{}: not a recording: it does not begin with {}", name, kMagic));
    const std::uint64_t version = in.fixed(4);
    if (version != Recording::kVersion)
        return bad_input(fmt::format("{}: a recording of version {}; this program reads version {}", name, version,
                                     Recording::kVersion));
    const std::uint64_t size = in.fixed(4);
    if (size > Recording::kMaxHeaderBytes || size > in.left())
        return bad_input(fmt::format("{}:byte {}: a header of {} bytes; {} are left", name, in.at(), size, in.left()));
    const nlohmann::json json = nlohmann::json::parse(in.text(size), nullptr, false);
    if (!json.is_object()) return bad_input(fmt::format("{}: header: expected a JSON object", name));
    SessionHeader header;
    try {
        header.game = json.value("game", std::string());
        header.engine_version = json.value("engine_version", std::string());
        header.pack = json.value("pack", std::string());
        header.settings = json.value("settings", std::string());
        header.ticks_per_second = json.value("ticks_per_second", 0);
        FF_ASSIGN(header.pack_hash, hex_field(json, "pack_hash", name));
        FF_ASSIGN(header.seed, hex_field(json, "seed", name));
        const auto start_bytes = json.value("start_bytes", std::uint64_t(0));
        if (start_bytes > Recording::kMaxHeaderBytes || start_bytes > in.left())
            return bad_input(fmt::format("{}: header: a start of {} bytes; {} are left", name, start_bytes, in.left()));
        const auto start = in.raw(start_bytes);
        header.start.assign(start.begin(), start.end());
    } catch (const nlohmann::json::exception& error) {
        return bad_input(fmt::format("{}: header: {}", name, error.what()));
    }
    if (header.ticks_per_second < 1 || header.ticks_per_second > 10000)
        return bad_input(fmt::format("{}: header: {} ticks a second; 1 to 10000", name, header.ticks_per_second));
    const std::uint64_t hash = hash_bytes(bytes.first(in.at()));
    if (in.fixed(8) != hash) return bad_input(fmt::format("{}: header: damaged, its checksum differs", name));
    return header;
}

/// The command of a tick; false where a field is out of its range.
bool read_tick(ByteReader& in, loop::UserCommand& command) {
    const int fields = in.byte();
    if ((fields & ~kAllFields) != 0) return false;
    if ((fields & kMoveField) != 0) {
        command.move_right = std::int8_t(in.byte());
        command.move_ahead = std::int8_t(in.byte());
    }
    const auto moved = [&](std::int32_t& value) {
        // Wraps instead of overflowing; what is out of range is found below.
        const auto sum = std::int64_t(std::uint64_t(unfold_sign(in.grouped())) + std::uint64_t(std::int64_t(value)));
        value = std::int32_t(sum);
        return sum == value;
    };
    bool good = true;
    if ((fields & kYawField) != 0) good &= moved(command.yaw_urad);
    if ((fields & kPitchField) != 0) good &= moved(command.pitch_urad);
    if ((fields & kButtonsField) != 0) command.buttons = std::uint16_t(in.fixed(2));
    return good;
}

}  // namespace

Result<Recording> parse_recording(std::span<const std::byte> bytes, const std::string& name) {
    ByteReader in(bytes);
    Recording recording;
    FF_ASSIGN(recording.header, read_header(in, bytes, name));
    loop::UserCommand command;
    std::size_t checked = in.at();
    const auto damaged = [&](std::size_t at, const std::string& what) {
        return bad_input(fmt::format("{}:byte {}: {}, in or after tick {}; the file is damaged", name, at, what,
                                     recording.commands.size()));
    };
    while (in.left() > 0 && !recording.closed) {
        const std::size_t at = in.at();
        const auto kind = RecordKind(in.byte());
        switch (kind) {
            case RecordKind::tick: {
                if (recording.commands.size() != recording.digests.size())
                    return damaged(at, "a tick before the last one's state");
                if (recording.commands.size() >= Recording::kMaxTicks) return damaged(at, "too many ticks");
                loop::UserCommand next = command;
                const bool good = read_tick(in, next);
                if (in.ended()) break;
                if (!good) return damaged(at, "a command out of range");
                recording.commands.push_back(command = next);
                break;
            }
            case RecordKind::state: {
                if (recording.commands.size() != recording.digests.size() + 1)
                    return damaged(at, "a state without a tick");
                StateDigest digest;
                digest.all = in.fixed(8);
                const auto lanes = in.raw(digest.lanes.size());
                if (in.ended()) break;
                std::memcpy(digest.lanes.data(), lanes.data(), lanes.size());
                recording.digests.push_back(digest);
                break;
            }
            case RecordKind::marker: {
                const std::uint64_t size = in.grouped();
                if (!in.ended() && size > Recording::kMaxCommentBytes)
                    return damaged(at, fmt::format("a comment of {} bytes", size));
                std::string comment = in.text(size);
                if (!in.ended()) recording.markers.push_back({recording.digests.size(), std::move(comment)});
                break;
            }
            case RecordKind::check: {
                const std::uint64_t hash = hash_bytes(bytes.subspan(checked, at - checked));
                const std::uint64_t expected = in.fixed(8);
                if (in.ended()) break;
                if (hash != expected) return damaged(at, "a checksum that differs from the records before it");
                checked = in.at();
                break;
            }
            case RecordKind::end:
                recording.closed = true;
                break;
            default:
                return damaged(at, fmt::format("a record of unknown kind {}", int(kind)));
        }
        if (in.ended()) break;  // cut in the middle of this record
    }
    if (recording.closed && in.left() > 0)
        return damaged(in.at(), fmt::format("{} bytes after the end of the session", in.left()));
    return recording;
}

Result<Recording> load_recording(const std::filesystem::path& path) {
    std::ifstream file(path, std::ios::binary | std::ios::ate);
    if (!file) return bad_input(fmt::format("{}: cannot be read", path.string()));
    const auto size = std::size_t(std::max<std::streamoff>(0, file.tellg()));
    std::vector<std::byte> bytes(size);
    file.seekg(0);
    file.read(reinterpret_cast<char*>(bytes.data()), std::streamsize(size));
    if (!file) return bad_input(fmt::format("{}: cannot be read", path.string()));
    return parse_recording(bytes, path.string());
}

}  // namespace ff::replay
