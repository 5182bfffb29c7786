#pragma once

#include "tools/cook/city_block.h"

namespace ff::cook::city {

/// A parked car of about 110 triangles.
/// @param ahead  unit, plan; @param y  of the road below it
void add_car(BlockWriter& writer, const DVec2& middle, const DVec2& ahead, double y, std::uint64_t seed);

}  // namespace ff::cook::city
