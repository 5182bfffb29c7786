#include "engine/sound/audibility.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

namespace ff::sound {

float heard_gain(const SoundSource& source, double distance_m) {
    const double gain = double(source.gain) * std::min(1.0, double(source.reference_m) / distance_m);
    return gain > 0.0 ? float(gain) : 0.0f;
}

void choose_voices(std::span<const Emitter> emitters, const WorldPos& ear, std::size_t most,
                   std::vector<std::uint32_t>& out) {
    out.clear();
    const auto loudness = [&](std::uint32_t i) {
        return heard_gain(emitters[i].source, glm::length(emitters[i].position - ear));
    };
    for (std::uint32_t i = 0; i < emitters.size(); ++i)
        if (loudness(i) >= kLeastGain) out.push_back(i);
    const std::size_t kept = std::min(most, out.size());
    std::partial_sort(out.begin(), out.begin() + std::ptrdiff_t(kept), out.end(),
                      [&](std::uint32_t a, std::uint32_t b) {
                          const float of_a = loudness(a), of_b = loudness(b);
                          return of_a != of_b ? of_a > of_b : emitters[a].id < emitters[b].id;
                      });
    out.resize(kept);
}

}  // namespace ff::sound
