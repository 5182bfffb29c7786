#include "tools/cook/gltf_file.h"

#include <fmt/format.h>

#include <array>
#include <cstring>

#include "tools/cook/image_load.h"

namespace ff::cook {
namespace {

using nlohmann::json;

constexpr std::uint32_t kGlbMagic = 0x46546C67;   // "glTF"
constexpr std::uint32_t kChunkJson = 0x4E4F534A;  // "JSON"
constexpr std::uint32_t kChunkBin = 0x004E4942;   // "BIN\0"

std::uint32_t read_u32(Bytes bytes, std::size_t offset) {
    std::uint32_t value;
    std::memcpy(&value, bytes.data() + offset, sizeof value);
    return value;
}

// Deep nesting would overflow the stack of whatever walks the tree later; brackets inside strings do not count.
bool nests_deeper_than(std::string_view text, int limit) {
    int depth = 0;
    bool in_string = false;
    for (std::size_t i = 0; i < text.size(); ++i) {
        const char c = text[i];
        if (in_string) {
            if (c == '\\')
                ++i;
            else if (c == '"')
                in_string = false;
        } else if (c == '"') {
            in_string = true;
        } else if (c == '[' || c == '{') {
            if (++depth > limit) return true;
        } else if (c == ']' || c == '}') {
            --depth;
        }
    }
    return false;
}

Status parse_json(GltfFile& file, std::string_view text, const char* place) {
    if (nests_deeper_than(text, kMaxJsonDepth))
        return file.error(place, fmt::format("nests deeper than {} levels; expected a glTF document", kMaxJsonDepth));
    try {
        file.json = json::parse(text);
    } catch (const json::exception& e) {
        return file.error(place, fmt::format("not JSON ({}); expected a glTF document", e.what()));
    }
    if (!file.json.is_object())
        return file.error(place, fmt::format("JSON {}; expected an object", file.json.type_name()));
    return {};
}

// glTF 2.0 section 4.4: header (magic, version, length), then chunks (length, type, data): JSON, BIN, and others to be
// skipped.
Status split_glb(GltfFile& file, CookContext& context) {
    Bytes bytes = file.file_bytes;
    if (bytes.size() < 20) return file.error("GLB header", fmt::format("{} bytes; expected at least 20", bytes.size()));
    if (const auto version = read_u32(bytes, 4); version != 2)
        return file.error("GLB header", fmt::format("version {}; expected 2", version));
    const std::uint32_t file_length = read_u32(bytes, 8);
    if (file_length > bytes.size() || file_length < 20)
        return file.error("GLB header",
                          fmt::format("length {}; expected the file's size, {}", file_length, bytes.size()));
    if (file_length < bytes.size())
        context.warn(
            fmt::format("{}: {} bytes behind the end of the GLB; left out", file.name, bytes.size() - file_length));
    bytes = bytes.first(file_length);

    bool has_json = false;
    std::string_view text;
    int chunk = 0;
    for (std::size_t at = 12; at < bytes.size(); ++chunk) {
        const std::string place = fmt::format("GLB chunk {} at byte {}", chunk, at);
        if (bytes.size() - at < 8)
            return file.error(place, fmt::format("cut after {} bytes; expected 8 of header", bytes.size() - at));
        const std::uint32_t length = read_u32(bytes, at), type = read_u32(bytes, at + 4);
        at += 8;
        if (length > bytes.size() - at)
            return file.error(place,
                              fmt::format("length {}; expected at most the {} bytes left", length, bytes.size() - at));
        const Bytes data = bytes.subspan(at, length);
        if (chunk == 0 && type != kChunkJson)
            return file.error(place, fmt::format("type 0x{:08X}; expected JSON first", type));
        if (type == kChunkJson) {
            if (has_json) return file.error(place, "a second JSON chunk; expected one");
            has_json = true;
            text = {reinterpret_cast<const char*>(data.data()), data.size()};
        } else if (type == kChunkBin) {
            if (file.has_binary_chunk) return file.error(place, "a second BIN chunk; expected one");
            if (chunk != 1) return file.error(place, "BIN; expected it right after the JSON chunk");
            file.has_binary_chunk = true;
            file.binary_chunk = data;
        }
        at += length;
    }
    if (!has_json) return file.error("GLB", "no JSON chunk; expected one");
    return parse_json(file, text, "GLB chunk 0");
}

int base64_digit(char c) {
    if (c >= 'A' && c <= 'Z') return c - 'A';
    if (c >= 'a' && c <= 'z') return c - 'a' + 26;
    if (c >= '0' && c <= '9') return c - '0' + 52;
    if (c == '+' || c == '-') return 62;
    if (c == '/' || c == '_') return 63;
    return -1;
}

// False at the first character that is not of the alphabet (RFC 4648, both alphabets; padding optional).
bool decode_base64(std::string_view text, std::vector<std::byte>& out) {
    while (!text.empty() && text.back() == '=') text.remove_suffix(1);
    if (text.size() % 4 == 1) return false;
    out.reserve(text.size() * 3 / 4);
    std::uint32_t bits = 0;
    int bit_count = 0;
    for (const char c : text) {
        const int digit = base64_digit(c);
        if (digit < 0) return false;
        bits = bits << 6 | static_cast<std::uint32_t>(digit);
        bit_count += 6;
        if (bit_count >= 8) {
            bit_count -= 8;
            out.push_back(static_cast<std::byte>(bits >> bit_count & 0xFF));
        }
    }
    return true;
}

int hex_digit(char c) {
    if (c >= '0' && c <= '9') return c - '0';
    if (c >= 'a' && c <= 'f') return c - 'a' + 10;
    if (c >= 'A' && c <= 'F') return c - 'A' + 10;
    return -1;
}

std::string percent_decode(std::string_view text) {
    std::string out;
    out.reserve(text.size());
    for (std::size_t i = 0; i < text.size(); ++i) {
        if (text[i] == '%' && i + 2 < text.size() && hex_digit(text[i + 1]) >= 0 && hex_digit(text[i + 2]) >= 0) {
            out += static_cast<char>(hex_digit(text[i + 1]) * 16 + hex_digit(text[i + 2]));
            i += 2;
        } else {
            out += text[i];
        }
    }
    return out;
}

std::string shortened(const std::string& text) {
    return text.size() <= 60 ? text : text.substr(0, 57) + "...";
}

// "scheme:" of RFC 3986; empty for a relative reference.
std::string_view uri_scheme(std::string_view uri) {
    const std::size_t end = uri.find_first_not_of("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789+.-");
    return end != std::string_view::npos && end > 0 && uri[end] == ':' ? uri.substr(0, end) : std::string_view{};
}

Result<Bytes> decode_data_uri(GltfFile& file, std::string_view uri, const std::string& place) {
    const std::size_t comma = uri.find(',');
    if (comma == std::string_view::npos)
        return file.error(place, fmt::format("`{}`; expected data:TYPE;base64,DATA", shortened(std::string(uri))));
    auto data = std::make_unique<std::vector<std::byte>>();
    if (uri.substr(0, comma).ends_with(";base64")) {
        if (!decode_base64(uri.substr(comma + 1), *data))
            return file.error(place, "data that is not base64; expected base64 after the comma");
    } else {
        const std::string text = percent_decode(uri.substr(comma + 1));
        const auto bytes = std::as_bytes(std::span(text.data(), text.size()));
        data->assign(bytes.begin(), bytes.end());
    }
    file.loaded.push_back(std::move(data));
    return Bytes(*file.loaded.back());
}

}  // namespace

Error GltfFile::error(const std::string& place, const std::string& found_and_expected) const {
    return bad_input(fmt::format("{}: {}: {}", name, place, found_and_expected));
}

Result<GltfFile> open_gltf(const std::filesystem::path& path, CookContext& context) {
    GltfFile file;
    file.name = path.string();
    file.folder = path.parent_path();
    FF_ASSIGN(file.file_bytes, read_file_bytes(path));
    file.context = &context;
    context.add_input(path, file.file_bytes.size());
    if (file.file_bytes.empty()) return file.error("byte 0", "an empty file; expected glTF");
    if (file.file_bytes.size() >= 4 && read_u32(file.file_bytes, 0) == kGlbMagic) {
        FF_TRY(split_glb(file, context));
    } else {
        const char* text = reinterpret_cast<const char*>(file.file_bytes.data());
        FF_TRY(parse_json(file, {text, file.file_bytes.size()}, "document"));
    }
    return file;
}

Result<Bytes> load_uri(GltfFile& file, const std::string& uri, const std::string& place) {
    const std::string_view scheme = uri_scheme(uri);
    if (scheme == "data") return decode_data_uri(file, uri, place);
    if (!scheme.empty() || uri.empty())
        return file.error(place, fmt::format("`{}`; expected data: or a relative path", shortened(uri)));

    const std::filesystem::path relative = std::filesystem::path(percent_decode(uri)).lexically_normal();
    auto part = relative.begin();
    if (part != relative.end() && *part == "..") ++part;
    if (relative.is_absolute() || (part != relative.end() && *part == "..") ||
        relative.native().find('\0') != std::string::npos)
        return file.error(place, fmt::format("`{}`; expected a path near the model's folder", shortened(uri)));
    auto bytes = read_file_bytes(file.folder / relative);
    if (!bytes) return file.error(place, fmt::format("`{}`: {}", shortened(uri), bytes.error().message));
    file.context->add_input(file.folder / relative, bytes->size());
    file.loaded.push_back(std::make_unique<std::vector<std::byte>>(std::move(*bytes)));
    return Bytes(*file.loaded.back());
}

Status load_buffers(GltfFile& file) {
    const auto found = file.json.find("buffers");
    if (found == file.json.end()) return {};
    for (std::size_t i = 0; i < found->size(); ++i) {
        const json& buffer = (*found)[i];
        const std::string place = fmt::format("buffers[{}]", i);
        const auto length = buffer.at("byteLength").get<std::uint64_t>();
        Bytes bytes;
        if (const auto uri = buffer.find("uri"); uri != buffer.end()) {
            FF_ASSIGN(bytes, load_uri(file, uri->get_ref<const std::string&>(), place + ".uri"));
        } else if (i == 0 && file.has_binary_chunk) {
            bytes = file.binary_chunk;
        } else {
            file.buffers.emplace_back();  // allowed as long as nobody reads it, as behind EXT_meshopt_compression
            continue;
        }
        if (bytes.size() < length)
            return file.error(place + ".byteLength",
                              fmt::format("{}; expected at most the {} bytes that there are", length, bytes.size()));
        file.buffers.push_back(bytes.first(length));
    }
    return {};
}

}  // namespace ff::cook
