#include "engine/platform/input.h"

#include <algorithm>
#include <cmath>

namespace ff::platform {

void apply_dead_zone(float& x, float& y, float dead_zone) {
    const float length = std::sqrt(x * x + y * y);
    if (!(length > dead_zone)) {  // also NaN
        x = y = 0.0f;
        return;
    }
    const float scale = std::min((length - dead_zone) / (1.0f - dead_zone), 1.0f) / length;
    x *= scale;
    y *= scale;
}

}  // namespace ff::platform
