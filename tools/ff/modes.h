#pragma once

#include <map>
#include <string>

#include "engine/frame/settings.h"

namespace ff::tool {

/// Names that --mode and --modes take. P3 calls casting every pixel ORSA, the ordinary ray shooting algorithm.
[[nodiscard]] inline const std::map<std::string, frame::Mode>& mode_names() {
    static const std::map<std::string, frame::Mode> names{{"hybrid", frame::Mode::hybrid},
                                                          {"raster", frame::Mode::raster},
                                                          {"raycast", frame::Mode::raycast},
                                                          {"orsa", frame::Mode::raycast},
                                                          {"near", frame::Mode::near},
                                                          {"beam", frame::Mode::beam},
                                                          {"reproject", frame::Mode::reproject},
                                                          {"irsa", frame::Mode::irsa},
                                                          {"beam-reuse", frame::Mode::beam_reuse}};
    return names;
}

}  // namespace ff::tool
