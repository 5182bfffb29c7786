#include "engine/ecs/commands.h"

#include <algorithm>

namespace ff::ecs {

void* Commands::allocate(std::size_t size, std::size_t alignment) {
    for (;; ++block_) {
        if (block_ == blocks_.size()) {
            const std::size_t bytes = std::max(kBlockBytes, size + alignment);
            blocks_.push_back({std::make_unique<std::byte[]>(bytes), bytes, 0});
        }
        Block& block = blocks_[block_];
        const auto address = reinterpret_cast<std::uintptr_t>(block.bytes.get()) + block.used;
        const std::size_t padding = (alignment - address % alignment) % alignment;
        if (block.used + padding + size > block.size) continue;
        std::byte* const place = block.bytes.get() + block.used + padding;
        block.used += padding + size;
        return place;
    }
}

void Commands::apply(Registry& registry) {
    created_.clear();
    for (const Command& command : commands_) {
        Entity target = command.target;
        if (target.generation == kPending) target = target.index < created_.size() ? created_[target.index] : Entity{};
        if (const Entity made = command.run(registry, target, command.payload)) created_.push_back(made);
    }
    clear();
}

void Commands::clear() {
    for (const Command& command : commands_) command.drop(command.payload);
    commands_.clear();
    for (Block& block : blocks_) block.used = 0;
    block_ = 0;
    created_count_ = 0;
}

}  // namespace ff::ecs
