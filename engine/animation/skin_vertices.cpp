#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "engine/animation/skin_vertices.cpp"
#include <hwy/foreach_target.h>  // must come before highway.h
#include <hwy/highway.h>

#include <algorithm>
#include <cstring>

#include "engine/animation/skin_vertices.h"

HWY_BEFORE_NAMESPACE();
namespace ff::animation {
namespace HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;
using F = hn::CappedTag<float, 16>;
using VF = hn::Vec<F>;
constexpr F f;
constexpr hn::RebindToUnsigned<F> ui;
constexpr hn::FixedTag<float, 4> f4;
constexpr std::size_t kBlock = 64;  // vertices: 4 KiB of blended matrices on the stack
static_assert(kBlock % kSkinPadding == 0 && kSkinPadding % std::size_t(hn::MaxLanes(f)) == 0);

/// Each vertex's mean matrix, a column an array.
struct Blended {
    alignas(64) float column[4][4 * kBlock];
};

HWY_INLINE void blend(const SkinTables& skin, const JointColumns* matrices, std::size_t first, std::size_t count,
                      Blended& out) {
    const std::size_t influences = skin.influences;
    for (std::size_t v = 0; v < count; ++v) {
        const std::uint16_t* joint = skin.joints.data() + (first + v) * influences;
        const float* weight = skin.weights.data() + (first + v) * influences;
        const JointColumns* m = matrices + joint[0];
        auto w = hn::Set(f4, weight[0]);
        auto c0 = hn::Mul(w, hn::Load(f4, m->column[0])), c1 = hn::Mul(w, hn::Load(f4, m->column[1]));
        auto c2 = hn::Mul(w, hn::Load(f4, m->column[2])), c3 = hn::Mul(w, hn::Load(f4, m->column[3]));
        for (std::size_t i = 1; i < influences && weight[i] > 0.0f; ++i) {  // greatest first
            m = matrices + joint[i];
            w = hn::Set(f4, weight[i]);
            c0 = hn::MulAdd(w, hn::Load(f4, m->column[0]), c0);
            c1 = hn::MulAdd(w, hn::Load(f4, m->column[1]), c1);
            c2 = hn::MulAdd(w, hn::Load(f4, m->column[2]), c2);
            c3 = hn::MulAdd(w, hn::Load(f4, m->column[3]), c3);
        }
        hn::Store(c0, f4, out.column[0] + 4 * v);
        hn::Store(c1, f4, out.column[1] + 4 * v);
        hn::Store(c2, f4, out.column[2] + 4 * v);
        hn::Store(c3, f4, out.column[3] + 4 * v);
    }
}

struct V3 {
    VF x, y, z;
};

HWY_INLINE V3 load_column(const Blended& blended, int column, std::size_t v) {
    V3 out;
    VF unused;
    hn::LoadInterleaved4(f, blended.column[column] + 4 * v, out.x, out.y, out.z, unused);
    return out;
}
HWY_INLINE V3 cross(const V3& a, const V3& b) {
    return {hn::MulSub(a.y, b.z, hn::Mul(a.z, b.y)), hn::MulSub(a.z, b.x, hn::Mul(a.x, b.z)),
            hn::MulSub(a.x, b.y, hn::Mul(a.y, b.x))};
}
/// a * x + b * y + c * z
HWY_INLINE V3 combined(const V3& a, VF x, const V3& b, VF y, const V3& c, VF z) {
    return {hn::MulAdd(a.x, x, hn::MulAdd(b.x, y, hn::Mul(c.x, z))),
            hn::MulAdd(a.y, x, hn::MulAdd(b.y, y, hn::Mul(c.y, z))),
            hn::MulAdd(a.z, x, hn::MulAdd(b.z, y, hn::Mul(c.z, z)))};
}

/// As scene::encode_normal, both numbers in one; a normal without length points up.
HWY_INLINE hn::Vec<decltype(ui)> encode(const V3& n) {
    const VF zero = hn::Zero(f), one = hn::Set(f, 1.0f);
    const VF sum = hn::Add(hn::Abs(n.x), hn::Add(hn::Abs(n.y), hn::Abs(n.z)));
    const auto has_length = hn::Gt(sum, zero);
    const VF per_sum = hn::Div(one, hn::IfThenElse(has_length, sum, one));
    VF x = hn::Mul(n.x, per_sum), y = hn::IfThenElse(has_length, hn::Mul(n.y, per_sum), one);
    const auto sign_of = [&](VF v) { return hn::IfThenElse(hn::Ge(v, zero), one, hn::Neg(one)); };
    const auto folds = hn::Lt(n.z, zero);
    const VF folded_x = hn::Mul(hn::Sub(one, hn::Abs(y)), sign_of(x));
    const VF folded_y = hn::Mul(hn::Sub(one, hn::Abs(x)), sign_of(y));
    x = hn::IfThenElse(folds, folded_x, x);
    y = hn::IfThenElse(folds, folded_y, y);
    const VF scale = hn::Set(f, 32767.0f);
    const auto bits = [&](VF v) {
        return hn::BitCast(ui, hn::NearestInt(hn::Mul(hn::Min(hn::Max(v, hn::Neg(one)), one), scale)));
    };
    return hn::Or(hn::And(bits(x), hn::Set(ui, 0xFFFFu)), hn::ShiftLeft<16>(bits(y)));
}

void SkinVertices(const SkinTables& skin, const JointColumns* matrices, Vec3* positions,
                  scene::VertexAttributes* attributes) {
    Blended blended;
    std::memset(&blended, 0, sizeof blended);  // lanes past the last vertex are computed, too
    alignas(64) float moved[3 * kBlock];
    alignas(64) std::uint32_t normals[kBlock];
    for (std::size_t first = 0; first < skin.vertex_count; first += kBlock) {
        const std::size_t count = std::min<std::size_t>(kBlock, skin.vertex_count - first);
        blend(skin, matrices, first, count, blended);
        for (std::size_t v = 0; v < count; v += hn::Lanes(f)) {
            const V3 a = load_column(blended, 0, v), b = load_column(blended, 1, v), c = load_column(blended, 2, v);
            const V3 d = load_column(blended, 3, v);
            const auto at = [&](const std::vector<float>& array) { return hn::LoadU(f, array.data() + first + v); };
            const V3 p = combined(a, at(skin.x), b, at(skin.y), c, at(skin.z));
            hn::StoreInterleaved3(hn::Add(p.x, d.x), hn::Add(p.y, d.y), hn::Add(p.z, d.z), f, moved + 3 * v);
            V3 n = combined(cross(b, c), at(skin.normal_x), cross(c, a), at(skin.normal_y), cross(a, b),
                            at(skin.normal_z));
            hn::Store(encode(n), ui, normals + v);
        }
        std::memcpy(static_cast<void*>(positions + first), moved, count * sizeof(Vec3));
        for (std::size_t v = 0; v < count; ++v)
            std::memcpy(attributes[first + v].normal_oct, normals + v, sizeof attributes->normal_oct);
    }
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace ff::animation
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace ff::animation {

HWY_EXPORT(SkinVertices);

void skin_vertices(const SkinTables& skin, std::span<const JointColumns> matrices, Vec3* positions,
                   scene::VertexAttributes* attributes) {
    HWY_DYNAMIC_DISPATCH(SkinVertices)(skin, matrices.data(), positions, attributes);
}

}  // namespace ff::animation
#endif
