#include "engine/loop/save_game.h"

#include <fmt/format.h>

#include <cstring>

#include "engine/core/byte_stream.h"
#include "engine/core/hash.h"
#include "engine/core/write_file.h"

namespace ff::loop {
namespace {

constexpr std::string_view kMagic = "FFSAVE1\n";
/// magic, version, length of the name, the name, length of the state, the state, xxHash3 of all that.
constexpr std::size_t kLeastBytes = kMagic.size() + 4 + 1 + 8 + 8;

Result<std::vector<std::byte>> read_bytes(const std::filesystem::path& path) {
    FF_ASSIGN(const std::string text, read_text_file(path));
    const auto* first = reinterpret_cast<const std::byte*>(text.data());
    return std::vector<std::byte>(first, first + text.size());
}

}  // namespace

std::filesystem::path previous_save(const std::filesystem::path& path) {
    std::filesystem::path previous = path;
    previous += ".previous";
    return previous;
}

Status write_save(const std::filesystem::path& path, const SavedGame& save) {
    if (save.game.size() > 255) return usage_error("the name of a game has at most 255 bytes");
    std::vector<std::byte> bytes;
    bytes.reserve(kLeastBytes + save.game.size() + save.state.size());
    ByteWriter out(bytes);
    out.raw(kMagic);
    out.fixed(save.version, 4);
    out.byte(std::uint8_t(save.game.size()));
    out.raw(save.game);
    out.fixed(save.state.size(), 8);
    out.raw(save.state);
    out.fixed(hash_bytes(bytes), 8);

    std::error_code error;
    if (path.has_parent_path()) std::filesystem::create_directories(path.parent_path(), error);
    // The new one is on the disk under a name of its own before anything that is there is touched. Between the two
    // renames there is none under its name, and the one before is found.
    std::filesystem::path fresh = path;
    fresh += ".new";
    FF_TRY(write_file_whole(fresh, bytes));
    if (std::filesystem::exists(path, error)) {
        std::filesystem::rename(path, previous_save(path), error);
        if (error)
            return failure(fmt::format("{}: cannot be kept as {}: {}", path.string(), previous_save(path).string(),
                                       error.message()));
    }
    std::filesystem::rename(fresh, path, error);
    if (error) return failure(fmt::format("{}: cannot be replaced: {}", path.string(), error.message()));
    return {};
}

Result<SavedGame> read_save(const std::filesystem::path& path, const std::string& game, std::uint32_t newest) {
    std::error_code ignored;
    if (!std::filesystem::exists(path, ignored))
        return bad_input(fmt::format("{}: there is no such saved game", path.string()));
    FF_ASSIGN(const std::vector<std::byte> bytes, read_bytes(path));
    if (bytes.size() < kLeastBytes || std::memcmp(bytes.data(), kMagic.data(), kMagic.size()) != 0)
        return bad_input(fmt::format("{}: not a saved game, or cut: {} bytes", path.string(), bytes.size()));
    const std::span<const std::byte> content = std::span(bytes).first(bytes.size() - 8);
    if (ByteReader(std::span(bytes).last(8)).fixed(8) != hash_bytes(content))
        return bad_input(fmt::format("{}: damaged: its checksum differs from its contents", path.string()));
    ByteReader in(content);
    (void)in.raw(kMagic.size());
    SavedGame save;
    save.version = std::uint32_t(in.fixed(4));
    save.game = in.text(in.byte());
    const std::uint64_t size = in.fixed(8);
    if (in.ended() || size != in.left()) return bad_input(fmt::format("{}: its lengths do not add up", path.string()));
    const auto state = in.raw(size);
    save.state.assign(state.begin(), state.end());
    if (save.game != game)
        return bad_input(fmt::format("{}: a saved game of '{}', not of '{}'", path.string(), save.game, game));
    if (save.version > newest)
        return bad_input(fmt::format("{}: of version {}; this program reads versions up to {}", path.string(),
                                     save.version, newest));
    return save;
}

Result<LoadedSave> load_save(const std::filesystem::path& path, const std::string& game, std::uint32_t newest) {
    auto save = read_save(path, game, newest);
    if (save) return LoadedSave{std::move(*save), {}};
    auto previous = read_save(previous_save(path), game, newest);
    if (!previous) return bad_input(save.error().message + "; and " + previous.error().message);
    return LoadedSave{std::move(*previous), save.error().message + "; this is the one before it"};
}

}  // namespace ff::loop
