#include "engine/farfield/panorama_kernels.h"

#include <bit>
#include <cstring>
#include <type_traits>

#ifndef FF_PANORAMA_SAMPLES
#define FF_PANORAMA_SAMPLES
namespace ff::farfield::panorama {

/// What one tile reads of the map, on its way through the three steps of a lookup. 17 KiB.
struct TileSamples {
    static constexpr int kPixels = kTileSize * kTileSize;
    alignas(64) std::int32_t quad[kPixels];     ///< index of the upper left of the four texels around the pixel
    alignas(64) std::int32_t nearest[kPixels];  ///< index of the nearest
    alignas(64) std::int32_t weight_x[kPixels];
    alignas(64) std::int32_t weight_y[kPixels];
    alignas(64) float inverse_axis[kPixels];  ///< 1 / length of the pixel's ray along the face's axis
    alignas(64) std::uint32_t upper_colors[2 * kPixels];
    alignas(64) std::uint32_t lower_colors[2 * kPixels];
    alignas(64) float upper_depths[2 * kPixels];
    alignas(64) float lower_depths[2 * kPixels];
    alignas(64) std::int32_t upper_records[kPixels];  ///< two of 16 bits
    alignas(64) std::int32_t lower_records[kPixels];
    alignas(64) std::uint32_t instances[kPixels];
    alignas(64) std::uint32_t triangles[kPixels];
    alignas(64) float depths[kPixels];
};

/// What of a tile's visibility is written.
struct Wanted {
    bool depths, names;
    bool marked;  ///< names and depths of marked pixels
};

/// @param any_marked  of the texels that the tile looks at
inline Wanted wanted_of(const PanoramaTarget& target, const TileRequest& tile, bool any_marked) {
    if (target.visibility == nullptr) return {};
    const bool by_mark = target.names == PanoramaNames::marked;
    bool whole = false;
    if (by_mark && !target.whole.empty()) {
        const auto columns = std::size_t(target.visibility->stride / kTileSize);
        whole = target.whole[std::size_t(tile.y / kTileSize) * columns + std::size_t(tile.x / kTileSize)] != 0;
    }
    return {.depths = target.depths || whole,
            .names = target.names == PanoramaNames::all || whole,
            .marked = by_mark && any_marked && !whole};
}

/// Copies texels to where vectors can load them. Plain loads on purpose, outside of the vector targets: pairs of
/// texels come in one load each, and gather instructions take three times as long on AMD's Zen 3.
void fetch(const LookupJob& job, const TileRequest& tile, const Wanted& wanted, bool check, TileSamples& samples);

/// Writes names and depths of some pixels of a row. Few are marked, so one by one.
/// @param bits  the pixels
/// @param record  of all texels, or kMixedRecords
void name(const LookupJob& job, const TileRequest& tile, int row, std::uint32_t bits, std::uint32_t record,
          const TileSamples& samples);

}  // namespace ff::farfield::panorama
#endif

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "engine/farfield/panorama_kernels.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace ff::farfield::panorama {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using DF = hn::CappedTag<float, kTileSize>;
using DI = hn::RebindToSigned<DF>;
using DU = hn::RebindToUnsigned<DF>;
using DU16 = hn::Repartition<std::uint16_t, DU>;
using DU8 = hn::Repartition<std::uint8_t, DU>;
using VF = hn::Vec<DF>;
using VI = hn::Vec<DI>;
using VU = hn::Vec<DU>;

/// Camera ray (u, v, -1) to face coordinates: a = row[0] . ray and so on; constant over a tile that sees one face.
struct FaceAxes {
    Vec3 a, b, axis;
};

inline FaceAxes axes_of_face(const PinholeView& view, int face) {
    static constexpr Vec3 kAxes[6][3] = {
        {{0, 0, 1}, {0, 1, 0}, {1, 0, 0}},   {{0, 0, -1}, {0, 1, 0}, {-1, 0, 0}}, {{1, 0, 0}, {0, 0, 1}, {0, 1, 0}},
        {{1, 0, 0}, {0, 0, -1}, {0, -1, 0}}, {{-1, 0, 0}, {0, 1, 0}, {0, 0, 1}},  {{1, 0, 0}, {0, 1, 0}, {0, 0, -1}},
    };
    const Mat3& m = view.world_from_camera;
    const auto into_camera = [&](const Vec3& w) {
        return Vec3(w.x * m[0].x + w.y * m[0].y + w.z * m[0].z, w.x * m[1].x + w.y * m[1].y + w.z * m[1].z,
                    w.x * m[2].x + w.y * m[2].y + w.z * m[2].z);
    };
    return {into_camera(kAxes[face][0]), into_camera(kAxes[face][1]), into_camera(kAxes[face][2])};
}

