#include "engine/farfield/visibility_difference.h"

#include <cmath>

#include "engine/core/check.h"

namespace ff::farfield {

bool is_wrong_pixel(const VisibilityBuffer& answers, const VisibilityBuffer& truth, std::size_t at) {
    const bool is_sky = answers.instance[at] == kSkyInstance, should_be_sky = truth.instance[at] == kSkyInstance;
    if (is_sky || should_be_sky) return is_sky != should_be_sky;
    if (answers.instance[at] == truth.instance[at] && answers.triangle[at] == truth.triangle[at]) return false;
    // Not-a-number is wrong.
    return !(std::fabs(answers.depth[at] - truth.depth[at]) <= kTieShare * truth.depth[at]);
}

std::uint64_t count_wrong_pixels(const VisibilityBuffer& answers, const VisibilityBuffer& truth) {
    FF_CHECK(answers.width == truth.width && answers.height == truth.height, "{}x{} against {}x{}", answers.width,
             answers.height, truth.width, truth.height);
    std::uint64_t wrong = 0;
    for (int y = 0; y < truth.height; ++y)
        for (int x = 0; x < truth.width; ++x) wrong += is_wrong_pixel(answers, truth, truth.index(x, y));
    return wrong;
}

}  // namespace ff::farfield
