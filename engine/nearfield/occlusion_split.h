#pragma once
// What is drawn first because it hides much for few triangles, and what is tested against it.

#include <cstdint>
#include <vector>

#include "engine/nearfield/draw_list.h"
#include "engine/visibility/occlusion_buffer.h"

namespace ff::nearfield {

/// When culling by occlusion is worth its price. Depends on counts of work alone, never on a clock, so a frame's work
/// is the same on every run; the picture is the same with and without.
struct OcclusionSettings {
    bool enabled = true;
    /// What reading depths back, building the pyramid and testing boxes costs, in triangles that could be drawn
    /// instead.
    std::uint64_t price_triangles = 10'000;
};

class OcclusionSplit {
  public:
    /// Decides whether splitting this set pays, by its size and by what the last splits saved; if so puts in first()
    /// the instances that look big for their triangles, in the order of the set, and the rest aside.
    /// @return whether there is something to draw first and something to test
    [[nodiscard]] bool split(const scene::StaticScene& scene, const DrawSet& set, const WorldPos& camera,
                             const OcclusionSettings& settings);

    /// Tests the rest against what first() left in the buffer. Whole cells first, so that a hidden cell is one test.
    void test_rest(const scene::StaticScene& scene, const DrawSet& set, const visibility::OcclusionBuffer& buffer);

    [[nodiscard]] const std::vector<std::uint32_t>& first() const { return first_; }
    [[nodiscard]] const std::vector<std::uint32_t>& survivors() const { return survivors_; }
    [[nodiscard]] std::uint64_t hidden_instances() const { return rest_.size() - survivors_.size(); }
    [[nodiscard]] std::uint64_t hidden_triangles() const { return hidden_triangles_; }

  private:
    [[nodiscard]] bool pays(const scene::StaticScene& scene, const DrawSet& set, const OcclusionSettings& settings);
    void choose_occluders(const scene::StaticScene& scene, const DrawSet& set, const WorldPos& camera);

    static constexpr int kPauseFrames = 15;  ///< after a split that did not pay

    std::uint64_t set_triangles_ = 0, hidden_triangles_ = 0;
    int pause_ = 0;
    std::vector<std::uint32_t> first_, rest_, survivors_;
};

}  // namespace ff::nearfield