/// Four texels mixed, each channel with weights that add up to 256.
HWY_INLINE VU mix_quad(VU c00, VU c01, VU c10, VU c11, VU wx, VU wy) {
    const DU du;
    const DU16 d16;
    const auto sixteen = hn::Set(du, 16u);
    const VU nx = hn::Sub(sixteen, wx), ny = hn::Sub(sixteen, wy);
    const auto both = [&](VU w) { return hn::BitCast(d16, hn::Or(w, hn::ShiftLeft<16>(w))); };
    const auto w00 = both(hn::Mul(nx, ny)), w01 = both(hn::Mul(wx, ny));
    const auto w10 = both(hn::Mul(nx, wy)), w11 = both(hn::Mul(wx, wy));
    const auto low = hn::Set(du, 0x00FF00FFu);
    const auto half = hn::Set(d16, std::uint16_t(128));
    const auto even = [&](VU c) { return hn::BitCast(d16, hn::And(c, low)); };
    const auto odd = [&](VU c) { return hn::BitCast(d16, hn::And(hn::ShiftRight<8>(c), low)); };
    const auto mix = [&](auto a, auto b, auto c, auto d) {
        const auto sum = hn::Add(hn::Add(hn::Mul(a, w00), hn::Mul(b, w01)), hn::Add(hn::Mul(c, w10), hn::Mul(d, w11)));
        return hn::BitCast(du, hn::ShiftRight<8>(hn::Add(sum, half)));
    };
    const VU red_blue = mix(even(c00), even(c01), even(c10), even(c11));
    const VU green = mix(odd(c00), odd(c01), odd(c10), odd(c11));
    return hn::Or(hn::Or(red_blue, hn::ShiftLeft<8>(green)), hn::Set(du, 0xFF000000u));
}

HWY_INLINE VI bins_of(VF value) {
    const DI di;
    const VI bin =
        hn::Add(hn::ShiftRight<kBinShift>(hn::BitCast(di, value)), hn::Set(di, kClassFirstStale - kFirstBin));
    return hn::Min(hn::Max(bin, hn::Set(di, kClassFirstStale)), hn::Set(di, kClassLastStale));
}

HWY_INLINE std::uint32_t bits_of(hn::Mask<DI> mask) {
    std::uint8_t bytes[8] = {};
    hn::StoreMaskBits(DI(), mask, bytes);
    return hn::Lanes(DI()) > 8 ? std::uint32_t(bytes[0] | bytes[1] << 8) : std::uint32_t(bytes[0]);
}

