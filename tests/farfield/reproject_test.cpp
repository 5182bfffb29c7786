// The reprojection against its plain reference and against the truth, for every kind of motion.

#include "engine/farfield/reproject.h"

#include <gtest/gtest.h>

#include <cmath>

#include "engine/core/jobs.h"
#include "engine/farfield/reproject_reference.h"
#include "engine/farfield/reproject_votes.h"
#include "engine/farfield/visibility_difference.h"
#include "tests/support/tiles.h"
#include "tests/support/worlds.h"

namespace ff::farfield {
namespace {

constexpr int kWidth = 152, kHeight = 120;  // no whole number of tiles

std::vector<TileRequest> whole_image() {
    return test::all_tiles(kWidth, kHeight);
}

struct Motion {
    const char* name;
    Camera to;  ///< added to the first camera: position in its own axes (right, up, forward), angles
};

/// Every kind of motion that the reprojection has to be right for.
std::vector<Motion> motions() {
    const auto moved = [](double right, double up, double forward) {
        Camera camera;
        camera.position = {right, up, forward};
        return camera;
    };
    const auto turned = [](double yaw, double pitch, double roll, double forward = 0.0) {
        Camera camera;
        camera.position = {0.0, 0.0, forward};
        camera.yaw = yaw;
        camera.pitch = pitch;
        camera.roll = roll;
        return camera;
    };
    return {{"none", {}},
            {"a billionth of a metre", moved(1e-9, 0, 1e-9)},
            {"pure rotation", turned(0.05, -0.02, 0.1)},
            {"roll", turned(0, 0, 1.3)},
            {"sideways", moved(0.3, 0, 0)},
            {"up", moved(0, 0.3, 0)},
            {"forward", moved(0, 0, 0.3)},
            {"forward, epipole on a pixel's corner", moved(0, 0, 0.1)},
            {"backward", moved(0, 0, -0.3)},
            {"forward and turning", turned(0.03, 0.01, -0.2, 0.2)},
            {"half turn", turned(kPi, 0, 0)},
            {"half roll", turned(0, 0, kPi)},
            {"teleport", moved(40, 10, 25)}};
}

Camera apply(const Camera& from, const Motion& motion) {
    Camera to = from;
    const DMat3 axes = world_from_camera(from);
    to.position += axes * DVec3(motion.to.position.x, motion.to.position.y, -motion.to.position.z);
    to.yaw += motion.to.yaw;
    to.pitch += motion.to.pitch;
    to.roll += motion.to.roll;
    return to;
}

/// Two frames of a world: the first cast, the second reprojected.
struct TwoFrames {
    scene::StaticScene scene;
    PinholeView last_view, view;
    VisibilityBuffer last, truth, out;
    Reprojection reprojection;
    bool has_landed = false;
    ReprojectCounts counts;
    std::vector<TileRequest> left;

    TwoFrames(const scene::StaticScene& world, const Camera& from, const Camera& to, const ReprojectSettings& settings,
              std::uint64_t frame_number = 5)
        : scene(world),
          last_view(make_view(from, kWidth, kHeight)),
          view(make_view(to, kWidth, kHeight)),
          reprojection(world) {
        const auto caster = make_beam_caster(scene);
        for (VisibilityBuffer* buffer : {&last, &truth, &out}) buffer->resize(kWidth, kHeight);
        caster->cast_tiles(last_view, whole_image(), last);
        caster->cast_tiles(view, whole_image(), truth);
        has_landed = reprojection.reproject(last_view, last, view, settings);
        out = last;
        if (has_landed)
            counts = reprojection.verify(view, settings, frame_number, out, left);
        else
            left = whole_image();
    }

