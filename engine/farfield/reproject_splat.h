#pragma once
// Part of the reprojection: from targets to the auxiliary image. Interface: reproject.h.

#include "engine/farfield/reproject.h"

namespace ff::farfield::reprojection {

/// Empties some rows of the auxiliary image, counted with the border, and lets the points land that belong there: of
/// those in one pixel the nearest stays, of equally near ones the first in the old image's order.
void fill_rows(const VisibilityBuffer& last, const ReprojectedPoints& points, int first_row, int last_row,
               AuxiliaryImage& auxiliary);

}  // namespace ff::farfield::reprojection
