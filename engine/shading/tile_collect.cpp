#include "engine/shading/tile_collect.h"

#include <cstring>

namespace ff::shading {
namespace {

constexpr int kSize = farfield::kTileSize;

/// Record offset of a triangle, which becomes the tile's next one if it is new.
std::int32_t find_or_add(const ShadeFrame& frame, std::uint32_t instance_id, std::uint32_t triangle,
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
    return record_offset(index);
}

/// 0 if two rows of a tile see the same, pixel by pixel.
std::uint32_t differing_bits(const std::uint32_t* instance_a, const std::uint32_t* instance_b,
                             const std::uint32_t* triangle_a, const std::uint32_t* triangle_b) {
    std::uint32_t bits = 0;
    for (int i = 0; i < kSize; ++i) bits |= (instance_a[i] ^ instance_b[i]) | (triangle_a[i] ^ triangle_b[i]);
    return bits;
}

}  // namespace

void collect_triangles(const ShadeFrame& frame, int x, int y, const std::uint16_t rows[kSize], TileScratch& scratch) {
    scratch.count = 0;
    std::memset(scratch.table, 0, sizeof(scratch.table));
    const farfield::VisibilityBuffer& visibility = frame.visibility;
    const std::ptrdiff_t stride = visibility.stride;
    bool above_is_whole = false;
    for (int j = 0; j < kSize; ++j) {
        std::int32_t* offset = scratch.offset + j * kSize;
        const std::size_t first = visibility.index(x, y + j);
        const std::uint32_t* instance = visibility.instance.data() + first;
        const std::uint32_t* triangle = visibility.triangle.data() + first;
        const bool whole = rows[j] == 0xFFFF;
        const bool copies_above = whole && above_is_whole;
        above_is_whole = whole;
        // Often the row sees what the row above sees.
        if (copies_above && differing_bits(instance, instance - stride, triangle, triangle - stride) == 0) {
            std::memcpy(offset, offset - kSize, kSize * sizeof(*offset));
            continue;
        }
        std::uint32_t last_instance = farfield::kSkyInstance, last_triangle = 0;
        std::int32_t last_offset = kSkyOffset;
        for (int i = 0; i < kSize; ++i) {
            const bool same =
                instance[i] == last_instance && (triangle[i] == last_triangle || instance[i] == farfield::kSkyInstance);
            if (!same && (rows[j] >> i & 1)) {
                last_instance = instance[i];
                last_triangle = triangle[i];
                const bool as_above =
                    copies_above && instance[i - stride] == last_instance && triangle[i - stride] == last_triangle;
                last_offset = as_above ? offset[i - kSize] : find_or_add(frame, last_instance, last_triangle, scratch);
            }
            offset[i] = last_offset;
        }
    }
}

}  // namespace ff::shading