    [[nodiscard]] PixelCause cause(int x, int y) const { return reprojection.causes().at(x, y); }
    /// Casts what is left; @return pixels that are not as they should be
    std::uint64_t finish() {
        make_beam_caster(scene)->cast_tiles(view, left, out);
        return count_wrong_pixels(out, truth);
    }
};

template <class Visit>
void visit_pixels(Visit&& visit) {
    for (int y = 0; y < kHeight; ++y)
        for (int x = 0; x < kWidth; ++x) visit(x, y);
}

/// Properties that hold whatever the world, the motion and the settings.
void expect_sound(TwoFrames& frames, const std::string& what) {
    if (!frames.has_landed) {
        EXPECT_EQ(frames.finish(), 0u) << what;
        return;
    }
    const ReprojectCounts& counts = frames.counts;
    EXPECT_EQ(counts.verified + counts.background + counts.failed + counts.resampled + counts.abrupt,
              std::uint64_t(kWidth * kHeight))
        << what;
    std::uint64_t unlike = 0, asked = 0;
    PixelMask left;
    left.reset(kWidth, kHeight);
    for (const TileRequest& tile : frames.left)
        for (int j = 0; j < kTileSize; ++j)
            for (int i = 0; i < kTileSize; ++i)
                if (((tile.rows[j] >> i) & 1) != 0) left.set(tile.x + i, tile.y + j);
    visit_pixels([&](int x, int y) {
        const std::size_t at = frames.out.index(x, y);
        const PixelCause cause = frames.cause(x, y);
        const bool is_answered = cause == PixelCause::verified || cause == PixelCause::background;
        EXPECT_NE(left.test(x, y), is_answered) << what << ", pixel " << x << ' ' << y;
        asked += !is_answered;
        if (cause == PixelCause::verified) {
            // One intersection says the same; rounding may put a ray just beside an edge, or on another texel.
            const double depth = intersect_primitive(frames.scene, frames.view, x, y, frames.out.instance[at],
                                                     frames.out.triangle[at], 1e-3);
            unlike += !(std::fabs(double(frames.out.depth[at]) - depth) <= 1e-3 * depth);
        }
        if (cause == PixelCause::background) {
            EXPECT_EQ(frames.out.instance[at], kSkyInstance) << what;
        }
    });
    EXPECT_EQ(asked, counts.failed + counts.resampled + counts.abrupt) << what;
    EXPECT_LE(unlike, std::uint64_t(kWidth * kHeight / 1000)) << what;
    frames.finish();
    visit_pixels([&](int x, int y) {
        EXPECT_NE(frames.out.instance[frames.out.index(x, y)], kUnresolved) << what << ": an unanswered pixel";
    });
}

Camera street_camera() {
    Camera camera;
    camera.position = {3.0, 2.0, 10.0};
    camera.yaw = 0.2;
    return camera;
}

struct NamedWorld {
    const char* name;
    scene::SceneData data;
};

std::vector<NamedWorld> worlds() {
    std::vector<NamedWorld> all;
    all.push_back({"city", test::make_city({.cells = 3, .subdivisions = 2})});
    all.push_back({"forest", test::make_forest({.trees = 60, .size_m = 60, .masked = true, .leaves = 60})});
    return all;
}

TEST(Reproject, is_sound_for_every_motion_with_and_without_its_checks) {
    for (const NamedWorld& world : worlds())
        for (const Motion& motion : motions())
            for (const bool checked : {true, false}) {
                ReprojectSettings settings;
                if (!checked)
                    settings = {.vote = Vote::any,
                                .check_view_frustum = false,
                                .check_occlusion = false,
                                .resample_period = 0,
                                .check_abrupt = false};
                TwoFrames frames(world.data.view(), street_camera(), apply(street_camera(), motion), settings);
                expect_sound(frames, std::string(world.name) + ", " + motion.name + (checked ? "" : ", unchecked"));
            }
}

TEST(Reproject, answers_what_the_reference_answers) {
    for (const NamedWorld& world : worlds())
        for (const Motion& motion : motions())
            for (const Vote vote : {Vote::surface, Vote::primitive, Vote::any}) {
                const ReprojectSettings settings{.vote = vote, .check_view_frustum = false};
                TwoFrames frames(world.data.view(), street_camera(), apply(street_camera(), motion), settings);
                VisibilityBuffer expected;
                expected.resize(kWidth, kHeight);
                const auto causes = reproject_reference(frames.scene, frames.last_view, frames.last, frames.view,
                                                        settings, 5, expected);
                ASSERT_TRUE(frames.has_landed);
                std::uint64_t differ = 0;
                visit_pixels([&](int x, int y) {
                    const PixelCause cause = causes[std::size_t(y) * kWidth + std::size_t(x)];
                    const bool is_answered = cause == PixelCause::verified || cause == PixelCause::background;
                    differ += frames.cause(x, y) != cause ||
                              (is_answered && is_wrong_pixel(frames.out, expected, expected.index(x, y)));
                });
                // Points that land on the border of two pixels in float, and in double do not.
                EXPECT_LE(differ, std::uint64_t(kWidth * kHeight / 400))
                    << world.name << ", " << motion.name << ", vote " << int(vote);
            }
}

TEST(Reproject, a_viewer_who_rests_sees_all_but_the_resampled_pixels_again) {
    for (const NamedWorld& world : worlds()) {
        // Leaves have too few points of their own around them to win a vote, as has sky between them.
        TwoFrames frames(world.data.view(), street_camera(), street_camera(), {.vote = Vote::any});
        ASSERT_TRUE(frames.has_landed);
        EXPECT_LE(frames.counts.failed, std::uint64_t(kWidth * kHeight / 40)) << world.name;
        EXPECT_EQ(frames.counts.abrupt, 0u);
        EXPECT_LE(frames.finish(), std::uint64_t(kWidth * kHeight / 2000)) << world.name;
    }
}

TEST(Reproject, most_pixels_are_verified_where_the_viewer_walks_or_turns) {
    const scene::SceneData city = test::make_city({.cells = 3, .subdivisions = 2});
    Camera to = street_camera();
    to.position += world_from_camera(to) * DVec3(0.0, 0.0, -0.03);
    to.yaw += 0.01;
    TwoFrames frames(city.view(), street_camera(), to, {});
    EXPECT_GE(frames.counts.verified + frames.counts.background, std::uint64_t(0.8 * kWidth * kHeight));
    EXPECT_LE(frames.finish(), std::uint64_t(0.005 * kWidth * kHeight));
}

TEST(Reproject, nothing_changes_ten_thousand_kilometres_from_the_origin) {
    const WorldPos far(1e7, 0.0, -1e7);
    const scene::SceneData here = test::make_city({.cells = 3, .subdivisions = 2});
    const scene::SceneData there = test::make_city({.cells = 3, .subdivisions = 2}, {.origin = far});
    for (const Motion& motion : motions()) {
        const Camera from = street_camera(), to = apply(from, motion);
        Camera far_from = from, far_to = to;
        far_from.position += far;
        far_to.position += far;
        TwoFrames near_frames(here.view(), from, to, {}), far_frames(there.view(), far_from, far_to, {});
        if (motion.to.position.x == 1e-9) continue;  // there is no such step out there
        EXPECT_EQ(near_frames.has_landed, far_frames.has_landed) << motion.name;
        const auto verified = [](const TwoFrames& frames) { return double(frames.counts.verified); };
        EXPECT_NEAR(verified(near_frames), verified(far_frames), 0.005 * kWidth * kHeight) << motion.name;
        EXPECT_LE(far_frames.finish(), near_frames.finish() + kWidth * kHeight / 200) << motion.name;
    }
}

TEST(Reproject, the_view_frustum_check_lets_forward_steps_and_turns_pass_alone) {
    const scene::SceneData city = test::make_city({.cells = 3});
    for (const Motion& motion : motions()) {
        const DVec3& step = motion.to.position;
        const bool inside = step == DVec3(0.0) || (step.z > 0.0 && std::fabs(step.x) < 0.7 * step.z);
        if (step.x == 1e-9 || step.x == 40.0) continue;  // on the border; far off either way
        TwoFrames frames(city.view(), street_camera(), apply(street_camera(), motion), {});
        EXPECT_EQ(frames.has_landed, inside) << motion.name;
    }
}

/// A wall, a post before it, and a narrower post between them which the first hides from the origin.
scene::SceneData hidden_post_world() {
    scene::SceneData data;
    data.materials.push_back(test::plain_material());
    scene::MeshSource mesh;
    test::append_box(mesh, {-60, -60, -42}, {60, 60, -40}, 4, 0);
    test::append_box(mesh, {-0.1f, -20, -4.1f}, {0.1f, 20, -4.0f}, 1, 0);
    test::append_box(mesh, {-0.1f, -20, -8.1f}, {0.1f, 20, -8.0f}, 1, 0);
    const std::uint32_t id = data.add_mesh(scene::prepare_mesh(std::move(mesh), data.materials));
    data.add_instance(id, WorldPos(0.0), Mat3(1.0f), 0);
    data.finish(64);
    return data;
}

TEST(Reproject, points_that_were_overtaken_do_not_hide_what_stood_behind_the_overtaker) {
    const scene::SceneData data = hidden_post_world();
    Camera from, to;
    from.position = {0.0, 0.0, 0.0};
    to.position = {0.6, 0.0, 0.0};
    ReprojectSettings settings{.check_view_frustum = false, .resample_period = 0, .check_abrupt = false};
    TwoFrames with(data.view(), from, to, settings);
    settings.check_occlusion = false;
    TwoFrames without(data.view(), from, to, settings);
    const std::uint64_t wrong_with = with.finish(), wrong_without = without.finish();
    EXPECT_GE(wrong_without, std::uint64_t(2 * kHeight)) << "the hidden post is not where the test wants it";
    EXPECT_LE(wrong_with, wrong_without / 10);
}

TEST(Reproject, points_that_come_too_fast_are_cast) {
    const scene::SceneData city = test::make_city({.cells = 3});
    Camera to = street_camera();
    to.position += world_from_camera(to) * DVec3(0.0, 0.0, -1.0);
    TwoFrames frames(city.view(), street_camera(), to, {});
    EXPECT_GT(frames.counts.abrupt, 0u);
    visit_pixels([&](int x, int y) {
        if (frames.cause(x, y) == PixelCause::verified) {
            EXPECT_GE(frames.out.depth[frames.out.index(x, y)], 0.9f * 2.0f * 4.0f) << "delta = t / 2 / N";
        }
    });
}

/// A street, and the same street with a box in it that comes last, so that all other names stay.
struct EditedWorld {
    scene::SceneData without, with;
    DBox3 box;
};
EditedWorld edited_world() {
    const Camera camera = street_camera();
    const WorldPos place = camera.position + world_from_camera(camera) * DVec3(0.4, 0.0, -6.0);
    const auto make = [&](bool has_box) {
        scene::SceneData data = test::make_city({.cells = 3, .subdivisions = 2});
        scene::MeshSource mesh;
        test::append_box(mesh, {-0.7f, -0.7f, -0.7f}, {0.7f, 0.7f, 0.7f}, 3, 0);
        const std::uint32_t id = data.add_mesh(scene::prepare_mesh(std::move(mesh), data.materials));
        data.add_instance(id, has_box ? place : place + DVec3(0.0, -500.0, 0.0), Mat3(1.0f), 0);
        data.finish(64);
        return data;
    };
    EditedWorld world{make(false), make(true), {}};
    world.box.add(place - DVec3(0.75));
    world.box.add(place + DVec3(0.75));
    return world;
}

TEST(Reproject, an_edit_makes_exactly_the_pixels_be_cast_whose_rays_meet_its_box) {
    const EditedWorld world = edited_world();
    const auto tiles = whole_image();
    Camera to = street_camera();
    to.position += world_from_camera(to) * DVec3(0.01, 0.0, -0.05);
    const PinholeView last_view = make_view(street_camera(), kWidth, kHeight), view = make_view(to, kWidth, kHeight);
    for (const bool appears : {true, false}) {
        const scene::StaticScene before = (appears ? world.without : world.with).view();
        const scene::StaticScene after = (appears ? world.with : world.without).view();
        VisibilityBuffer last, truth;
        last.resize(kWidth, kHeight);
        truth.resize(kWidth, kHeight);
        make_beam_caster(before)->cast_tiles(last_view, tiles, last);
        const auto caster = make_beam_caster(after);
        caster->cast_tiles(view, tiles, truth);
        const auto run = [&](bool is_told, VisibilityBuffer& out) {
            auto reprojection = std::make_unique<Reprojection>(after);
            if (is_told) reprojection->invalidate(world.box);
            EXPECT_TRUE(reprojection->reproject(last_view, last, view, {}));
            out = last;
            std::vector<TileRequest> left;
            reprojection->verify(view, {}, 5, out, left);
            VisibilityBuffer answered = out;
            caster->cast_tiles(view, left, out);
            return std::pair(std::move(reprojection), std::move(answered));
        };
        VisibilityBuffer told, untold;
        const auto [with, answered] = run(true, told);
        const auto [without, unaware] = run(false, untold);
        std::uint64_t cast_for_it = 0, wrong_in_box = 0, wrong_untold = 0;
        visit_pixels([&](int x, int y) {
            const std::size_t at = told.index(x, y);
            const auto is_answered = [&](const Reprojection& reprojection) {
                const PixelCause cause = reprojection.causes().at(x, y);
                return cause == PixelCause::verified || cause == PixelCause::background;
            };
            const auto meets = [&](double depth) {
                return meets_segment(world.box, view.position, depth * DVec3(view.direction(x, y)));
            };
            if (is_answered(*with)) {
                // No answer lies behind the box, and what is answered is what would have been.
                EXPECT_FALSE(meets(std::min(double(answered.depth[at]), 1e9) * 0.9999)) << x << ' ' << y;
            } else if (is_answered(*without)) {
                ++cast_for_it;
                EXPECT_TRUE(meets(std::min(double(unaware.depth[at]), 1e9) * 1.0001) || !appears) << x << ' ' << y;
            }
            if (!meets(1e9)) return;
            wrong_in_box += is_wrong_pixel(told, truth, at);
            wrong_untold += is_wrong_pixel(untold, truth, at);
        });
        EXPECT_GT(cast_for_it, appears ? 300u : 10u);
        EXPECT_EQ(wrong_in_box, 0u) << (appears ? "a box appears" : "a box goes");
        if (appears) {
            EXPECT_GT(wrong_untold, 300u) << "the box is not where the test wants it";
        }
    }
}

TEST(Reproject, shifted_origins_pass_over_hardly_anything_that_is_seen) {
    for (const NamedWorld& world : worlds()) {
        Camera to = street_camera();
        to.position += world_from_camera(to) * DVec3(0.02, 0.01, -0.1);
        std::uint64_t wrong[2]{}, shifted = 0;
        for (const bool shift : {false, true}) {
            const ReprojectSettings settings{.resample_period = 0, .shift_origin = shift};
            TwoFrames frames(world.data.view(), street_camera(), to, settings);
            ASSERT_TRUE(frames.has_landed);
            if (shift) {
                visit_pixels([&](int x, int y) {
                    const std::size_t at = frames.out.index(x, y);
                    const PixelCause cause = frames.cause(x, y);
                    if (cause == PixelCause::verified || cause == PixelCause::background) return;
                    EXPECT_GE(frames.out.depth[at], 0.0f);
                    shifted += frames.out.depth[at] > 0.0f;
                });
                for (const bool beams : {true, false}) {
                    const auto caster = beams ? make_beam_caster(frames.scene) : make_embree_caster(frames.scene);
                    VisibilityBuffer out = frames.out;
                    caster->cast_tiles_beyond(frames.view, frames.left, out);
                    wrong[1] = std::max(wrong[1], count_wrong_pixels(out, frames.truth));
                }
            } else {
                wrong[0] = frames.finish();
            }
        }
        EXPECT_GT(shifted, 0u) << world.name;
        EXPECT_LE(wrong[1], wrong[0] + kWidth * kHeight / 2000) << world.name;
    }
}

TEST(Reproject, casters_may_begin_behind_what_is_known_not_to_be_there) {
    // A post before a wall: rays that begin behind the post see the wall.
    const scene::SceneData data = hidden_post_world();
    Camera camera;
    const PinholeView view = make_view(camera, kWidth, kHeight);
    const auto tiles = whole_image();
    for (const bool beams : {true, false}) {
        const auto caster = beams ? make_beam_caster(data.view()) : make_embree_caster(data.view());
        VisibilityBuffer from_eye, from_zero, beyond;
        for (VisibilityBuffer* buffer : {&from_eye, &from_zero, &beyond}) buffer->resize(kWidth, kHeight);
        caster->cast_tiles(view, tiles, from_eye);
        std::fill(from_zero.depth.begin(), from_zero.depth.end(), 0.0f);
        caster->cast_tiles_beyond(view, tiles, from_zero);
        std::fill(beyond.depth.begin(), beyond.depth.end(), 12.0f);
        caster->cast_tiles_beyond(view, tiles, beyond);
        std::uint64_t posts = 0;
        visit_pixels([&](int x, int y) {
            const std::size_t at = beyond.index(x, y);
            EXPECT_EQ(from_zero.instance[at], from_eye.instance[at]);
            EXPECT_EQ(from_zero.triangle[at], from_eye.triangle[at]);
            EXPECT_EQ(from_zero.depth[at], from_eye.depth[at]);
            posts += from_eye.depth[at] < 12.0f;
            if (from_eye.depth[at] >= 12.0f) {
                EXPECT_EQ(beyond.depth[at], from_eye.depth[at]);
            } else if (!beams) {
                EXPECT_GT(beyond.depth[at], 12.0f);
            }
        });
        EXPECT_GT(posts, 500u);
    }
}

TEST(Reproject, workers_change_nothing) {
    const scene::SceneData forest = test::make_forest({.trees = 60, .size_m = 60, .masked = true, .leaves = 60});
    Camera to = street_camera();
    to.position += world_from_camera(to) * DVec3(0.01, 0.0, -0.1);
    const auto run = [&](int workers) {
        const WorkerLimit limit(workers);
        return std::make_unique<TwoFrames>(forest.view(), street_camera(), to, ReprojectSettings{});
    };
    const auto one = run(1), two = run(2);
    visit_pixels([&](int x, int y) {
        const std::size_t at = one->out.index(x, y);
        EXPECT_EQ(one->cause(x, y), two->cause(x, y));
        EXPECT_EQ(one->out.instance[at], two->out.instance[at]);
        EXPECT_EQ(one->out.triangle[at], two->out.triangle[at]);
        EXPECT_EQ(one->out.depth[at], two->out.depth[at]);
    });
}

TEST(Reproject, every_pixel_is_due_once_in_a_period) {
    for (const int period : {1, 4, 9, 16, 25, 64})
        for (const int block : {1, 2, 4, 8, 16, 32}) {
            const ReprojectSettings settings{.resample_period = period, .resample_block_px = block};
            for (int tile_y = 0; tile_y < 4; ++tile_y)
                for (int tile_x = 0; tile_x < 4; ++tile_x) {
                    int times[kTileSize][kTileSize]{};
                    for (std::uint64_t frame = 7; frame < 7 + std::uint64_t(period); ++frame) {
                        const TileMask mask = resample_mask(settings, tile_x, tile_y, frame);
                        for (int j = 0; j < kTileSize; ++j)
                            for (int i = 0; i < kTileSize; ++i) times[j][i] += (mask.rows[j] >> i) & 1;
                    }
                    for (const auto& row : times)
                        for (const int n : row) EXPECT_EQ(n, 1) << "period " << period << ", block " << block;
                }
        }
    EXPECT_EQ(resample_mask({.resample_period = 0}, 1, 2, 3).count(), 0);
}

TEST(Reproject, counts_around_pixels_are_counted_by_words_as_one_by_one) {
    test::Random random(4);
    for (int round = 0; round < 50; ++round) {
        std::uint32_t bits[kTileSize + 2];
        for (std::uint32_t& row : bits) row = random.below(1u << 18);
        for (int least = 0; least <= 9; ++least) {
            const TileMask mask = reprojection::count_around(bits, least);
            for (int j = 0; j < kTileSize; ++j)
                for (int i = 0; i < kTileSize; ++i) {
                    int count = 0;
                    for (int dy = 0; dy < 3; ++dy)
                        for (int dx = 0; dx < 3; ++dx) count += int(bits[j + dy] >> (i + dx)) & 1;
                    EXPECT_EQ((mask.rows[j] >> i) & 1, count >= least);
                }
        }
    }
}

}  // namespace
}  // namespace ff::farfield
