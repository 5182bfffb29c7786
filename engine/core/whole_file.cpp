#include "engine/core/whole_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <ctime>
#include <utility>

namespace ff {
namespace {

std::filesystem::path folder_of(const std::filesystem::path& path) {
    return path.has_parent_path() ? path.parent_path() : std::filesystem::path(".");
}

/// Whether a name is older than the moment that it should live.
bool was_left(const std::filesystem::path& path) {
    constexpr time_t kMomentS = 2;
    struct stat status {};
    return ::stat(path.c_str(), &status) == 0 && ::time(nullptr) - status.st_ctim.tv_sec > kMomentS;
}

}  // namespace

WholeFile::WholeFile(WholeFile&& other) noexcept
    : path_(std::move(other.path_)),
      part_(std::move(other.part_)),
      fd_(std::exchange(other.fd_, -1)),
      has_name_(std::exchange(other.has_name_, false)) {}

WholeFile& WholeFile::operator=(WholeFile&& other) noexcept {
    if (this == &other) return *this;
    drop();
    path_ = std::move(other.path_);
    part_ = std::move(other.part_);
    fd_ = std::exchange(other.fd_, -1);
    has_name_ = std::exchange(other.has_name_, false);
    return *this;
}

WholeFile::~WholeFile() {
    drop();
}

void WholeFile::drop() {
    if (fd_ >= 0) ::close(std::exchange(fd_, -1));
    if (std::exchange(has_name_, false)) ::unlink(part_.c_str());
}

Error WholeFile::error(const char* what) const {
    return failure(fmt::format("{}: cannot {}: {}", path_.string(), what, std::strerror(errno)));
}

Result<WholeFile> WholeFile::create(const std::filesystem::path& path) {
    WholeFile file;
    file.path_ = path;
    file.part_ = fmt::format("{}.part{}", path.string(), ::getpid());
    file.fd_ = ::open(folder_of(path).c_str(), O_TMPFILE | O_WRONLY | O_CLOEXEC, 0644);
    if (file.fd_ < 0) {
        file.fd_ = ::open(file.part_.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644);
        file.has_name_ = file.fd_ >= 0;
    }
    if (file.fd_ < 0) return file.error("create");
    return file;
}

Status WholeFile::write(std::span<const std::byte> bytes) {
    while (!bytes.empty()) {
        const ssize_t written = ::write(fd_, bytes.data(), bytes.size());
        if (written < 0 && errno == EINTR) continue;
        if (written < 0) return error("write");
        bytes = bytes.subspan(std::size_t(written));
    }
    return {};
}

Status WholeFile::write_at(std::uint64_t offset, std::span<const std::byte> bytes) {
    while (!bytes.empty()) {
        const ssize_t written = ::pwrite(fd_, bytes.data(), bytes.size(), off_t(offset));
        if (written < 0 && errno == EINTR) continue;
        if (written < 0) return error("write");
        bytes = bytes.subspan(std::size_t(written));
        offset += std::uint64_t(written);
    }
    return {};
}

/// Between its name beside its place and its place lies a moment in which a process may be killed. That name is the
/// same for all, so that a later one finds what was left there, and takes it away; unless another process may be in
/// that moment now.
Status WholeFile::link_and_rename() {
    const std::string source = fmt::format("/proc/self/fd/{}", fd_);
    const auto link = [&] {
        return ::linkat(AT_FDCWD, source.c_str(), AT_FDCWD, part_.c_str(), AT_SYMLINK_FOLLOW) == 0;
    };
    const std::string own_part = part_.string();
    part_ = path_.string() + ".part";
    bool linked = link();
    if (!linked && errno == EEXIST) {
        if (was_left(part_)) {
            ::unlink(part_.c_str());
        } else {
            part_ = own_part;
        }
        linked = link();
    }
    if (!linked) return error("create");
    if (::rename(part_.c_str(), path_.c_str()) == 0) return {};
    const Error refused = error("be replaced");
    ::unlink(part_.c_str());
    return refused;
}

Status WholeFile::commit(Flush flush) {
    if (flush == Flush::to_disk && ::fsync(fd_) != 0) return error("sync");
    if (has_name_) {
        if (::rename(part_.c_str(), path_.c_str()) != 0) return error("be replaced");
    } else {
        FF_TRY(link_and_rename());
    }
    has_name_ = false;
    drop();
    return {};
}

}  // namespace ff
