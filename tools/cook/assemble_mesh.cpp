#include "tools/cook/assemble_mesh.h"

#include <meshoptimizer.h>

#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include "tools/cook/cook_bytes.h"

namespace ff::cook {
namespace {

using scene::PreparedMesh;

// Bump when gathering or prepare_mesh gives something else for the same input.
constexpr const char* kPrepareStep = "prepare_mesh 4";

std::vector<std::byte> serialize(const CookedMesh& cooked) {
    const PreparedMesh& mesh = cooked.mesh;
    ByteWriter out;
    out.reserve(mesh.geometry.positions.size() * 28 + mesh.geometry.triangle_materials.size() * 14 +
                (mesh.nodes.size() + mesh.leaves.size()) * 448 + 128);
    out.value(cooked.dropped_triangles);
    out.value(mesh.bounds);
    out.value(mesh.material_flags);
    out.array(mesh.geometry.positions);
    out.array(mesh.geometry.attributes);
    out.array(mesh.geometry.indices);
    out.array(mesh.geometry.triangle_materials);
    out.array(mesh.nodes);
    out.array(mesh.leaves);
    return out.take();
}

CookedMesh deserialize(std::span<const std::byte> bytes) {
    CookedMesh cooked;
    PreparedMesh& mesh = cooked.mesh;
    ByteReader in(bytes);
    in.value(cooked.dropped_triangles);
    in.value(mesh.bounds);
    in.value(mesh.material_flags);
    in.array(mesh.geometry.positions);
    in.array(mesh.geometry.attributes);
    in.array(mesh.geometry.indices);
    in.array(mesh.geometry.triangle_materials);
    in.array(mesh.nodes);
    in.array(mesh.leaves);
    return cooked;
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

std::string hash_materials(std::span<const std::uint16_t> material_ids, std::span<const scene::Material> materials) {
    std::vector<std::uint32_t> flags;  // all that preparing reads of materials
    flags.reserve(materials.size());
    for (const scene::Material& material : materials) flags.push_back(material.flags);
    return CacheKey("materials").add(std::as_bytes(material_ids)).add_array(flags).hex();
}

CacheKey prepared_mesh_key(const std::string& materials, const std::string& geometry) {
    return CacheKey(kPrepareStep).add(materials).add(geometry);
}

CookedMesh prepare_mesh_cached(const CacheKey& key, const std::function<GatheredMesh()>& gather,
                               std::span<const scene::Material> materials, CookCache& cache) {
    if (const auto cached = cache.find(key)) return deserialize(*cached);
    GatheredMesh gathered = gather();
    CookedMesh cooked{.mesh = {}, .dropped_triangles = gathered.dropped_triangles};
    if (!gathered.geometry.triangle_materials.empty())
        cooked.mesh = scene::prepare_mesh(std::move(gathered.geometry), materials);
    if (cache.enabled()) cache.store(key, serialize(cooked));
    return cooked;
}

}  // namespace ff::cook
