#include "engine/farfield/embree_caster_packets.h"

#include "engine/farfield/embree_caster_alpha.h"
#include "engine/farfield/tile_regroup.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "engine/farfield/embree_caster_packets.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace ff::farfield::embree {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

template <int kWidth>
struct RayHitOf;
template <>
struct RayHitOf<8> {
    using Type = RTCRayHit8;
    static void intersect(const int* valid, RTCScene scene, RTCIntersectContext* context, RTCRayHit8* rays) {
        rtcIntersect8(valid, scene, context, rays);
    }
};
template <>
struct RayHitOf<16> {
    using Type = RTCRayHit16;
    static void intersect(const int* valid, RTCScene scene, RTCIntersectContext* context, RTCRayHit16* rays) {
        rtcIntersect16(valid, scene, context, rays);
    }
};

/// A packet and the constants that turn pixel coordinates into its directions.
template <int kWidth>
class PacketCaster {
  public:
    explicit PacketCaster(const PacketJob& job) : job_(job) {
        rtcInitIntersectContext(&cast_.context);
        cast_.pixel_angle = job.view->pixel_angle();
        cast_.blend_within_m = job.view->blend_within_m;
        if (!job.view->sway.is_none()) cast_.sway = &job.view->sway;
        cast_.context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
        for (int lane = 0; lane < kWidth; ++lane) {
            packet_.ray.org_x[lane] = job.origin.x;
            packet_.ray.org_y[lane] = job.origin.y;
            packet_.ray.org_z[lane] = job.origin.z;
            packet_.ray.tnear[lane] = 0.0f;
            packet_.ray.time[lane] = 0.0f;
            packet_.ray.mask[lane] = 0xFFFFFFFFu;
            packet_.ray.id[lane] = std::uint32_t(lane);
            packet_.ray.flags[lane] = 0;
            valid_[lane] = -1;
        }
    }

    void cast_block(std::uint32_t x, std::uint32_t y, std::uint32_t mask) {
        constexpr std::uint32_t kAll = (1u << kWidth) - 1u;
        const auto column = hn::And(hn::Iota(du_, 0), hn::Set(du_, 3u));
        const auto first_x = hn::Add(hn::Set(du_, x), column);
        for (std::size_t lane = 0; lane < kWidth; lane += hn::Lanes(du_)) {
            const auto row = hn::ShiftRight<2>(hn::Iota(du_, std::uint32_t(lane)));
            aim(lane, first_x, hn::Add(hn::Set(du_, y), row));
        }
        if (mask != kAll) {
            for (int lane = 0; lane < kWidth; ++lane) valid_[lane] = -int((mask >> lane) & 1u);
        }
        RayHitOf<kWidth>::intersect(valid_, job_.scene, &cast_.context, &packet_);
        if (mask == kAll) {
            store_block(x, y);
            return;
        }
        for (std::uint32_t left = mask; left != 0; left &= left - 1) {
            const auto lane = std::uint32_t(std::countr_zero(left));
            store_pixel(lane, x + (lane & 3u), y + (lane >> 2));
        }
        for (int lane = 0; lane < kWidth; ++lane) valid_[lane] = -1;
    }

    void cast_pixels(const PixelPacket<kWidth>& pixels) {
        for (std::size_t lane = 0; lane < kWidth; lane += hn::Lanes(du_))
            aim(lane, hn::Load(du_, pixels.x + lane), hn::Load(du_, pixels.y + lane));
        for (int lane = pixels.count; lane < kWidth; ++lane) valid_[lane] = 0;
        RayHitOf<kWidth>::intersect(valid_, job_.scene, &cast_.context, &packet_);
        for (int lane = 0; lane < pixels.count; ++lane)
            store_pixel(std::uint32_t(lane), pixels.x[lane], pixels.y[lane]);
        for (int lane = pixels.count; lane < kWidth; ++lane) valid_[lane] = -1;
    }

  private:
    using DF = hn::CappedTag<float, kWidth>;
    using DU = hn::RebindToUnsigned<DF>;
    using DI = hn::RebindToSigned<DF>;

