#pragma once

#include "tools/page/page.h"

namespace ff::report {

/// The page of ff report, made from page/ when the tool is built.
extern const page::PageParts kPage;

}  // namespace ff::report
