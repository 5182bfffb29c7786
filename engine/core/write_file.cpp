#include "engine/core/write_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <fstream>
#include <iterator>

namespace ff {
namespace {

Status write_all(int fd, std::span<const std::byte> bytes, const std::filesystem::path& path) {
    while (!bytes.empty()) {
        const ssize_t written = ::write(fd, bytes.data(), bytes.size());
        if (written < 0 && errno == EINTR) continue;
        if (written < 0) return failure(fmt::format("{}: cannot write: {}", path.string(), std::strerror(errno)));
        bytes = bytes.subspan(static_cast<std::size_t>(written));
    }
    return {};
}

}  // namespace

Status write_file_whole(const std::filesystem::path& path, std::span<const std::byte> bytes, Flush flush) {
    const auto part = std::filesystem::path(fmt::format("{}.part{}", path.string(), ::getpid()));
    const int fd = ::open(part.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644);
    if (fd < 0) return failure(fmt::format("{}: cannot create: {}", part.string(), std::strerror(errno)));
    Status status = write_all(fd, bytes, part);
    if (status && flush == Flush::to_disk && ::fsync(fd) != 0)
        status = failure(fmt::format("{}: cannot sync: {}", part.string(), std::strerror(errno)));
    ::close(fd);
    if (status && ::rename(part.c_str(), path.c_str()) != 0)
        status =
            failure(fmt::format("{}: cannot rename to {}: {}", part.string(), path.string(), std::strerror(errno)));
    if (!status) ::unlink(part.c_str());
    return status;
}

Status write_file_whole(const std::filesystem::path& path, std::string_view text) {
    return write_file_whole(path, std::as_bytes(std::span(text.data(), text.size())));
}

Result<std::string> read_text_file(const std::filesystem::path& path) {
    std::ifstream in(path, std::ios::binary);
    if (!in) return bad_input(fmt::format("{}: cannot open: {}", path.string(), std::strerror(errno)));
    std::string text{std::istreambuf_iterator<char>(in), {}};
    if (in.bad()) return bad_input(fmt::format("{}: cannot read: {}", path.string(), std::strerror(errno)));
    return text;
}

}  // namespace ff
