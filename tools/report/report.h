#pragma once
// What several runs measured, as one page that opens without a network.

#include <span>
#include <string>

#include "engine/core/result.h"

namespace ff::report {

/// The JSON that ff bench --each-frame, ff budget --json, ff replay --bench --each-frame --json or ff compare --json
/// printed.
struct Input {
    std::string file;  ///< names it in messages and on the page
    std::string text;
};

/// Errors: bad_input `FILE: found; expected ...`.
Result<std::string> make_page(std::span<const Input> inputs);

}  // namespace ff::report
