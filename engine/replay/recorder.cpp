#include "engine/replay/recorder.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <nlohmann/json.hpp>

#include "engine/core/byte_stream.h"
#include "engine/core/hash.h"
#include "engine/replay/record_kinds.h"

namespace ff::replay {
namespace {

std::string header_text(const SessionHeader& header) {
    return nlohmann::json{{"game", header.game},
                          {"engine_version", header.engine_version},
                          {"pack", header.pack},
                          {"pack_hash", fmt::format("{:016x}", header.pack_hash)},
                          {"seed", fmt::format("{:016x}", header.seed)},
                          {"ticks_per_second", header.ticks_per_second},
                          {"settings", header.settings},
                          {"start_bytes", header.start.size()}}
        .dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

}  // namespace

struct Recorder::Impl {
    std::filesystem::path path;
    int file = -1;
    Status status;
    std::vector<std::byte> pending;    ///< not yet in the system's hands
    std::vector<std::byte> unchecked;  ///< since the last checksum
    loop::UserCommand last;
    int ticks_unchecked = 0;

    ~Impl() {
        if (file >= 0) ::close(file);
    }

    void write_pending() {
        std::size_t done = 0;
        while (status && done < pending.size()) {
            const ssize_t written = ::write(file, pending.data() + done, pending.size() - done);
            if (written < 0 && errno == EINTR) continue;
            if (written <= 0)
                status = failure(
                    fmt::format("{}: cannot write: {}; the recording ends here", path.string(), std::strerror(errno)));
            else
                done += std::size_t(written);
        }
        unchecked.insert(unchecked.end(), pending.begin(), pending.end());
        pending.clear();
    }
    void check() {
        ByteWriter sink(pending);
        write_pending();
        sink.byte(std::uint8_t(RecordKind::check));
        sink.fixed(hash_bytes(unchecked), 8);
        unchecked.clear();
        write_pending();
        unchecked.clear();
        ticks_unchecked = 0;
    }
};

Recorder::Recorder(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Recorder::Recorder(Recorder&&) noexcept = default;
Recorder& Recorder::operator=(Recorder&&) noexcept = default;
Recorder::~Recorder() {
    if (impl_) (void)close();
}

Result<Recorder> Recorder::create(const std::filesystem::path& path, const SessionHeader& header) {
    auto impl = std::make_unique<Impl>();
    impl->path = path;
    std::error_code ignored;
    if (path.has_parent_path()) std::filesystem::create_directories(path.parent_path(), ignored);
    impl->file = ::open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644);
    if (impl->file < 0) return failure(fmt::format("{}: cannot create: {}", path.string(), std::strerror(errno)));
    // Room for the longest second, so that steady ticks allocate nothing.
    impl->pending.reserve(Recording::kMaxCommentBytes + 256);
    impl->unchecked.reserve(2 * Recording::kMaxCommentBytes + kCheckTicks * 128);
    ByteWriter sink(impl->pending);
    sink.raw(kMagic);
    sink.fixed(Recording::kVersion, 4);
    const std::string text = header_text(header);
    sink.fixed(text.size(), 4);
    sink.raw(text);
    sink.raw(header.start);
    sink.fixed(hash_bytes(impl->pending), 8);
    impl->write_pending();
    impl->unchecked.clear();
    if (!impl->status) return impl->status.error();
    return Recorder(std::move(impl));
}

void Recorder::begin_tick(const loop::UserCommand& command) {
    Impl& r = *impl_;
    if (!r.status) return;
    ByteWriter sink(r.pending);
    const bool moves = command.move_right != r.last.move_right || command.move_ahead != r.last.move_ahead;
    const int fields = (moves ? kMoveField : 0) | (command.yaw_urad != r.last.yaw_urad ? kYawField : 0) |
                       (command.pitch_urad != r.last.pitch_urad ? kPitchField : 0) |
                       (command.buttons != r.last.buttons ? kButtonsField : 0);
    sink.byte(std::uint8_t(RecordKind::tick));
    sink.byte(std::uint8_t(fields));
    if ((fields & kMoveField) != 0) {
        sink.byte(std::uint8_t(command.move_right));
        sink.byte(std::uint8_t(command.move_ahead));
    }
    if ((fields & kYawField) != 0) sink.grouped(fold_sign(std::int64_t(command.yaw_urad) - r.last.yaw_urad));
    if ((fields & kPitchField) != 0) sink.grouped(fold_sign(std::int64_t(command.pitch_urad) - r.last.pitch_urad));
    if ((fields & kButtonsField) != 0) sink.fixed(command.buttons, 2);
    r.last = command;
    r.write_pending();
}

void Recorder::end_tick(const StateDigest& digest) {
    Impl& r = *impl_;
    if (!r.status) return;
    ByteWriter sink(r.pending);
    sink.byte(std::uint8_t(RecordKind::state));
    sink.fixed(digest.all, 8);
    sink.raw(std::as_bytes(std::span(digest.lanes)));
    // Goes out with the next tick's command: a system call a tick.
    if (++r.ticks_unchecked >= kCheckTicks) r.check();
}

void Recorder::mark(std::string_view comment) {
    Impl& r = *impl_;
    if (!r.status) return;
    comment = comment.substr(0, Recording::kMaxCommentBytes);
    ByteWriter sink(r.pending);
    sink.byte(std::uint8_t(RecordKind::marker));
    sink.grouped(comment.size());
    sink.raw(comment);
    r.write_pending();
}

Status Recorder::close() {
    Impl& r = *impl_;
    if (r.file < 0) return r.status;
    if (r.status) {
        r.check();
        ByteWriter(r.pending).byte(std::uint8_t(RecordKind::end));
        r.write_pending();
    }
    if (::close(r.file) != 0 && r.status)
        r.status = failure(fmt::format("{}: cannot write: {}", r.path.string(), std::strerror(errno)));
    r.file = -1;
    return r.status;
}

const Status& Recorder::status() const {
    return impl_->status;
}

}  // namespace ff::replay
