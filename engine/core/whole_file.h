#pragma once
// A file that appears whole or not at all, at whatever moment the process or the machine ends.

#include <cstdint>
#include <filesystem>
#include <span>

#include "engine/core/result.h"

namespace ff {

enum class Flush : unsigned char {
    to_disk,  ///< fsync: the file is there after the machine lost its power
    none,     ///< for what is checked when it is read and can be made again
};

/// Written without a name where the file system can do that, so that a killed process leaves nothing behind; else
/// beside its place. What stood there before stays until commit().
class WholeFile {
  public:
    /// Errors: the folder is not there or cannot be written.
    static Result<WholeFile> create(const std::filesystem::path& path);
    WholeFile(WholeFile&& other) noexcept;
    WholeFile& operator=(WholeFile&& other) noexcept;
    /// Without commit(): as if it had never been.
    ~WholeFile();

    /// Appends. Errors: a full disk.
    Status write(std::span<const std::byte> bytes);
    /// Overwrites what was written. Errors: likewise.
    Status write_at(std::uint64_t offset, std::span<const std::byte> bytes);
    /// The file takes its place. Errors: then it does not, and what stood there stays.
    Status commit(Flush flush = Flush::to_disk);

  private:
    WholeFile() = default;
    [[nodiscard]] Error error(const char* what) const;
    Status link_and_rename();
    void drop();

    std::filesystem::path path_;
    std::filesystem::path part_;  ///< its name until commit()
    int fd_ = -1;
    bool has_name_ = false;
};

}  // namespace ff
