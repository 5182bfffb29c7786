// ff with a loss of time in one pass: `ff_planted cast:10 budget ...` is `ff budget ...` whose pass cast takes a tenth
// longer. Its frame module is compiled with FF_PLANTED_LOSS, see there.

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <string>

#include "engine/frame/planted_loss.h"
#include "tools/ff/commands.h"

namespace ff::frame {

PlantedLoss& planted_loss() {
    static PlantedLoss loss;
    return loss;
}

}  // namespace ff::frame

int main(int argc, char** argv) {
    const std::string plant = argc > 1 ? argv[1] : "";
    const std::size_t colon = plant.find(':');
    const auto pass = std::find(ff::frame::kPassNames.begin(), ff::frame::kPassNames.end(), plant.substr(0, colon));
    if (colon == std::string::npos || pass == ff::frame::kPassNames.end()) {
        std::fprintf(stderr, "usage: ff_planted PASS:PERCENT ARGUMENTS OF ff...\n");
        return 2;
    }
    ff::frame::planted_loss() = {.pass = ff::frame::Pass(pass - ff::frame::kPassNames.begin()),
                                 .share = 1e-2 * std::atof(plant.c_str() + colon + 1)};
    argv[1] = argv[0];
    return ff::tool::run(argc - 1, argv + 1);
}
