#pragma once
// Pages as a browser shows them.

#include <filesystem>
#include <string>

namespace ff::test {

struct PageCheck {
    std::string title;  ///< of the document, as the script leaves it
    std::string log;    ///< of the browser, what the page writes to its console included
};

/// Opens a page in headless Chromium and runs a script after its own.
/// @param script  writes what it found into document.title when it has come to its end
/// @param folder  for the page and the browser's files
[[nodiscard]] PageCheck check_page(const std::string& page, const std::string& script,
                                   const std::filesystem::path& folder);

}  // namespace ff::test
