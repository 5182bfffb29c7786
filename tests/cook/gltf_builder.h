#pragma once
// Imports of glTF documents that tests write themselves.

#include <gtest/gtest.h>

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tests/cook/gltf_document.h"
#include "tests/support/temporary_folder.h"
#include "tools/cook/gltf_import.h"

namespace ff::test {

inline void write_bytes(const std::filesystem::path& path, const std::string& bytes) {
    std::ofstream(path, std::ios::binary) << bytes;
}

/// What came of an import, with the world it went to.
struct Imported {
    cook::WorldSource world;
    cook::CookCache cache;
    cook::CookContext context{cache};
    Result<cook::Model> model;

    explicit Imported(const std::filesystem::path& path) : model(cook::import_gltf(path, world, context)) {}
    [[nodiscard]] std::string error() const { return model ? std::string("no error") : model.error().message; }
    [[nodiscard]] const scene::MeshSource& mesh(std::size_t i = 0) const { return world.meshes.at(i).geometry; }
};

/// Imports a document from memory by way of a file.
class GltfTest : public testing::Test {
  protected:
    Imported import_glb(const std::string& bytes) {
        write_bytes(folder_ / "model.glb", bytes);
        return Imported(folder_ / "model.glb");
    }
    Imported import_builder(GltfBuilder& builder) { return import_glb(builder.glb()); }
    TemporaryFolder folder_;
};

}  // namespace ff::test
