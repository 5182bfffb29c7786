#include "engine/core/write_file.h"

#include <fmt/format.h>

#include <cerrno>
#include <cstring>
#include <fstream>
#include <iterator>

namespace ff {

Status write_file_whole(const std::filesystem::path& path, std::span<const std::byte> bytes, Flush flush) {
    FF_ASSIGN(WholeFile file, WholeFile::create(path));
    FF_TRY(file.write(bytes));
    return file.commit(flush);
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
