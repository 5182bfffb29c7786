#include "engine/replay/state_hash.h"

namespace ff::replay {
namespace {

/// The finaliser of MurmurHash3 (Appleby, public domain): every bit of the input changes half of the output's.
std::uint64_t scramble(std::uint64_t x) {
    x ^= x >> 33;
    x *= 0xFF51AFD7ED558CCDull;
    x ^= x >> 33;
    x *= 0xC4CEB9FE1A85EC53ull;
    return x ^ (x >> 33);
}

}  // namespace

std::optional<std::uint32_t> differing_entity(const StateDigest& a, const StateDigest& b) {
    constexpr std::uint32_t kP = StateDigest::kFirstModulus, kQ = StateDigest::kSecondModulus;
    std::optional<std::uint32_t> first, second;
    for (std::uint32_t lane = 0; lane < kP + kQ; ++lane) {
        if (a.lanes[lane] == b.lanes[lane]) continue;
        auto& remainder = lane < kP ? first : second;
        if (remainder) return std::nullopt;  // more than one entity
        remainder = lane < kP ? lane : lane - kP;
    }
    if (!first || !second) return std::nullopt;
    for (std::uint32_t index = *second; index < kP * kQ; index += kQ)
        if (index % kP == *first) return index;
    return std::nullopt;
}

void StateHash::entity(ecs::Entity e) {
    close_entity();
    index_ = e.index;
    mix(e.index);
    mix(e.generation);
}

void StateHash::mix(std::uint64_t value) {
    of_entity_ = scramble(of_entity_ * 0x9E3779B97F4A7C15ull + value + 1);
}

void StateHash::close_entity() {
    digest_.all = scramble(digest_.all * 0x9E3779B97F4A7C15ull + of_entity_);
    if (index_) {
        std::uint8_t& first = digest_.lanes[*index_ % StateDigest::kFirstModulus];
        std::uint8_t& second = digest_.lanes[StateDigest::kFirstModulus + *index_ % StateDigest::kSecondModulus];
        first = std::uint8_t(first * 31u + (of_entity_ & 0xFFu));
        second = std::uint8_t(second * 31u + (of_entity_ >> 8 & 0xFFu));
    }
    of_entity_ = 0;
}

StateDigest StateHash::digest() {
    close_entity();
    const StateDigest done = digest_;
    *this = {};
    return done;
}

}  // namespace ff::replay
