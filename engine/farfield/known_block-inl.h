// Up to eight triangles of any instances as the registers of set_up() want them. Compiled once per SIMD target; include
// after <hwy/highway.h>.
#if defined(FF_KNOWN_BLOCK_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef FF_KNOWN_BLOCK_INL_H_
#undef FF_KNOWN_BLOCK_INL_H_
#else
#define FF_KNOWN_BLOCK_INL_H_
#endif

#include <hwy/highway.h>

#include <algorithm>
#include <span>

#include "engine/farfield/beam_setup-inl.h"
#include "engine/farfield/known_primitives.h"

HWY_BEFORE_NAMESPACE();
namespace ff::farfield::beam {
namespace HWY_NAMESPACE {
namespace {

constexpr int kBlock = BvhLeaf::kMaxDirect;
constexpr int kFilled = std::max(kBlock, kLanes);  // registers wider than a block repeat its last triangle

// Up to eight triangles of any instances.
struct Block {
    alignas(64) float position[3][3][kFilled];  // corner, axis; mesh space
    alignas(64) float linear[3][4][kFilled];    // each lane's X W, Y W, W: x y z c
    const Linear* shared = nullptr;             // instead, where all lanes are of one instance, as most are
    std::uint32_t alpha = 0;                    // bit per triangle that is masked or blended
};

// Transforms of the instances that came last: a tile's candidates alternate between a few.
class InstanceLinears {
  public:
    InstanceLinears(const scene::StaticScene& scene, const BeamView& view, const TileRequest& tile)
        : scene_(scene), position_(view.view.position) {
        const BeamRequest square = beam_request_of(tile);
        tile_from_world_ = view.tile_from_world(square.x, square.y);
        for (std::uint32_t& id : ids_) id = kSkyInstance;
    }

    const Linear (&of(std::uint32_t id))[3] {
        Entry& entry = entries_[id % kEntries];
        if (id == ids_[id % kEntries]) return entry.xyw;
        const scene::Instance& instance = scene_.instances[id];
        const DVec3 offset = instance.position - position_;
        for (int row = 0; row < 3; ++row)
            entry.xyw[row] = linear_of(tile_from_world_, row, DMat3(instance.world_from_mesh), offset);
        ids_[id % kEntries] = id;
        return entry.xyw;
    }

  private:
    static constexpr std::uint32_t kEntries = 16;
    struct Entry {
        Linear xyw[3];
    };

    const scene::StaticScene& scene_;
    WorldPos position_;
    DMat3 tile_from_world_;
    std::uint32_t ids_[kEntries];
    Entry entries_[kEntries];
};

// Lanes beyond the last repeat it.
HWY_INLINE void fill(std::span<const KnownTriangle> triangles, InstanceLinears& linears, Block& block) {
    block.alpha = 0;
    const std::uint32_t first = triangles[0].id.instance;
    const bool is_shared = std::all_of(triangles.begin(), triangles.end(),
                                       [&](const KnownTriangle& triangle) { return triangle.id.instance == first; });
    block.shared = is_shared ? linears.of(first) : nullptr;
    for (std::size_t lane = 0; lane < std::size_t(kFilled); ++lane) {
        const KnownTriangle& triangle = triangles[std::min(lane, triangles.size() - 1)];
        if (!is_shared) {
            const Linear(&xyw)[3] = linears.of(triangle.id.instance);
            for (int row = 0; row < 3; ++row) {
                block.linear[row][0][lane] = xyw[row].x;
                block.linear[row][1][lane] = xyw[row].y;
                block.linear[row][2][lane] = xyw[row].z;
                block.linear[row][3][lane] = xyw[row].c;
            }
        }
        for (int corner = 0; corner < 3; ++corner)
            for (int axis = 0; axis < 3; ++axis) block.position[corner][axis][lane] = triangle.corners[corner][axis];
        if (lane < triangles.size() && triangle.is_see_through) block.alpha |= 1u << lane;
    }
}

// As transform_vertices, but each lane by its own instance.
HWY_INLINE bool transform(const Block& block, LeafScratch& s) {
    MF projected = hn::MaskFromVec(hn::BitCast(f, hn::Set(si, -1)));
    for (int corner = 0; corner < 3; ++corner) {
        const auto& p = block.position[corner];
        for (int lane = 0; lane < kBlock; lane += kLanes) {
            const VF x = hn::Load(f, p[0] + lane), y = hn::Load(f, p[1] + lane), z = hn::Load(f, p[2] + lane);
            const auto mix = [&](VF of_x, VF of_y, VF of_z, VF constant) {
                return hn::MulAdd(of_x, x, hn::MulAdd(of_y, y, hn::MulAdd(of_z, z, constant)));
            };
            const auto apply = [&](int row) {
                if (block.shared != nullptr) {
                    const Linear& l = block.shared[row];
                    return mix(hn::Set(f, l.x), hn::Set(f, l.y), hn::Set(f, l.z), hn::Set(f, l.c));
                }
                const auto load = [&](int term) { return hn::Load(f, block.linear[row][term] + lane); };
                return mix(load(0), load(1), load(2), load(3));
            };
            projected = hn::And(projected, store_vertices(apply(0), apply(1), apply(2), s, corner * kBlock + lane));
        }
    }
    return hn::AllTrue(f, projected);
}

// A leaf's description of a block: what set_up reads beside the vertices.
HWY_INLINE BvhLeaf describe(std::size_t triangles) {
    BvhLeaf leaf;
    leaf.vertex_count = 3 * kBlock;
    leaf.triangle_count = std::uint16_t(triangles);
    for (int corner = 0; corner < 3; ++corner)
        for (int i = 0; i < 16; ++i) leaf.corner[corner][i] = std::uint8_t(corner * kBlock + std::min(i, kBlock - 1));
    return leaf;
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace ff::farfield::beam
HWY_AFTER_NAMESPACE();

#endif
