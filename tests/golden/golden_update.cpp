// Draws the golden images anew, into the source tree. Look at what changed before committing it.

#include "engine/core/log.h"
#include "engine/platform/headless.h"
#include "tests/golden/golden_compare.h"
#include "tests/golden/golden_shots.h"
#include "tools/picture/picture_file.h"

namespace {

ff::Status update() {
    FF_ASSIGN(const ff::platform::HeadlessContext context, ff::platform::HeadlessContext::open());
    FF_ASSIGN(const auto studio, ff::test::GoldenStudio::open());
    for (const ff::test::GoldenShot& shot : ff::test::golden_shots()) {
        const std::filesystem::path path = ff::test::golden_path(shot.name);
        FF_TRY(ff::tool::write_image(path, studio->draw(shot)));
        ff::log_info("{}", path.string());
    }
    return {};
}

}  // namespace

int main() {
    const ff::Status status = update();
    if (status) return 0;
    ff::log_line("golden_update: error: ", status.error().message);
    return int(status.error().kind);
}