/// Where each pixel of a tile falls on the map.
/// @tparam kOneFace  all pixels lie on `face`
template <bool kOneFace>
void project(const LookupJob& job, const TileRequest& tile, int face, TileSamples& out) {
    const DF df;
    const DI di;
    const PanoramaMap& map = *job.map;
    const PinholeView& view = *job.view;
    const FaceAxes axes = axes_of_face(view, kOneFace ? face : 0);
    const Mat3& m = view.world_from_camera;
    const float scale = 0.5f * float(map.size) / map.extent, center = 0.5f * float(map.size) - 0.5f;
    const VI last = hn::Set(di, map.size - 2);
    const VI row_step = hn::Set(di, map.size);
    const VI lane = hn::Iota(di, 0);
    for (int j = 0; j < kTileSize; ++j) {
        if (tile.rows[j] == 0) continue;
        const float v = (float(int(tile.y) + j) + 0.5f) * view.v_step + view.v_first;
        for (int i = 0; i < kTileSize; i += int(hn::Lanes(df))) {
            const int pixel = j * kTileSize + i;
            const float x = float(int(tile.x) + i) + 0.5f;
            const VF u = hn::MulAdd(hn::Add(hn::ConvertTo(df, lane), hn::Set(df, x)), hn::Set(df, view.u_step),
                                    hn::Set(df, view.u_first));
            VF a, b, axis;
            VI base;
            if constexpr (kOneFace) {
                a = hn::MulAdd(hn::Set(df, axes.a.x), u, hn::Set(df, axes.a.y * v - axes.a.z));
                b = hn::MulAdd(hn::Set(df, axes.b.x), u, hn::Set(df, axes.b.y * v - axes.b.z));
                axis = hn::MulAdd(hn::Set(df, axes.axis.x), u, hn::Set(df, axes.axis.y * v - axes.axis.z));
                base = hn::Set(di, face * map.size * map.size);
            } else {
                const VF dx = hn::MulAdd(hn::Set(df, m[0].x), u, hn::Set(df, m[1].x * v - m[2].x));
                const VF dy = hn::MulAdd(hn::Set(df, m[0].y), u, hn::Set(df, m[1].y * v - m[2].y));
                const VF dz = hn::MulAdd(hn::Set(df, m[0].z), u, hn::Set(df, m[1].z * v - m[2].z));
                const VF ax = hn::Abs(dx), ay = hn::Abs(dy), az = hn::Abs(dz);
                const auto on_x = hn::And(hn::Ge(ax, ay), hn::Ge(ax, az));
                const auto on_y = hn::AndNot(on_x, hn::Ge(ay, az));
                axis = hn::Max(ax, hn::Max(ay, az));
                const auto with_sign_of = [&](VF value, VF sign) {
                    return hn::Xor(value, hn::And(sign, hn::SignBit(df)));
                };
                a = hn::IfThenElse(on_x, with_sign_of(dz, dx), hn::IfThenElse(on_y, dx, hn::Neg(with_sign_of(dx, dz))));
                b = hn::IfThenElse(on_y, with_sign_of(dz, dy), dy);
                const VF along = hn::IfThenElse(on_x, dx, hn::IfThenElse(on_y, dy, dz));
                const VI negative = hn::ShiftRight<31>(hn::BitCast(di, along));  // 0 or -1
                const auto on_xi = hn::RebindMask(di, on_x), on_yi = hn::RebindMask(di, on_y);
                const VI of_axis = hn::IfThenElse(on_yi, hn::Set(di, 2), hn::Set(di, 4));
                const VI faces = hn::Sub(hn::IfThenZeroElse(on_xi, of_axis), negative);
                base = hn::Mul(faces, hn::Set(di, map.size * map.size));
            }
            const VF inverse = hn::Div(hn::Set(df, 1.0f), axis);
            const VF tx = hn::MulAdd(hn::Mul(a, inverse), hn::Set(df, scale), hn::Set(df, center));
            const VF ty = hn::MulAdd(hn::Mul(b, inverse), hn::Set(df, -scale), hn::Set(df, center));
            const VI ix = hn::Min(hn::Max(hn::ConvertTo(di, tx), hn::Zero(di)), last);
            const VI iy = hn::Min(hn::Max(hn::ConvertTo(di, ty), hn::Zero(di)), last);
            // Weights in sixteenths of a texel, within [0, 16].
            const auto sixteenths = [&](VF t, VI whole) {
                const VF w = hn::MulAdd(hn::Sub(t, hn::ConvertTo(df, whole)), hn::Set(df, 16.0f), hn::Set(df, 0.5f));
                return hn::Min(hn::Max(hn::ConvertTo(di, w), hn::Zero(di)), hn::Set(di, 16));
            };
            const VI wx = sixteenths(tx, ix), wy = sixteenths(ty, iy);
            const VI at = hn::Add(hn::Add(base, ix), hn::Mul(iy, row_step));
            const VI eight = hn::Set(di, 8);
            const VI right = hn::IfThenElseZero(hn::Gt(wx, eight), hn::Set(di, 1));
            const VI down = hn::IfThenElseZero(hn::Gt(wy, eight), row_step);
            hn::Store(at, di, out.quad + pixel);
            hn::Store(hn::Add(at, hn::Add(right, down)), di, out.nearest + pixel);
            hn::Store(wx, di, out.weight_x + pixel);
            hn::Store(wy, di, out.weight_y + pixel);
            hn::Store(inverse, df, out.inverse_axis + pixel);
        }
    }
}

