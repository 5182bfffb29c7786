#include "tools/page/page.h"

#include <fmt/format.h>
#include <unistd.h>

#include <cstdint>
#include <filesystem>
#include <utility>

#include "engine/core/write_file.h"
#include "tools/picture/picture_file.h"

namespace ff::page {
namespace {

std::string base64(std::string_view bytes) {
    static constexpr char kDigits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string text;
    text.reserve((bytes.size() + 2) / 3 * 4);
    for (std::size_t i = 0; i < bytes.size(); i += 3) {
        std::uint32_t group = 0;
        for (std::size_t j = 0; j < 3; ++j)
            group = group << 8 | (i + j < bytes.size() ? std::uint8_t(bytes[i + j]) : 0u);
        for (std::size_t j = 0; j < 4; ++j) text += i + j > bytes.size() ? '=' : kDigits[group >> (18 - 6 * j) & 63u];
    }
    return text;
}

/// Text that may stand inside a <script> element: nothing in it ends the element.
std::string for_script(std::string text) {
    for (std::size_t at = 0; (at = text.find("</", at)) != std::string::npos; at += 3) text.replace(at, 2, "<\\/");
    return text;
}

}  // namespace

std::string fill_page(const PageParts& parts, const std::string& json) {
    const std::pair<std::string_view, std::string> texts[] = {{"style", std::string(parts.style)},
                                                              {"data", for_script(json)},
                                                              {"chart", for_script(std::string(parts.chart))},
                                                              {"script", std::string(parts.script)}};
    std::string page;
    std::string_view left = parts.html;
    while (!left.empty()) {
        const std::size_t open = left.find("{{"), close = left.find("}}", open);
        page += left.substr(0, open);
        if (open == std::string_view::npos) break;
        for (const auto& [name, text] : texts)
            if (left.substr(open + 2, close - open - 2) == name) page += text;
        left.remove_prefix(close + 2);
    }
    return page;
}

std::string jpeg_url(std::string_view bytes) {
    return "data:image/jpeg;base64," + base64(bytes);
}

Result<std::string> picture_url(const shading::Image& image) {
    // OpenImageIO writes JPEG into files alone.
    const auto path = std::filesystem::temp_directory_path() / fmt::format("farfield-picture-{}.jpg", ::getpid());
    FF_TRY(tool::write_image(path, image));
    auto bytes = read_text_file(path);
    std::error_code ignored;
    std::filesystem::remove(path, ignored);
    if (!bytes) return bytes.error();
    return jpeg_url(*bytes);
}

}  // namespace ff::page
