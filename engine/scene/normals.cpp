// Based on: Cigolle, Donow, Evangelakos, Mara, McGuire, Meyer, "A Survey of Efficient Representations for Independent
// Unit Vectors", JCGT 2014 (octahedral map, plain rounding).

#include <algorithm>
#include <cmath>

#include "engine/scene/scene_data.h"

namespace ff::scene {
namespace {
float sign_of(float x) {
    return x >= 0.0f ? 1.0f : -1.0f;
}
std::int16_t snorm16(float x) {
    return std::int16_t(std::lround(std::clamp(x, -1.0f, 1.0f) * 32767.0f));
}
}  // namespace

void encode_normal(const Vec3& normal, std::int16_t out[2]) {
    const float length = std::abs(normal.x) + std::abs(normal.y) + std::abs(normal.z);
    if (!(length > 0.0f) || !std::isfinite(length)) {  // nothing to point along: up
        encode_normal(Vec3(0.0f, 1.0f, 0.0f), out);
        return;
    }
    float x = normal.x / length, y = normal.y / length;
    if (normal.z < 0.0f) {
        const float folded = (1.0f - std::abs(y)) * sign_of(x);
        y = (1.0f - std::abs(x)) * sign_of(y);
        x = folded;
    }
    out[0] = snorm16(x);
    out[1] = snorm16(y);
}

Vec3 decode_normal(const std::int16_t oct[2]) {
    float x = float(oct[0]) / 32767.0f, y = float(oct[1]) / 32767.0f;
    const float z = 1.0f - std::abs(x) - std::abs(y);
    if (z < 0.0f) {
        const float folded = (1.0f - std::abs(y)) * sign_of(x);
        y = (1.0f - std::abs(x)) * sign_of(y);
        x = folded;
    }
    return Vec3(x, y, z) / std::sqrt(x * x + y * y + z * z);
}

}  // namespace ff::scene
