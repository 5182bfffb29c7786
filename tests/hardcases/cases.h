#pragma once
// The functions behind the table, one file per subject; each makes instances until the trial has enough.

#include "tests/hardcases/hard_case.h"
#include "tests/hardcases/subjects.h"

namespace ff::hardcases {

// edges_and_vertices.cpp
template <Subject kSubject>
void rays_through_edges(Trial& trial);
template <Subject kSubject>
void pixels_on_edges(Trial& trial);
void pixels_of_tiles(Trial& trial);

// rays_and_grids.cpp
template <Subject kSubject>
void axis_parallel_rays(Trial& trial);
template <Subject kSubject>
void rays_from_far_outside(Trial& trial);

// degenerate_triangles.cpp
template <Subject kSubject>
void slivers(Trial& trial);
template <Subject kSubject>
void duplicates(Trial& trial);
template <Subject kSubject>
void coincident_winner(Trial& trial);
template <Subject kSubject>
void huge_beside_tiny(Trial& trial);

// depth_range.cpp
template <Subject kSubject>
void depth_order(Trial& trial);

// far_from_origin.cpp
template <int kDistanceM>
void picture_far_away(Trial& trial);
void walk_far_away(Trial& trial);

// horizon.cpp
void horizon_over_bars(Trial& trial);
void horizon_over_scenes(Trial& trial);

// panorama.cpp
void panorama_seams(Trial& trial);
void panorama_turns(Trial& trial);

// opacity.cpp
void opacity_exact(Trial& trial);
void opacity_opengl(Trial& trial);

// reprojection.cpp
void reprojected_motions(Trial& trial);

// clock.cpp
void clock_ticks(Trial& trial);

// budget.cpp
void budget_choices(Trial& trial);
void budget_plans(Trial& trial);

// bad_numbers.cpp
void bad_numbers_refused(Trial& trial);
void bad_numbers_never_drawn(Trial& trial);

}  // namespace ff::hardcases
