#pragma once
// A town on hills, made in memory: what the casters' and the panorama's benches run on. Terrain and buildings in cells
// of one instance each, trees as instances of a mesh of masked quads.

#include "engine/scene/scene_data.h"

namespace ff::bench {

struct TownSize {
    int cells = 8;             ///< per side, 512 m each
    int terrain_quads = 64;    ///< per cell and side
    int buildings = 200;       ///< per cell
    int trees = 100;           ///< per cell, instances
    bool masked_trees = true;  ///< else the same quads, opaque
};

/// Fills every array that casters and shading read except the BVHs; the caller may finish() it for those.
scene::SceneData make_town(const TownSize& size);

/// Ground height of the town, metres.
float town_height(float x, float z);

}  // namespace ff::bench