/// Mixes, checks and stores what the map holds of a tile's pixels.
/// @tparam kCheck  texels have to be looked at one by one; else all are good, of one record
template <bool kCheck>
void resolve(const LookupJob& job, const TileRequest& tile, const Wanted& visibility, std::uint32_t record,
             const TileSamples& in, TileClasses& out) {
    const DF df;
    const DI di;
    const DU du;
    const hn::Rebind<std::uint8_t, DI> d8;
    const PinholeView& view = *job.view;
    const VI lane = hn::Iota(di, 0);
    const auto is = [&](VI state, std::uint32_t value) { return hn::Eq(state, hn::Set(di, int(value))); };
    const VU mark = hn::Set(du, kTexelMarked << 24);
    TileMask* const named = job.target.named == nullptr ? nullptr : &job.target.named->tile_of(tile);
    auto all_still = hn::Eq(lane, lane);
    std::uint32_t any = 0;
    for (int j = 0; j < kTileSize; ++j) {
        std::uint32_t edge = 0, noise = 0, worse = 0, marked = 0;
        out.edge[std::size_t(j)] = out.noise[std::size_t(j)] = out.worse[std::size_t(j)] = 0;
        if (tile.rows[j] == 0) continue;
        const int y = int(tile.y) + j;
        const float v = (float(y) + 0.5f) * view.v_step + view.v_first;
        for (int i = 0; i < kTileSize; i += int(hn::Lanes(df))) {
            const int pixel = j * kTileSize + i;
            const int x = int(tile.x) + i;
            const VI bits = hn::Set(di, tile.rows[j] >> i);
            auto wanted = hn::Ne(hn::And(bits, hn::Shl(hn::Set(di, 1), lane)), hn::Zero(di));
            const VI wx = hn::Load(di, in.weight_x + pixel), wy = hn::Load(di, in.weight_y + pixel);
            VU c00, c01, c10, c11;
            hn::LoadInterleaved2(du, in.upper_colors + 2 * pixel, c00, c01);
            hn::LoadInterleaved2(du, in.lower_colors + 2 * pixel, c10, c11);
            const VI quad = hn::BitCast(di, hn::And(hn::ShiftRight<24>(c00), hn::Set(du, kQuadStates)));
            const auto right_nearer = hn::Gt(wx, hn::Set(di, 8)), lower_nearer = hn::Gt(wy, hn::Set(di, 8));
            const auto nearest_of = [&](auto d, auto v00, auto v01, auto v10, auto v11) {
                const auto right = hn::RebindMask(d, right_nearer), lower = hn::RebindMask(d, lower_nearer);
                return hn::IfThenElse(lower, hn::IfThenElse(right, v11, v10), hn::IfThenElse(right, v01, v00));
            };
            VU color = mix_quad(c00, c01, c10, c11, hn::BitCast(du, wx), hn::BitCast(du, wy));
            const VF inverse = hn::Load(df, in.inverse_axis + pixel);

            VF moved_z = hn::Set(df, job.moved_z[record]);
            if constexpr (kCheck) {
                const VI upper = hn::Load(di, in.upper_records + pixel), lower = hn::Load(di, in.lower_records + pixel);
                const VI low_half = hn::Set(di, 0xFFFF);
                const VI pair = hn::IfThenElse(lower_nearer, lower, upper);
                const VI near_record = hn::And(hn::IfThenElse(right_nearer, hn::ShiftRight<16>(pair), pair), low_half);
                const auto same = hn::And(hn::Eq(upper, lower), hn::Eq(hn::And(upper, low_half),
                                                                       hn::And(hn::ShiftRight<16>(upper), low_half)));
                const auto use_quad = hn::And(same, hn::Gt(quad, hn::Set(di, int(kQuadHoles))));
                const VU nearest = nearest_of(du, c00, c01, c10, c11);
                color = hn::IfThenElse(hn::RebindMask(du, use_quad), color, hn::Or(nearest, hn::Set(du, 0xFF000000u)));

                VF t00, t01, t10, t11;
                hn::LoadInterleaved2(df, in.upper_depths + 2 * pixel, t00, t01);
                hn::LoadInterleaved2(df, in.lower_depths + 2 * pixel, t10, t11);
                const VF nearest_t = nearest_of(df, t00, t01, t10, t11);
                const VF least_t = hn::Min(hn::Min(t00, t01), hn::Min(t10, t11));
                const VF t = hn::IfThenElse(hn::RebindMask(df, use_quad), least_t, nearest_t);

                // Where the texel's point lies on the screen now: exact for a point at that depth. Mostly all lanes
                // have one record.
                const std::uint32_t first = std::uint32_t(hn::GetLane(near_record));
                VF ex = hn::Set(df, job.moved_x[first]), ey = hn::Set(df, job.moved_y[first]);
                VF ez = hn::Set(df, job.moved_z[first]);
                if (!hn::AllTrue(di, hn::Eq(near_record, hn::Set(di, int(first))))) {
                    ex = hn::GatherIndex(df, job.moved_x, near_record);
                    ey = hn::GatherIndex(df, job.moved_y, near_record);
                    ez = hn::GatherIndex(df, job.moved_z, near_record);
                }
                moved_z = ez;
                const VF u = hn::MulAdd(hn::Add(hn::ConvertTo(df, lane), hn::Set(df, float(x) + 0.5f)),
                                        hn::Set(df, view.u_step), hn::Set(df, view.u_first));
                const VF depth = hn::Max(hn::MulAdd(t, inverse, ez), hn::Set(df, 1e-6f));
                const VF px = hn::MulAdd(u, ez, ex);
                const VF py = hn::MulAdd(hn::Set(df, v), ez, ey);
                const VF shift = hn::Sqrt(hn::MulAdd(px, px, hn::Mul(py, py)));
                const VF parallax = hn::Div(hn::Mul(shift, hn::Set(df, job.focal_px)), depth);
                VF measure = parallax;
                if (job.by_distance) measure = hn::Sqrt(hn::MulAdd(ex, ex, hn::MulAdd(ey, ey, hn::Mul(ez, ez))));

                const auto never = hn::Eq(near_record, hn::Set(di, int(kNeverTraced)));
                const auto stale = hn::RebindMask(di, hn::Gt(measure, hn::Set(df, job.limit)));
                const auto bad = hn::Or(stale, never);
                const VI classes = hn::IfThenElse(never, hn::Set(di, kClassNever), bins_of(measure));
                hn::StoreU(hn::DemoteTo(d8, classes), d8, out.classes.data() + pixel);
                worse |= bits_of(hn::And(bad, wanted)) << i;
                const auto may_mix = hn::And(wanted, hn::AndNot(bad, use_quad));
                edge |= bits_of(hn::And(may_mix, is(quad, kQuadEdge))) << i;
                noise |= bits_of(hn::And(may_mix, is(quad, kQuadNoise))) << i;
                const auto still = hn::RebindMask(di, hn::Eq(parallax, hn::Zero(df)));
                all_still = hn::And(all_still, hn::Or(still, hn::Not(wanted)));
                hn::StoreU(hn::DemoteTo(d8, hn::IfThenZeroElse(still, bins_of(parallax))), d8,
                           out.parallax.data() + pixel);
                wanted = hn::AndNot(never, wanted);
            } else {
                edge |= bits_of(hn::And(wanted, is(quad, kQuadEdge))) << i;
                noise |= bits_of(hn::And(wanted, is(quad, kQuadNoise))) << i;
            }

            const bool all = hn::AllTrue(di, wanted);
            const auto put = [&](auto d, auto value, auto* to) {
                if (all)
                    hn::StoreU(value, d, to);
                else
                    hn::StoreU(hn::IfThenElse(hn::RebindMask(d, wanted), value, hn::LoadU(d, to)), d, to);
            };
            put(du, color, job.target.colors + std::size_t(y) * std::size_t(job.target.color_stride) + std::size_t(x));
            if (job.target.visibility == nullptr) continue;
            VisibilityBuffer& target = *job.target.visibility;
            const std::size_t to = target.index(x, y);
            if (visibility.depths)
                put(df, hn::MulAdd(hn::Load(df, in.depths + pixel), inverse, moved_z), target.depth.data() + to);
            if (visibility.names) {
                put(du, hn::Load(du, in.instances + pixel), target.instance.data() + to);
                put(du, hn::Load(du, in.triangles + pixel), target.triangle.data() + to);
            }
            if (visibility.marked) {
                const VU is_marked = hn::And(nearest_of(du, c00, c01, c10, c11), mark);
                marked |= bits_of(hn::AndNot(is(hn::BitCast(di, is_marked), 0), wanted)) << i;
            }
        }
        if (marked != 0) name(job, tile, j, marked, kCheck ? kMixedRecords : record, in);
        if (named != nullptr) named->rows[j] = std::uint16_t(visibility.names ? tile.rows[j] : marked);
        out.edge[std::size_t(j)] = std::uint16_t(edge);
        out.noise[std::size_t(j)] = std::uint16_t(noise);
        out.worse[std::size_t(j)] = std::uint16_t(worse);
        any |= edge | noise | worse;
    }
    out.any = any != 0;
    out.parallax_differs = kCheck && !hn::AllTrue(di, all_still);
}

