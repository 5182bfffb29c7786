#include "engine/ecs/transform_hierarchy.h"

#include <fmt/core.h>

#include <algorithm>
#include <unordered_set>

#include "engine/core/jobs.h"

namespace ff::ecs {
namespace {

constexpr std::uint32_t kUnknown = 0xFFFFFFFFu;

Mat3 linear_of(const LocalTransform& local) {
    const Mat3 rotation = glm::mat3_cast(local.rotation);
    return Mat3(rotation[0] * local.scale.x, rotation[1] * local.scale.y, rotation[2] * local.scale.z);
}

}  // namespace

Status TransformHierarchy::set_parent(Registry& registry, Entity child, Entity parent) {
    if (!registry.is_alive(child))
        return usage_error(fmt::format("set_parent: child {}:{} is not alive", child.index, child.generation));
    if (!parent) {
        if (registry.remove<Parent>(child)) parents_changed_ = true;
        return {};
    }
    if (!registry.is_alive(parent))
        return usage_error(fmt::format("set_parent: parent {}:{} is not alive", parent.index, parent.generation));
    for (Entity above = parent; registry.is_alive(above);) {
        if (above == child)
            return usage_error(fmt::format("set_parent: {}:{} hangs on {}:{}; the reverse would be a cycle",
                                           parent.index, parent.generation, child.index, child.generation));
        const Parent* const next = registry.get<Parent>(above);
        above = next ? next->entity : Entity{};
    }
    registry.add(child, Parent{parent});
    parents_changed_ = true;
    return {};
}

void TransformHierarchy::rebuild(Registry& registry) {
    links_.clear();
    entities_.clear();
    parents_.clear();
    std::uint32_t highest = 0;
    const auto is_part = [&](Entity entity) {
        return registry.has<LocalTransform>(entity) && registry.has<WorldTransform>(entity);
    };
    registry.each_chunk<const LocalTransform, const WorldTransform, Without<Parent>>(
        [&](std::span<const Entity> entities, auto, auto) {
            entities_.insert(entities_.end(), entities.begin(), entities.end());
            parents_.insert(parents_.end(), entities.size(), Entity{});
        });
    registry.each_chunk<const LocalTransform, const WorldTransform, const Parent>(
        [&](std::span<const Entity> entities, auto, auto, std::span<const Parent> parents) {
            entities_.insert(entities_.end(), entities.begin(), entities.end());
            for (const Parent& parent : parents) parents_.push_back(is_part(parent.entity) ? parent.entity : Entity{});
        });
    for (const Entity entity : entities_) highest = std::max(highest, entity.index);

    // Depth of each: up to the first known or parentless ancestor, then down again along the same path.
    depth_of_.assign(entities_.empty() ? 0 : std::size_t(highest) + 1, kUnknown);
    std::vector<Entity> path;
    std::uint32_t deepest = 0;
    const auto parent_of = [&](Entity entity) {
        const Parent* const parent = registry.get<Parent>(entity);
        return parent && is_part(parent->entity) ? parent->entity : Entity{};
    };
    for (std::size_t i = 0; i < entities_.size(); ++i) {
        path.clear();
        Entity at = entities_[i];
        while (at && depth_of_[at.index] == kUnknown && path.size() <= entities_.size()) {
            path.push_back(at);
            at = path.size() == 1 ? parents_[i] : parent_of(at);
        }
        FF_CHECK(path.size() <= entities_.size(), "a cycle of parents; set them through set_parent");
        std::uint32_t depth = at ? depth_of_[at.index] + 1 : 0;
        for (auto entity = path.rbegin(); entity != path.rend(); ++entity) depth_of_[entity->index] = depth++;
        if (!path.empty()) deepest = std::max(deepest, depth - 1);
    }

    // Counting sort by depth.
    depth_begin_.assign(entities_.empty() ? 1 : std::size_t(deepest) + 2, 0);
    for (const Entity entity : entities_) ++depth_begin_[depth_of_[entity.index] + 1];
    for (std::size_t depth = 1; depth < depth_begin_.size(); ++depth) depth_begin_[depth] += depth_begin_[depth - 1];
    std::vector<std::uint32_t> next(depth_begin_.begin(), depth_begin_.end());
    links_.resize(entities_.size());
    for (std::size_t i = 0; i < entities_.size(); ++i)
        links_[next[depth_of_[entities_[i].index]]++] = {registry.get<LocalTransform>(entities_[i]),
                                                         registry.get<WorldTransform>(entities_[i]),
                                                         registry.get<WorldTransform>(parents_[i])};
}

void TransformHierarchy::update(Registry& registry) {
    if (parents_changed_ || version_ != registry.structure_version()) {
        rebuild(registry);
        version_ = registry.structure_version();
        parents_changed_ = false;
    }
    for (std::size_t depth = 0; depth + 1 < depth_begin_.size(); ++depth) {
        const std::uint32_t first = depth_begin_[depth];
        parallel_ranges(depth_begin_[depth + 1] - first, 4096, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = first + begin; i < first + end; ++i) {
                const Link& link = links_[i];
                const Mat3 linear = linear_of(*link.local);
                if (!link.parent) {
                    *link.world = {link.local->position, linear};
                } else {
                    // In double: a child may hang far from its parent.
                    *link.world = {link.parent->position + DMat3(link.parent->linear) * link.local->position,
                                   link.parent->linear * linear};
                }
            }
        });
    }
}

std::size_t TransformHierarchy::destroy_subtree(Registry& registry, Entity root) {
    if (!registry.is_alive(root)) return 0;
    std::vector<Entity> doomed{root};
    std::unordered_set<std::uint32_t> known{root.index};  // no two alive share an index
    // A pass finds at least the children of what the pass before found.
    for (std::size_t before = 0; before < doomed.size();) {
        before = doomed.size();
        registry.each_chunk<const Parent>([&](std::span<const Entity> entities, std::span<const Parent> parents) {
            for (std::size_t i = 0; i < entities.size(); ++i)
                if (registry.is_alive(parents[i].entity) && known.contains(parents[i].entity.index) &&
                    known.insert(entities[i].index).second)
                    doomed.push_back(entities[i]);
        });
    }
    for (const Entity entity : doomed) registry.destroy(entity);
    return doomed.size();
}

}  // namespace ff::ecs
