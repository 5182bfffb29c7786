#pragma once
// Part of the reprojection: from the last frame's points to targets. Interface: reproject.h.

#include "engine/farfield/reproject.h"

namespace ff::farfield::reprojection {

/// How one axis of the old image is walked so that each point follows those that might overtake it: in the direction of
/// image motion, which is outwards from the epipole for an eye that moves forwards and towards it for one that moves
/// backwards (McMillan 1997; P3 4.2). An epipole beyond the image, or at infinity, leaves one of the parts empty.
struct AxisOrder {
    int split = 0;        ///< [0, split) and [split, size) are walked apart
    bool outward = true;  ///< the first part backwards and the second forwards; else the other way round
};

/// What all points of a frame share. Spaces: old camera axes (x right, y up, z backwards), eyes relative to each other.
struct PointsJob {
    PointsJob(const PinholeView& last_view, const VisibilityBuffer& last, const PinholeView& view,
              const ReprojectSettings& settings, std::uint32_t static_instances);

    const VisibilityBuffer& last;
    std::uint32_t static_instances;
    int width, height;  ///< of both images
    AuxiliaryLayout auxiliary;
    float u_step, u_first, v_step, v_first;  ///< tangents of an old pixel (x, y): x * u_step + u_first, for its centre
    Vec3 step;                               ///< from the old eye to the new one: right, up, forward
    Mat3 pixel_from_old;  ///< homogeneous pixel coordinates in the new image; W is depth over old depth
    float least_depth;    ///< nearer points come too fast; 0: none does
    bool use_background, check_order;
    AxisOrder columns, rows;
};

/// Sizes `points`, says in which bands the old rows are walked, and how depths follow.
void begin_points(const PointsJob& job, ReprojectedPoints& points);

/// Fills targets and their bounds for a band of old rows; takes out the points that the order along each row distrusts,
/// or that along each column within the band.
void project_band(const PointsJob& job, std::size_t band, ReprojectedPoints& points);

/// Takes out the points of some old columns that the order along each column distrusts beyond their band. Multiples of
/// 16; after all bands are projected.
void check_columns(const PointsJob& job, int first_column, int last_column, ReprojectedPoints& points);

}  // namespace ff::farfield::reprojection
