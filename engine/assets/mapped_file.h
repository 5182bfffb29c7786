#pragma once

#include <cstddef>
#include <filesystem>
#include <span>

#include "engine/core/result.h"

namespace ff::assets {

/// A file's bytes, mapped read-only; unmapped when it dies. The file must not be cut short meanwhile (writers in this
/// code base replace files by rename, which leaves the mapped one whole).
class MappedFile {
  public:
    /// Errors: bad_input where the file is not there, not readable or no regular file.
    static Result<MappedFile> open(const std::filesystem::path& path);

    MappedFile() = default;
    MappedFile(MappedFile&& other) noexcept;
    MappedFile& operator=(MappedFile&& other) noexcept;
    ~MappedFile();

    [[nodiscard]] std::span<const std::byte> bytes() const { return bytes_; }

  private:
    std::span<const std::byte> bytes_;
};

}  // namespace ff::assets
