#include "tests/e2e/browser.h"

#include "tests/e2e/run_process.h"

namespace ff::test {

PageCheck check_page(const std::string& page, const std::string& script, const std::filesystem::path& folder) {
    const std::string running = "the check has not come to its end";
    std::string checked = page;
    const std::size_t end = checked.rfind("</body>");
    if (end == std::string::npos) return {"a page without an end", ""};
    checked.insert(end, "<script>document.title = '" + running + "'; window.addEventListener('load', () => " +
                            "setTimeout(() => {" + script + "}, 200));</script>");
    const std::filesystem::path file = folder / "checked.html";
    write_file(file, checked);
    PageCheck result;
    // The browser's virtual time does not wait for pictures that are decoded: on a loaded machine it may be over first.
    for (int attempt = 0; attempt < 5; ++attempt) {
        const ProcessResult browser =
            run("timeout 120 chromium --headless --no-sandbox --disable-gpu --disable-dev-shm-usage "
                "--window-size=1280,900 --user-data-dir=" +
                (folder / "browser").string() +
                " --virtual-time-budget=8000 --enable-logging=stderr --dump-dom 'file://" + file.string() + "'");
        const std::size_t title = browser.out.find("<title>"), close = browser.out.find("</title>");
        result.title = close == std::string::npos ? "no title" : browser.out.substr(title + 7, close - title - 7);
        result.log = browser.err;
        if (result.title != running) break;
    }
    return result;
}

}  // namespace ff::test
