#include "engine/assets/mapped_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <utility>

namespace ff::assets {

Result<MappedFile> MappedFile::open(const std::filesystem::path& path) {
    const int fd = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
    if (fd < 0) return bad_input(fmt::format("{}: cannot open: {}", path.string(), std::strerror(errno)));
    struct stat info {};
    MappedFile file;
    Status status;
    if (::fstat(fd, &info) != 0) {
        status = bad_input(fmt::format("{}: cannot look at it: {}", path.string(), std::strerror(errno)));
    } else if (!S_ISREG(info.st_mode)) {
        status = bad_input(fmt::format("{}: not a file; expected a regular file", path.string()));
    } else if (info.st_size > 0) {
        const auto size = static_cast<std::size_t>(info.st_size);
        void* data = ::mmap(nullptr, size, PROT_READ, MAP_PRIVATE, fd, 0);
        if (data == MAP_FAILED)
            status = failure(fmt::format("{}: cannot map {} bytes: {}", path.string(), size, std::strerror(errno)));
        else
            file.bytes_ = {static_cast<const std::byte*>(data), size};
    }
    ::close(fd);
    if (!status) return status.error();
    return file;
}

MappedFile::MappedFile(MappedFile&& other) noexcept : bytes_(std::exchange(other.bytes_, {})) {}

MappedFile& MappedFile::operator=(MappedFile&& other) noexcept {
    std::swap(bytes_, other.bytes_);
    return *this;
}

MappedFile::~MappedFile() {
    if (!bytes_.empty()) ::munmap(const_cast<std::byte*>(bytes_.data()), bytes_.size());
}

}  // namespace ff::assets
