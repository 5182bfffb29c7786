// Per-target SIMD: lists the triangles that a tile sees.

#if defined(FF_SHADING_TILE_COLLECT_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef FF_SHADING_TILE_COLLECT_INL_H_
#undef FF_SHADING_TILE_COLLECT_INL_H_
#else
#define FF_SHADING_TILE_COLLECT_INL_H_
#endif

#include <bit>
#include <cstring>

#include "engine/shading/shade_frame.h"
#include "engine/shading/simd_color-inl.h"
#include "engine/shading/tile_records.h"

HWY_BEFORE_NAMESPACE();
namespace ff::shading::HWY_NAMESPACE {

/// Record offset of a triangle, which becomes the tile's next one if it is new.
HWY_INLINE std::int32_t find_or_add(const ShadeFrame& frame, std::uint32_t instance_id, std::uint32_t triangle,
                                    TileScratch& scratch) {
    if (instance_id == farfield::kSkyInstance) return kSkyOffset;
    std::uint32_t slot = (triangle * 0x9E3779B1u ^ instance_id * 0x85EBCA6Bu) >> 23;
    while (scratch.table[slot] != 0) {
        const int index = scratch.table[slot] - 1;
        if (scratch.names[index].instance == instance_id && scratch.names[index].triangle == triangle)
            return record_offset(index);
        slot = (slot + 1) & 511;
    }
    const scene::Instance* instance = frame.instance(instance_id);
    if (!instance) return kSkyOffset;
    const scene::Mesh& mesh = frame.scene.meshes[instance->mesh];
    if (triangle >= mesh.triangle_count) return kSkyOffset;
    // The set-up reads these soon: bring them in while the rest of the tile is still being listed.
    const std::size_t global = std::size_t(mesh.first_triangle) + triangle;
    __builtin_prefetch(&frame.scene.indices[3 * global]);
    __builtin_prefetch(&frame.scene.triangle_materials[global]);
    const int index = scratch.count++;
    scratch.names[index] = {instance_id, triangle};
    scratch.table[slot] = std::uint16_t(index + 1);
    scratch.slots[index] = std::uint16_t(slot);
    return record_offset(index);
}

/// Bit i: pixel i of a tile's row sees what the pixel `back` places before it in the visibility buffer sees.
HWY_INLINE std::uint32_t same_as_before(const std::uint32_t* instance, const std::uint32_t* triangle,
                                        std::ptrdiff_t back) {
    std::uint32_t bits = 0;
    for (int i = 0; i < farfield::kTileSize; i += int(hn::Lanes(du))) {
        const VU name = hn::LoadU(du, instance + i);
        const auto same_instance = hn::Eq(name, hn::LoadU(du, instance + i - back));
        const auto same_triangle = hn::Eq(hn::LoadU(du, triangle + i), hn::LoadU(du, triangle + i - back));
        const auto sky = hn::Eq(name, hn::Set(du, farfield::kSkyInstance));
        std::uint8_t bytes[8] = {};  // StoreMaskBits may write as many
        hn::StoreMaskBits(du, hn::And(same_instance, hn::Or(same_triangle, sky)), bytes);
        bits |= (std::uint32_t(bytes[0]) | std::uint32_t(bytes[1]) << 8) << i;
    }
    return bits;
}

/// Writes a whole row of offsets from `at` on.
HWY_INLINE void fill_offsets(std::int32_t offset, std::int32_t* at) {
    for (int i = 0; i < farfield::kTileSize; i += int(hn::Lanes(di))) hn::StoreU(hn::Set(di, offset), di, at + i);
}

/// Lists the tile's triangles once each into scratch.names, and which of them every requested pixel sees into
/// scratch.offset (elsewhere: anything valid). Names outside the scene count as sky.
/// Three passes without a branch that depends on the picture but for one a triangle that begins, as the borders of
/// triangles are nothing that a processor can predict.
/// @param rows  bit i of rows[j]: pixel (x + i, y + j) is wanted; none outside the image
HWY_NOINLINE void collect_triangles(const ShadeFrame& frame, int x, int y,
                                    const std::uint16_t rows[farfield::kTileSize], TileScratch& scratch) {
    constexpr int kSize = farfield::kTileSize;
    const farfield::VisibilityBuffer& visibility = frame.visibility;
    const std::size_t first = visibility.index(x, y);
    const std::uint32_t* instances = visibility.instance.data() + first;
    const std::uint32_t* triangles = visibility.triangle.data() + first;
    const std::ptrdiff_t stride = visibility.stride;

    // 1. The pixels that copy the one above (as do those that nobody asked for), and those that must be looked up: not
    // the one above nor the one on the left, unless that one only copies.
    std::uint16_t copies[kSize];
    std::uint16_t begins[kSize];
    for (int j = 0; j < kSize; ++j) {
        const std::uint32_t* instance = instances + j * stride;
        const std::uint32_t* triangle = triangles + j * stride;
        const std::uint32_t wanted = rows[j], wanted_above = j == 0 ? 0u : rows[j - 1];
        const std::uint32_t as_above = j == 0 ? 0u : same_as_before(instance, triangle, stride);
        // The buffer's very first pixel has none before it.
        const std::uint32_t as_left = first == 0 && j == 0 ? 0u : same_as_before(instance, triangle, 1);
        const std::uint32_t copy = (as_above & wanted_above) | ~wanted;
        copies[j] = std::uint16_t(copy);
        begins[j] = std::uint16_t(~copy & ~(as_left & (~copy << 1)));
    }

    // 2. Each of these is found once and written to the right as far as a row goes: later ones overwrite.
    scratch.count = 0;
    for (int j = 0; j < kSize; j += 4) {
        std::uint64_t left;
        std::memcpy(&left, begins + j, sizeof(left));
        for (; left != 0; left &= left - 1) {
            const int bit = std::countr_zero(left);
            const std::ptrdiff_t at = (j + bit / kSize) * stride + bit % kSize;
            fill_offsets(find_or_add(frame, instances[at], triangles[at], scratch), scratch.offset + j * kSize + bit);
        }
    }
    for (int i = 0; i < scratch.count; ++i) scratch.table[scratch.slots[i]] = 0;

    // 3. Copies, from the top down.
    for (int i = 0; i < kSize; i += int(hn::Lanes(di))) {
        VI above = hn::Set(di, kSkyOffset);
        for (int j = 0; j < kSize; ++j) {
            const std::uint64_t bits = std::uint64_t(copies[j]) >> i;
            std::uint8_t bytes[8];
            std::memcpy(bytes, &bits, sizeof(bytes));
            std::int32_t* offset = scratch.offset + j * kSize + i;
            above = hn::IfThenElse(hn::LoadMaskBits(di, bytes), above, hn::Load(di, offset));
            hn::Store(above, di, offset);
        }
    }
}

}  // namespace ff::shading::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
