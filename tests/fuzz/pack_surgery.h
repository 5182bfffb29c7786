#pragma once
// Packs as somebody makes them who knows the format and means harm: any bytes, but all hashes right.

#include <cstddef>
#include <vector>

namespace ff::test {

/// Makes magic, version, sizes and hashes of header, table and blocks agree with the bytes around them, as far as they
/// can be found, so that only the checks behind the hashes stand in the way.
void fix_hashes(std::vector<std::byte>& pack);

}  // namespace ff::test