    /// Directions as PinholeView::direction computes them, bit for bit, so that all casters see the same rays.
    HWY_INLINE void aim(std::size_t lane, hn::Vec<DU> x, hn::Vec<DU> y) {
        const PinholeView& view = *job_.view;
        const Mat3& m = view.world_from_camera;
        const auto half = hn::Set(df_, 0.5f);
        const auto fx = hn::ConvertTo(df_, hn::BitCast(DI(), x));
        const auto fy = hn::ConvertTo(df_, hn::BitCast(DI(), y));
        const auto u = hn::Add(hn::Mul(hn::Add(fx, half), hn::Set(df_, view.u_step)), hn::Set(df_, view.u_first));
        const auto v = hn::Add(hn::Mul(hn::Add(fy, half), hn::Set(df_, view.v_step)), hn::Set(df_, view.v_first));
        float* const out[3] = {packet_.ray.dir_x + lane, packet_.ray.dir_y + lane, packet_.ray.dir_z + lane};
        for (int axis = 0; axis < 3; ++axis) {
            const auto across = hn::Mul(hn::Set(df_, m[0][axis]), u);
            const auto up = hn::Mul(hn::Set(df_, m[1][axis]), v);
            hn::Store(hn::Sub(hn::Add(across, up), hn::Set(df_, m[2][axis])), df_, out[axis]);
        }
        if (job_.beyond) {
            for (std::size_t i = lane; i < lane + hn::Lanes(du_); ++i)
                packet_.ray.tnear[i] =
                    job_.out
                        ->depth[job_.out->index(int(hn::ExtractLane(x, i - lane)), int(hn::ExtractLane(y, i - lane)))];
        }
        const auto none = hn::Set(du_, RTC_INVALID_GEOMETRY_ID);
        hn::Store(hn::Set(df_, std::numeric_limits<float>::infinity()), df_, packet_.ray.tfar + lane);
        hn::Store(none, du_, packet_.hit.geomID + lane);
        hn::Store(none, du_, packet_.hit.instID[0] + lane);
        hn::Store(hn::Zero(du_), du_, packet_.hit.primID + lane);
    }

    /// A whole block: its rows are four pixels wide.
    HWY_INLINE void store_block(std::uint32_t x, std::uint32_t y) {
        constexpr hn::CappedTag<std::uint32_t, 4> d4;
        constexpr hn::CappedTag<float, 4> f4;
        VisibilityBuffer& out = *job_.out;
        for (std::uint32_t row = 0; row < kWidth / 4; ++row) {
            const std::size_t at = out.index(int(x), int(y + row));
            const std::size_t lane = 4 * row;
            // Attachments are numbered as the scene's instances are; a miss leaves both ids invalid, which is sky.
            const auto geometry = hn::Load(d4, packet_.hit.geomID + lane);
            const auto instance = hn::Load(d4, packet_.hit.instID[0] + lane);
            const auto is_direct = hn::Eq(instance, hn::Set(d4, RTC_INVALID_GEOMETRY_ID));
            hn::StoreU(hn::IfThenElse(is_direct, geometry, instance), d4, out.instance.data() + at);
            hn::StoreU(hn::Load(d4, packet_.hit.primID + lane), d4, out.triangle.data() + at);
            hn::StoreU(hn::Load(f4, packet_.ray.tfar + lane), f4, out.depth.data() + at);
        }
    }

    HWY_INLINE void store_pixel(std::uint32_t lane, std::uint32_t x, std::uint32_t y) {
        VisibilityBuffer& out = *job_.out;
        const std::size_t at = out.index(int(x), int(y));
        const std::uint32_t instance = packet_.hit.instID[0][lane];
        out.instance[at] = instance == RTC_INVALID_GEOMETRY_ID ? packet_.hit.geomID[lane] : instance;
        out.triangle[at] = packet_.hit.primID[lane];
        out.depth[at] = packet_.ray.tfar[lane];
    }

    const PacketJob& job_;
    const DF df_{};
    const DU du_{};
    CastContext cast_;
    alignas(64) typename RayHitOf<kWidth>::Type packet_;
    alignas(64) int valid_[kWidth];
};

template <int kWidth>
std::uint64_t cast_with(const PacketJob& job, std::span<const TileRequest> tiles) {
    PacketCaster<kWidth> caster(job);
    std::uint64_t rays = 0;
    regroup<kWidth>(
        tiles, job.view->width, job.view->height,
        [&](std::uint32_t x, std::uint32_t y, std::uint32_t mask) {
            caster.cast_block(x, y, mask);
            rays += std::uint64_t(std::popcount(mask));
        },
        [&](const PixelPacket<kWidth>& pixels) {
            caster.cast_pixels(pixels);
            rays += std::uint64_t(pixels.count);
        });
    return rays;
}

std::uint64_t CastPackets(const PacketJob& job, std::span<const TileRequest> tiles) {
    return job.packet_width == 8 ? cast_with<8>(job, tiles) : cast_with<16>(job, tiles);
}

}  // namespace HWY_NAMESPACE
}  // namespace ff::farfield::embree
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace ff::farfield::embree {
HWY_EXPORT(CastPackets);
std::uint64_t cast_packets(const PacketJob& job, std::span<const TileRequest> tiles) {
    return HWY_DYNAMIC_DISPATCH(CastPackets)(job, tiles);
}
}  // namespace ff::farfield::embree
#endif
