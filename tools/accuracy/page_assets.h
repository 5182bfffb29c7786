#pragma once
// The parts of the lab's page, made from page/ and Chart.js when the tool is built.

#include <string_view>

namespace ff::accuracy {

extern const std::string_view kPage_html, kPage_style, kPage_script;
extern const std::string_view kPage_chart;  ///< Chart.js, minified

}  // namespace ff::accuracy
