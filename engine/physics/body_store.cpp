#include "engine/physics/body_store.h"

#include <BulletCollision/BroadphaseCollision/btDbvt.h>

#include <algorithm>
#include <array>
#include <glm/matrix.hpp>

namespace ff::physics {

/// Boxes in float, grown by what rounding takes; whoever asks looks at the bodies' own boxes, too.
struct BodyStore::Tree {
    btDbvt tree;

    static btDbvtVolume volume_of(const DBox3& box, const DVec3& origin) {
        const DVec3 low = box.low - origin, high = box.high - origin;
        const auto grow = [](double x) { return 1e-3 + 1e-6 * std::abs(x); };
        return btDbvtVolume::FromMM(
            btVector3(float(low.x - grow(low.x)), float(low.y - grow(low.y)), float(low.z - grow(low.z))),
            btVector3(float(high.x + grow(high.x)), float(high.y + grow(high.y)), float(high.z + grow(high.z))));
    }
};

Frame frame_of(const Geometry& geometry, const Pose& pose) {
    return {pose.position + matrix_of(pose.rotation) * geometry.center_of_mass, pose.rotation};
}

Pose pose_of(const Geometry& geometry, const Frame& frame) {
    return {frame.position - matrix_of(frame.rotation) * geometry.center_of_mass, frame.rotation};
}

PlacedMesh placed(const Geometry& geometry, const Frame& frame) {
    const DMat3 linear = matrix_of(frame.rotation) * DMat3(geometry.shape.body_from_mesh);
    return {frame.position, linear, glm::inverse(linear), geometry.shape.mesh, 0};
}

DVec3 carried(const Frame& from, const Frame& to, const DVec3& point) {
    if (from == to) return DVec3(0.0);
    const DVec3 arm = point - from.position;
    return (to.position - from.position) + matrix_of(to.rotation) * (glm::transpose(matrix_of(from.rotation)) * arm) -
           arm;
}

BodyStore::BodyStore(const scene::StaticScene& scene) : scene_(scene), tree_(std::make_unique<Tree>()) {}
BodyStore::~BodyStore() = default;

Result<std::shared_ptr<const Geometry>> BodyStore::geometry_of(const Shape& shape) {
    std::erase_if(geometries_, [](const auto& known) { return known.expired(); });
    for (const auto& known : geometries_)
        if (auto geometry = known.lock(); geometry && is_same(geometry->shape, shape)) return geometry;
    auto made = make_geometry(scene_, shape);
    if (made) geometries_.push_back(*made);
    return made;
}

std::uint32_t BodyStore::add(Body body) {
    std::uint32_t slot = std::uint32_t(bodies_.size());
    if (free_.empty()) {
        bodies_.emplace_back();
        bodies_[slot].generation = 1;
    } else {
        slot = free_.back();
        free_.pop_back();
    }
    body.generation = bodies_[slot].generation;
    body.alive = true;
    body.leaf = nullptr;
    bodies_[slot] = std::move(body);
    update_bounds(slot);
    return slot;
}

void BodyStore::remove(std::uint32_t slot) {
    Body& body = bodies_[slot];
    tree_->tree.remove(body.leaf);
    const std::uint32_t next = body.generation + 1;
    body = Body{};
    body.generation = next == 0 ? 1 : next;
    free_.push_back(slot);
}

void BodyStore::update_bounds(std::uint32_t slot) {
    Body& body = bodies_[slot];
    const DMat3 m = matrix_of(body.frame.rotation);
    const DBox3& local = body.geometry->bounds;
    const DVec3 center = local.center(), half = local.extent() * 0.5;
    DVec3 reach(0.0);
    for (int column = 0; column < 3; ++column) reach += glm::abs(m[column]) * half[column];
    const DVec3 middle = body.frame.position + m * center;
    body.bounds = {middle - reach, middle + reach};
    btDbvtVolume volume = Tree::volume_of(body.bounds, scene_.origin);
    if (body.leaf == nullptr) {
        tree_->tree.optimizeIncremental(1);  // what is put in along a line would hang in one chain
        body.leaf = tree_->tree.insert(volume, reinterpret_cast<void*>(std::uintptr_t(slot)));
    } else {
        tree_->tree.update(body.leaf, volume);
    }
}

Body* BodyStore::find(BodyId id) {
    if (id.index >= bodies_.size()) return nullptr;
    Body& body = bodies_[id.index];
    return body.alive && body.generation == id.generation ? &body : nullptr;
}

void BodyStore::restore(std::vector<Body> bodies, std::vector<std::uint32_t> free_slots) {
    tree_->tree.clear();
    bodies_ = std::move(bodies);
    free_ = std::move(free_slots);
    for (std::uint32_t slot = 0; slot < bodies_.size(); ++slot) {
        bodies_[slot].leaf = nullptr;
        if (bodies_[slot].alive) update_bounds(slot);
    }
}

DBox3 BodyStore::bounds() const {
    const btDbvtNode* const root = tree_->tree.m_root;
    if (root == nullptr) return {};
    const btVector3 &low = root->volume.Mins(), &high = root->volume.Maxs();
    return {scene_.origin + DVec3(low.x(), low.y(), low.z()), scene_.origin + DVec3(high.x(), high.y(), high.z())};
}

void BodyStore::find(const SweptBox& box, std::vector<std::uint32_t>& out) const {
    out.clear();
    if (tree_->tree.m_root != nullptr) find_under(*tree_->tree.m_root, box, out);
    std::sort(out.begin(), out.end());
}

void BodyStore::find_under(const btDbvtNode& root, const SweptBox& box, std::vector<std::uint32_t>& out) const {
    const auto meets = [&](const DBox3& bounds) {
        return meets_segment(DBox3{bounds.low - box.half, bounds.high + box.half}, box.from, box.along);
    };
    const DVec3& origin = scene_.origin;
    std::array<const btDbvtNode*, 128> stack;
    std::size_t size = 0;
    stack[size++] = &root;
    while (size > 0) {
        const btDbvtNode& node = *stack[--size];
        const btVector3 &low = node.volume.Mins(), &high = node.volume.Maxs();
        if (!meets({origin + DVec3(low.x(), low.y(), low.z()), origin + DVec3(high.x(), high.y(), high.z())})) continue;
        if (node.isleaf()) {
            const auto slot = std::uint32_t(reinterpret_cast<std::uintptr_t>(node.data));
            if (meets(bodies_[slot].bounds)) out.push_back(slot);
            continue;
        }
        // The tree is not balanced by force: what is too deep for the stack begins another.
        for (const btDbvtNode* const child : node.childs) {
            if (size < stack.size())
                stack[size++] = child;
            else
                find_under(*child, box, out);
        }
    }
}

}  // namespace ff::physics
