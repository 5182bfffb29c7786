#pragma once
// A report as one HTML file that asks the network for nothing.

#include <string>
#include <string_view>

#include "engine/core/result.h"
#include "engine/shading/shading_pass.h"

namespace ff::page {

/// What a page is made of. The HTML names where the others go: {{style}}, {{data}}, {{chart}}, {{script}}.
struct PageParts {
    std::string_view html, style;
    std::string_view chart;  ///< Chart.js, minified
    std::string_view script;
};

/// The page with its data.
/// @param json  what the script finds in the element "data"
[[nodiscard]] std::string fill_page(const PageParts& parts, const std::string& json);

/// The bytes of a JPEG file as a URL that holds them.
[[nodiscard]] std::string jpeg_url(std::string_view bytes);

/// A picture as such a URL. Errors: no place for the file that it is coded through.
Result<std::string> picture_url(const shading::Image& image);

}  // namespace ff::page