void keep_quads(const TileSamples& samples, TileClasses& out) {
    std::size_t count = 0;
    for (std::size_t j = 0; j < kTileSize; ++j)
        for (std::uint32_t bits = out.edge[j] | out.noise[j]; bits != 0; bits &= bits - 1)
            out.quads[count++] = samples.quad[j * kTileSize + std::size_t(std::countr_zero(bits))];
}

void LookupTile(const LookupJob& job, const TileRequest& tile, const TileFootprint& footprint, TileClasses& out) {
    const PanoramaMap& map = *job.map;
    TileSamples samples;
    out.tile_parallax = 0;
    if (footprint.face < 0) {
        const Wanted wanted = wanted_of(job.target, tile, true);
        project<false>(job, tile, 0, samples);
        fetch(job, tile, wanted, true, samples);
        resolve<true>(job, tile, wanted, kNeverTraced, samples, out);
        if (out.any) keep_quads(samples, out);
        return;
    }
    // Where all texels are good, of one record, nothing has to be looked at but colours. The nearest decides.
    const int side = map.tiles_side;
    TexelTile texels = map.tiles[std::size_t(footprint.y0 / kTileSize * side + footprint.x0 / kTileSize)];
    for (int ty = footprint.y0 / kTileSize; ty <= footprint.y1 / kTileSize; ++ty)
        for (int tx = footprint.x0 / kTileSize; tx <= footprint.x1 / kTileSize; ++tx) {
            const TexelTile& other = map.tiles[std::size_t(ty * side + tx)];
            texels.complete &= other.complete && other.record == texels.record;
            texels.nearest_m = std::min(texels.nearest_m, other.nearest_m);
            texels.any_marked |= other.any_marked;
        }
    const Wanted wanted = wanted_of(job.target, tile, texels.any_marked);
    const bool good = is_tile_good(job, texels);
    project<true>(job, tile, footprint.face, samples);
    fetch(job, tile, wanted, !good, samples);
    if (good) {
        resolve<false>(job, tile, wanted, texels.record, samples, out);
        out.tile_parallax = bin_of(tile_parallax_bound(job, texels));
    } else {
        resolve<true>(job, tile, wanted, kNeverTraced, samples, out);
    }
    if (out.any) keep_quads(samples, out);
}

