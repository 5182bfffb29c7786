#pragma once

#include <flatbuffers/flatbuffers.h>

#include <cstdint>

namespace ff::assets {

/// Whether a FlatBuffers vector of structs lies where the structs may be read in place: the verifier (2.0) looks at
/// its range, but at its alignment only as far as the length's 4 bytes. The fuzzer found it.
template <class Struct>
[[nodiscard]] bool is_aligned(const flatbuffers::Vector<const Struct*>& vector) {
    return vector.size() == 0 || reinterpret_cast<std::uintptr_t>(vector.Data()) % alignof(Struct) == 0;
}

}  // namespace ff::assets
