#pragma once

#include <vector>

#include "engine/shading/shading_pass.h"
#include "engine/shading/waves.h"

namespace ff::frame {

/// What the settings point at that one view is shaded by.
struct ViewLights {
    shading::Waves waves;
    std::vector<shading::LampLight> lamps;  ///< lit ones in view
};

}  // namespace ff::frame
