#pragma once

#include "tools/page/page.h"

namespace ff::accuracy {

/// The lab's page, made from page/ when the tool is built.
extern const page::PageParts kPage;

}  // namespace ff::accuracy