void UpdateQuads(PanoramaMap& map, int tile_x, int tile_row, const TexelBox& box, const ContrastLimits& contrast) {
    const DU du;
    const DU8 d8;
    const hn::Rebind<std::uint16_t, DU> d16;
    const auto limit = hn::Set(d8, std::uint8_t(contrast.edge)),
               strong_limit = hn::Set(d8, std::uint8_t(contrast.strong));
    const auto rgb = hn::Set(du, 0x00FFFFFFu);
    const std::size_t down = std::size_t(map.size);
    const int last = map.size - 1;
    const int lanes = int(hn::Lanes(du));
    for (int j = box.y0; j <= box.y1; ++j) {
        const int row = tile_row * kTileSize + j;
        for (int i = box.x0 / lanes * lanes; i <= box.x1; i += lanes) {
            const int x = tile_x * kTileSize + i;
            const std::size_t at = map.index(x, row);
            std::uint32_t* colors = map.colors.data() + at;
            const VU c00 = hn::LoadU(du, colors), c01 = hn::LoadU(du, colors + 1);
            const VU c10 = hn::LoadU(du, colors + down), c11 = hn::LoadU(du, colors + down + 1);
            const auto b00 = hn::BitCast(d8, c00), b01 = hn::BitCast(d8, c01);
            const auto b10 = hn::BitCast(d8, c10), b11 = hn::BitCast(d8, c11);
            const auto spread =
                hn::Sub(hn::Max(hn::Max(b00, b01), hn::Max(b10, b11)), hn::Min(hn::Min(b00, b01), hn::Min(b10, b11)));
            const auto over = hn::BitCast(du, hn::SaturatedSub(spread, limit));
            const auto visible = hn::Ne(hn::And(over, rgb), hn::Zero(du));

            // Great contrast nearby: what lies between the texels, a hole in foliage, may be as bright.
            auto high = hn::Max(hn::Max(b00, b01), hn::Max(b10, b11)),
                 low = hn::Min(hn::Min(b00, b01), hn::Min(b10, b11));
            const int first_row = row % map.size == 0 ? 0 : -1;
            for (int r = first_row; r < 3; ++r)
                for (int c = (x == 0 ? 0 : -1); c < 3; ++c) {
                    const auto b = hn::BitCast(d8, hn::LoadU(du, colors + r * std::ptrdiff_t(down) + c));
                    high = hn::Max(high, b);
                    low = hn::Min(low, b);
                }
            const auto strongly = hn::BitCast(du, hn::SaturatedSub(hn::Sub(high, low), strong_limit));
            const auto strong = hn::Ne(hn::And(strongly, rgb), hn::Zero(du));

            // What the four show: at most two things where each is as the first or as the first that differs from it.
            const std::uint32_t* instances = map.visibility.instance.data() + at;
            const std::uint32_t* triangles = map.visibility.triangle.data() + at;
            const std::size_t others[3] = {1, down, down + 1};
            const VU instance = hn::LoadU(du, instances), triangle = hn::LoadU(du, triangles);
            auto same = hn::Eq(instance, instance);
            decltype(same) is_first[3];
            VU second_instance = instance, second_triangle = triangle;
            for (int k = 0; k < 3; ++k) {
                const VU i_k = hn::LoadU(du, instances + others[k]), t_k = hn::LoadU(du, triangles + others[k]);
                is_first[k] = hn::And(hn::Eq(i_k, instance), hn::Eq(t_k, triangle));
                const auto is_second = hn::AndNot(is_first[k], same);
                second_instance = hn::IfThenElse(is_second, i_k, second_instance);
                second_triangle = hn::IfThenElse(is_second, t_k, second_triangle);
                same = hn::And(same, is_first[k]);
            }
            auto two = hn::Eq(instance, instance);
            for (int k = 0; k < 3; ++k) {
                const VU i_k = hn::LoadU(du, instances + others[k]), t_k = hn::LoadU(du, triangles + others[k]);
                const auto is_second = hn::And(hn::Eq(i_k, second_instance), hn::Eq(t_k, second_triangle));
                two = hn::And(two, hn::Or(is_first[k], is_second));
            }

            const auto traced = [&](std::size_t offset) {
                return hn::Ne(hn::PromoteTo(du, hn::LoadU(d16, map.records.data() + at + offset)), hn::Zero(du));
            };
            auto complete = hn::And(hn::And(traced(0), traced(1)), hn::And(traced(down), traced(down + 1)));
            // The last column and row of a face have no neighbours; no lookup starts there.
            const VU columns = hn::Add(hn::Iota(du, 0), hn::Set(du, std::uint32_t(x)));
            complete = hn::And(complete, hn::Ne(columns, hn::Set(du, std::uint32_t(last))));
            if (row % map.size == last) complete = hn::Ne(columns, columns);

            const VU differing =
                hn::IfThenElse(hn::AndNot(strong, two), hn::Set(du, kQuadEdge << 24), hn::Set(du, kQuadNoise << 24));
            const VU agreeing =
                hn::IfThenElse(hn::Or(strong, hn::AndNot(same, visible)), differing, hn::Set(du, kQuadSmooth << 24));
            const auto kept = hn::Set(du, 0x00FFFFFFu | kTexelMarked << 24);
            hn::StoreU(hn::Or(hn::And(c00, kept), hn::IfThenElseZero(complete, agreeing)), du, colors);
        }
    }
}

}  // namespace HWY_NAMESPACE
}  // namespace ff::farfield::panorama
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace ff::farfield::panorama {

void fetch(const LookupJob& job, const TileRequest& tile, const Wanted& wanted, bool check, TileSamples& samples) {
    const PanoramaMap& map = *job.map;
    const std::size_t row_step = std::size_t(map.size);
    const auto copy = [](void* to, const void* from, auto bytes) { std::memcpy(to, from, bytes); };
    constexpr std::integral_constant<std::size_t, 8> kTwo32;
    constexpr std::integral_constant<std::size_t, 4> kTwo16;
    const std::uint32_t* colors = map.colors.data();
    const float* depths = map.visibility.depth.data();
    const std::uint16_t* records = map.records.data();
    for (int j = 0; j < kTileSize; ++j) {
        if (tile.rows[j] == 0) continue;
        const std::size_t first = std::size_t(j) * kTileSize;
        for (std::size_t p = first; p < first + kTileSize; ++p) {
            const auto at = std::size_t(samples.quad[p]);
            copy(samples.upper_colors + 2 * p, colors + at, kTwo32);
            copy(samples.lower_colors + 2 * p, colors + at + row_step, kTwo32);
        }
        if (check)
            for (std::size_t p = first; p < first + kTileSize; ++p) {
                const auto at = std::size_t(samples.quad[p]);
                copy(samples.upper_depths + 2 * p, depths + at, kTwo32);
                copy(samples.lower_depths + 2 * p, depths + at + row_step, kTwo32);
                copy(samples.upper_records + p, records + at, kTwo16);
                copy(samples.lower_records + p, records + at + row_step, kTwo16);
            }
        if (wanted.depths)
            for (std::size_t p = first; p < first + kTileSize; ++p)
                samples.depths[p] = depths[std::size_t(samples.nearest[p])];
        if (!wanted.names) continue;
        for (std::size_t p = first; p < first + kTileSize; ++p) {
            const auto at = std::size_t(samples.nearest[p]);
            samples.instances[p] = map.visibility.instance[at];
            samples.triangles[p] = map.visibility.triangle[at];
        }
    }
}

void name(const LookupJob& job, const TileRequest& tile, int row, std::uint32_t bits, std::uint32_t record,
          const TileSamples& samples) {
    const PanoramaMap& map = *job.map;
    VisibilityBuffer& target = *job.target.visibility;
    const std::size_t first = target.index(tile.x, tile.y + row);
    for (; bits != 0; bits &= bits - 1) {
        const auto i = std::size_t(std::countr_zero(bits));
        const std::size_t pixel = std::size_t(row) * kTileSize + i;
        const auto at = std::size_t(samples.nearest[pixel]);
        target.instance[first + i] = map.visibility.instance[at];
        target.triangle[first + i] = map.visibility.triangle[at];
        const float moved_z = job.moved_z[record != kMixedRecords ? record : map.records[at]];
        target.depth[first + i] = map.visibility.depth[at] * samples.inverse_axis[pixel] + moved_z;
    }
}

HWY_EXPORT(LookupTile);
HWY_EXPORT(UpdateQuads);

void prefetch_colors(const PanoramaMap& map, const TileFootprint& footprint) {
    if (footprint.face < 0) return;
    constexpr int kLine = 64 / sizeof(std::uint32_t);
    for (int row = footprint.y0; row <= footprint.y1; ++row) {
        const std::uint32_t* first = map.colors.data() + map.index(footprint.x0, row);
        const int width = footprint.x1 - footprint.x0;
        for (int x = 0; x < width; x += kLine) __builtin_prefetch(first + x);
        __builtin_prefetch(first + width);
    }
}

void lookup_tile(const LookupJob& job, const TileRequest& tile, const TileFootprint& footprint, TileClasses& out) {
    HWY_DYNAMIC_DISPATCH(LookupTile)(job, tile, footprint, out);
}
void update_quads(PanoramaMap& map, int tile_x, int tile_row, const TexelBox& box, const ContrastLimits& contrast) {
    HWY_DYNAMIC_DISPATCH(UpdateQuads)(map, tile_x, tile_row, box, contrast);
}

TexelBox quads_that_see(int dx, int dy) {
    constexpr std::uint8_t kFirst[3] = {0, 0, kTileSize - 2}, kLast[3] = {0, kTileSize - 1, kTileSize - 1};
    return {kFirst[dx + 1], kLast[dx + 1], kFirst[dy + 1], kLast[dy + 1]};
}

float bin_upper_end(std::uint8_t bin) {
    if (bin < kClassFirstStale) return 0.0f;
    return std::bit_cast<float>((std::int32_t(bin) - kClassFirstStale + kFirstBin + 1) << kBinShift);
}

std::uint8_t bin_of(float value) {
    if (!(value > 0)) return 0;
    const std::int32_t bin = (std::bit_cast<std::int32_t>(value) >> kBinShift) - kFirstBin + kClassFirstStale;
    return std::uint8_t(std::clamp<std::int32_t>(bin, kClassFirstStale, kClassLastStale));
}

TileFootprint footprint_of(const PanoramaMap& map, const PinholeView& view, const TileRequest& tile) {
    // A tile is a convex cone, and so is a face: where the corners are, all is. The map from one to the other is
    // projective, so the corners' box bounds all pixels.
    TileFootprint out;
    float low_x = 0, high_x = 0, low_y = 0, high_y = 0;
    for (int corner = 0; corner < 4; ++corner) {
        const Vec3 d =
            view.direction(int(tile.x) + (corner & 1) * (kTileSize - 1), int(tile.y) + (corner >> 1) * (kTileSize - 1));
        const FacePoint p = face_point(d);
        const float x = texel_x(map, p.a), y = texel_y(map, p.b);
        if (corner == 0) {
            out.face = p.face;
            low_x = high_x = x;
            low_y = high_y = y;
        } else if (p.face != out.face) {
            out.face = -1;
            return out;
        }
        low_x = std::min(low_x, x), high_x = std::max(high_x, x);
        low_y = std::min(low_y, y), high_y = std::max(high_y, y);
    }
    // A tenth of a texel for rounding; one more for the quad's far side.
    const int last = map.size - 1;
    out.x0 = std::clamp(int(low_x - 0.1f), 0, last);
    out.x1 = std::clamp(int(high_x + 1.1f), 0, last);
    out.y0 = out.face * map.size + std::clamp(int(low_y - 0.1f), 0, last);
    out.y1 = out.face * map.size + std::clamp(int(high_y + 1.1f), 0, last);
    return out;
}

float tile_parallax_bound(const LookupJob& job, const TexelTile& tile) {
    if (tile.record == kNeverTraced || tile.record == kMixedRecords) return std::numeric_limits<float>::infinity();
    const float ex = job.moved_x[tile.record], ey = job.moved_y[tile.record], ez = job.moved_z[tile.record];
    const float moved = std::sqrt(ex * ex + ey * ey + ez * ez);
    if (moved == 0) return 0;
    // A texel's axial depth is at most its distance; the screen's corner sees it under the largest angle.
    const PinholeView& view = *job.view;
    const float u = std::max(std::fabs(view.u_first), std::fabs(view.u_first + view.u_step * float(view.width)));
    const float v = std::max(std::fabs(view.v_first), std::fabs(view.v_first + view.v_step * float(view.height)));
    const float distance = tile.nearest_m - moved;
    return distance > 0 ? job.focal_px * moved * (1 + u * u + v * v) / distance
                        : std::numeric_limits<float>::infinity();
}

bool is_tile_good(const LookupJob& job, const TexelTile& tile) {
    if (!tile.complete || tile.record == kMixedRecords || tile.record == kNeverTraced) return false;
    if (!job.by_distance) return tile_parallax_bound(job, tile) <= job.limit;
    const float ex = job.moved_x[tile.record], ey = job.moved_y[tile.record], ez = job.moved_z[tile.record];
    return std::sqrt(ex * ex + ey * ey + ez * ez) <= job.limit;
}

}  // namespace ff::farfield::panorama
#endif
