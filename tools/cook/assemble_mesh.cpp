#include "tools/cook/assemble_mesh.h"

#include <meshoptimizer.h>

#include <cstring>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

namespace ff::cook {
namespace {

using scene::PreparedMesh;

// Bump when prepare_mesh's output changes for the same input.
constexpr const char* kPrepareStep = "prepare_mesh 3";

template <class T>
void write_array(std::vector<std::byte>& to, const std::vector<T>& values) {
    const std::uint64_t count = values.size();
    const auto size = std::as_bytes(std::span(&count, 1));
    const auto bytes = std::as_bytes(std::span(values));
    to.insert(to.end(), size.begin(), size.end());
    to.insert(to.end(), bytes.begin(), bytes.end());
}

// Entries are verified by their hash: what is read is what was written.
template <class T>
void read_array(const std::vector<std::byte>& from, std::size_t& at, std::vector<T>& values) {
    std::uint64_t count = 0;
    std::memcpy(&count, from.data() + at, sizeof count);
    at += sizeof count;
    values.resize(count);
    std::memcpy(values.data(), from.data() + at, count * sizeof(T));
    at += count * sizeof(T);
}

struct PreparedHead {
    Box3 bounds;
    std::uint32_t material_flags = 0;
};

std::vector<std::byte> serialize(const PreparedMesh& mesh) {
    std::vector<std::byte> bytes;
    bytes.reserve(mesh.geometry.positions.size() * 28 + mesh.geometry.triangle_materials.size() * 14 +
                  (mesh.nodes.size() + mesh.leaves.size()) * 448 + 128);
    write_array(bytes, std::vector<PreparedHead>{{mesh.bounds, mesh.material_flags}});
    write_array(bytes, mesh.geometry.positions);
    write_array(bytes, mesh.geometry.attributes);
    write_array(bytes, mesh.geometry.indices);
    write_array(bytes, mesh.geometry.triangle_materials);
    write_array(bytes, mesh.nodes);
    write_array(bytes, mesh.leaves);
    return bytes;
}

PreparedMesh deserialize(const std::vector<std::byte>& bytes) {
    PreparedMesh mesh;
    std::size_t at = 0;
    std::vector<PreparedHead> head;
    read_array(bytes, at, head);
    mesh.bounds = head[0].bounds;
    mesh.material_flags = head[0].material_flags;
    read_array(bytes, at, mesh.geometry.positions);
    read_array(bytes, at, mesh.geometry.attributes);
    read_array(bytes, at, mesh.geometry.indices);
    read_array(bytes, at, mesh.geometry.triangle_materials);
    read_array(bytes, at, mesh.nodes);
    read_array(bytes, at, mesh.leaves);
    return mesh;
}

}  // namespace

void MeshGatherer::place(const DVec3& position, const Mat3& world_from_mesh) {
    offset_ = position - origin_;
    linear_ = DMat3(world_from_mesh);
    moves_only_ = world_from_mesh == Mat3(1.0f);
    if (moves_only_) {
        mirrors_ = false;
        return;
    }
    mirrors_ = glm::determinant(linear_) < 0.0;
    normal_matrix_ = glm::transpose(glm::inverse(linear_));
}

MeshGatherer::Vertex MeshGatherer::placed(const Vec3& position, const scene::VertexAttributes& attributes) const {
    Vertex vertex{.position = Vec3(linear_ * DVec3(position) + offset_), .attributes = attributes};
    vertex.position += 0.0f;  // -0 and +0 are one vertex
    if (!moves_only_) {
        const DVec3 normal = normal_matrix_ * DVec3(scene::decode_normal(attributes.normal_oct));
        scene::encode_normal(Vec3(glm::normalize(normal)), vertex.attributes.normal_oct);
    }
    return vertex;
}

bool MeshGatherer::add(const scene::MeshSource& mesh, std::uint32_t triangle, std::uint16_t material) {
    Vertex corners[3];
    for (std::size_t c = 0; c < 3; ++c) {
        const std::uint32_t index = mesh.indices[3 * std::size_t{triangle} + c];
        corners[c] = placed(mesh.positions[index], mesh.attributes[index]);
    }
    const DVec3 normal = glm::cross(DVec3(corners[1].position) - DVec3(corners[0].position),
                                    DVec3(corners[2].position) - DVec3(corners[0].position));
    if (!(glm::dot(normal, normal) > 0.0)) return false;
    if (mirrors_) std::swap(corners[1], corners[2]);
    vertices_.insert(vertices_.end(), std::begin(corners), std::end(corners));
    materials_.push_back(material);
    return true;
}

scene::MeshSource MeshGatherer::take() {
    scene::MeshSource mesh;
    mesh.indices.resize(vertices_.size());
    if (!vertices_.empty()) {
        const std::size_t count = meshopt_generateVertexRemap(mesh.indices.data(), nullptr, vertices_.size(),
                                                              vertices_.data(), vertices_.size(), sizeof(Vertex));
        mesh.positions.resize(count);
        mesh.attributes.resize(count);
        for (std::size_t i = 0; i < vertices_.size(); ++i) {
            mesh.positions[mesh.indices[i]] = vertices_[i].position;
            mesh.attributes[mesh.indices[i]] = vertices_[i].attributes;
        }
    }
    mesh.triangle_materials = std::move(materials_);
    vertices_ = {};
    materials_ = {};
    return mesh;
}

scene::PreparedMesh prepare_mesh_cached(scene::MeshSource source, std::span<const scene::Material> materials,
                                        CookCache& cache) {
    if (!cache.enabled()) return scene::prepare_mesh(std::move(source), materials);
    std::vector<std::uint32_t> flags;  // all that preparing reads of materials
    flags.reserve(materials.size());
    for (const scene::Material& material : materials) flags.push_back(material.flags);
    const CacheKey key = CacheKey(kPrepareStep)
                             .add_array(source.positions)
                             .add_array(source.attributes)
                             .add_array(source.indices)
                             .add_array(source.triangle_materials)
                             .add_array(flags);
    if (const auto cached = cache.find(key)) return deserialize(*cached);
    PreparedMesh mesh = scene::prepare_mesh(std::move(source), materials);
    cache.store(key, serialize(mesh));
    return mesh;
}

}  // namespace ff::cook
