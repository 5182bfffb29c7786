// The table: what each case is held to. A bound that is not 0 is what was measured, rounded up; docs/hard-cases.md says
// why it is not 0.

#include "tests/hardcases/cases.h"

namespace ff::hardcases {
namespace {

constexpr std::string_view kRaysThrough =
    "rays exactly through edges and vertices of closed meshes, from inside and outside: none passes";
constexpr std::string_view kPixelsOn =
    "pixel centres exactly on edges and vertices of a closed mesh: no leak, the right triangle, its depth";
constexpr std::string_view kOnSurface = "exact: the point lies on the surface";
constexpr std::string_view kWholeNumbers = "exact: edge functions in whole numbers";
constexpr std::string_view kAxisParallel =
    "rays along axes and in planes, with zeros of either sign and denormals, from cell faces, edges and corners";
constexpr std::string_view kFarOutside = "rays from 10,000 km outside the world hit what they are aimed at";
constexpr std::string_view kSlabs = "double: the boxes as slabs";
constexpr std::string_view kSlivers =
    "slivers of aspect 1e-7 along pixel centres before a wall: the wall, or the sliver where it is and as far as it is";
constexpr std::string_view kLine = "double: the sliver as a line";
constexpr std::string_view kDuplicates = "triangles several times and ones without area: the nearest real one shows";
constexpr std::string_view kBruteForce = "long double: every triangle";
constexpr std::string_view kWinner = "coincident triangles and instances: the same wins with one worker and with two";
constexpr std::string_view kRepeated = "exact: the other picture";
constexpr std::string_view kHuge = "chips of 1 mm over triangles of 10,000 km, in one mesh";
constexpr std::string_view kDepths =
    "sheets from 1 cm to 10,000 km in one frame, in order, each with one 0.1% behind it";
constexpr std::string_view kFarAway = "walks and turns in mode hybrid, that far from the world's origin";
constexpr std::string_view kAtOrigin = "the same pictures at the origin, to 3 of 255";
constexpr std::string_view kOpacity =
    "slivers, triangles through the near plane and far beyond the image: no pixel is covered that they leave empty";

constexpr HardCase kCases[] = {
    {"rays_through_edges.beam", kRaysThrough, kOnSurface, "of the distance", 1000000, 0, 1e-5, 1.5,
     rays_through_edges<Subject::beam>},
    {"rays_through_edges.embree", kRaysThrough, kOnSurface, "of the distance", 1000000, 2e-5, 1e-5, 1.5,
     rays_through_edges<Subject::embree>},
    {"rays_through_edges.embree_fast", kRaysThrough, kOnSurface, "of the distance", 1000000, 0.03, 1e-5, 1.5,
     rays_through_edges<Subject::embree_fast>},
    {"rays_through_edges.grid", kRaysThrough, kOnSurface, "of the distance", 1000000, 0, 1e-5, 1.6,
     rays_through_edges<Subject::grid>},
    {"pixels_on_edges.beam", kPixelsOn, kWholeNumbers, "of the depth", 1000000, 0, 1e-5, 2,
     pixels_on_edges<Subject::beam>},
    {"pixels_on_edges.embree", kPixelsOn, kWholeNumbers, "of the depth", 1000000, 2e-5, 1e-5, 1.5,
     pixels_on_edges<Subject::embree>},
    {"pixels_on_edges.embree_fast", kPixelsOn, kWholeNumbers, "of the depth", 1000000, 2e-5, 1e-5, 1.5,
     pixels_on_edges<Subject::embree_fast>},
    {"pixels_on_edges.grid", kPixelsOn, kWholeNumbers, "of the depth", 1000000, 0, 1e-5, 1.6,
     pixels_on_edges<Subject::grid>},
    {"pixels_of_tiles.beam", "tiles asked in two parts that share no pixel: each answers its own, as the whole does",
     "exact: the whole image", "", 1000000, 0, 0, 0, pixels_of_tiles},

    {"axis_parallel_rays.beam", kAxisParallel, kSlabs, "", 1000000, 0, 0, 1.5, axis_parallel_rays<Subject::beam>},
    {"axis_parallel_rays.embree", kAxisParallel, kSlabs, "", 1000000, 0, 0, 1.5, axis_parallel_rays<Subject::embree>},
    {"axis_parallel_rays.grid", kAxisParallel, kSlabs, "", 1000000, 0, 0, 1.5, axis_parallel_rays<Subject::grid>},
    {"rays_from_far_outside.beam", kFarOutside, kSlabs, "", 1000000, 0, 0, 1.5, rays_from_far_outside<Subject::beam>},
    {"rays_from_far_outside.embree", kFarOutside, kSlabs, "", 1000000, 0, 0, 1.5,
     rays_from_far_outside<Subject::embree>},
    {"rays_from_far_outside.grid", kFarOutside, kSlabs, "", 1000000, 0, 0, 1.5, rays_from_far_outside<Subject::grid>},

    {"slivers.beam", kSlivers, kLine, "of the depth", 500000, 0, 1e-5, 4, slivers<Subject::beam>},
    {"slivers.embree", kSlivers, kLine, "of the depth", 500000, 0.03, 20, 1.5, slivers<Subject::embree>},
    {"slivers.grid", kSlivers, kLine, "of the depth", 500000, 0, 1e-5, 1.5, slivers<Subject::grid>},

    {"duplicates.beam", kDuplicates, kBruteForce, "of the depth", 200000, 0, 1e-4, 3, duplicates<Subject::beam>},
    {"duplicates.embree", kDuplicates, kBruteForce, "of the depth", 200000, 0, 1e-4, 1.5, duplicates<Subject::embree>},
    {"duplicates.grid", kDuplicates, kBruteForce, "of the depth", 200000, 0, 1e-4, 3, duplicates<Subject::grid>},

    {"coincident_winner.beam", kWinner, kRepeated, "", 500000, 0, 0, 0, coincident_winner<Subject::beam>},
    {"coincident_winner.embree", kWinner, kRepeated, "", 500000, 0, 0, 0, coincident_winner<Subject::embree>},
    {"coincident_winner.grid", kWinner, kRepeated, "", 500000, 0, 0, 0, coincident_winner<Subject::grid>},

    {"huge_beside_tiny.beam", kHuge, kBruteForce, "of the depth", 200000, 0, 1e-2, 10, huge_beside_tiny<Subject::beam>},
    {"huge_beside_tiny.embree", kHuge, kBruteForce, "of the depth", 200000, 0, 1e-4, 2,
     huge_beside_tiny<Subject::embree>},
    {"huge_beside_tiny.grid", kHuge, kBruteForce, "of the depth", 200000, 0, 1e-4, 2, huge_beside_tiny<Subject::grid>},

    {"depth_order.beam", kDepths, kBruteForce, "of the depth", 200000, 0, 1e-5, 2, depth_order<Subject::beam>},
    {"depth_order.embree", kDepths, kBruteForce, "of the depth", 200000, 0.5, 1, 1.5, depth_order<Subject::embree>},
    {"depth_order.grid", kDepths, kBruteForce, "of the depth", 200000, 0, 1e-5, 1.5, depth_order<Subject::grid>},
    {"picture_far_away.1e3m", kFarAway, kAtOrigin, "", 1000000, 1e-3, 0, 1.5, picture_far_away<1000>},
    {"picture_far_away.1e6m", kFarAway, kAtOrigin, "", 1000000, 1e-3, 0, 1.5, picture_far_away<1000000>},
    {"picture_far_away.1e7m", kFarAway, kAtOrigin, "", 1000000, 1e-3, 0, 1.5, picture_far_away<10000000>},
    {"walk_far_away.1e7m", "steps of 12 mm, 10,000 km from the origin: each pixel's point lies on its triangle",
     "double: the triangle's plane", "pixels", 200000, 0, 0.05, 0, walk_far_away},
    {"horizon.bars",
     "eyes above, below, on grid nodes and edges, beside towers; up and down, 5 to 150 degrees, any roll",
     "double: every bar", "", 1000000, 0, 0, 3, horizon_over_bars},
    {"horizon.scenes",
     "the same among triangles, a hair beside walls, roofs and leaves: no pixel that a cast hits is sky",
     "a full cast (Embree)", "", 1000000, 0, 0, 0, horizon_over_scenes},
    {"panorama.seams", "views straight at poles, cube edges and corners: each pixel is answered, as far as it is",
     "a full cast", "of the depth", 1000000, 0, 0.02, 1.5, panorama_seams},
    {"panorama.turns", "a million small turns of the mouse: the view is where their sum says, the panorama still right",
     "long double: the sum", "pixels", 1500000, 0, 1e-6, 0, panorama_turns},
    {"reprojection.motions",
     "no motion, tiny, sideways, backward; epipoles on pixel centres, corners, rows, columns, borders; turns; what "
     "moves",
     "double: one intersection", "of the depth", 1000000, 1e-4, 1e-3, 3, reprojected_motions},
    {"opacity.exact", kOpacity, "double: every triangle, clipped", "", 1000000, 0, 0, 4, opacity_exact},
    {"opacity.opengl", kOpacity, "OpenGL", "", 500000, 0, 0, 0, opacity_opengl},
    {"clock.ticks", "30 days of frames, some of no time, of ten seconds, or backwards: no tick is gained or lost",
     "exact: 128-bit whole numbers", "ticks", 155520000, 0, 0, 0, clock_ticks},
    {"budget.choices", "costs of zero, tiny, huge, noisy (x10), lies, no numbers: in range, no oscillation, recovers",
     "one who never saw trouble", "turns in 100 frames", 1000000, 1e-5, 12, 0, budget_choices},
    {"budget.plans",
     "the same through the frame plan, budgets from 1 ps to 1000 s: pictures of a size that can be drawn", "ranges", "",
     200000, 0, 0, 0, budget_plans},
    {"bad_numbers.refused", "NaN and infinities in camera, settings, moving instances: refused with a message",
     "what was spoilt", "", 200000, 0, 0, 0, bad_numbers_refused},
    {"bad_numbers.never_drawn", "frames with such numbers between good ones: no pixel changes, now or later",
     "the same without them", "", 500000, 0, 0, 0, bad_numbers_never_drawn},
};

}  // namespace

std::span<const HardCase> all_cases() {
    return kCases;
}

}  // namespace ff::hardcases
