#pragma once
// A world's own life, for who shows a world that nobody plays: its flocks and loose bodies, tick by tick.

#include <cstdint>
#include <memory>
#include <vector>

#include "engine/core/result.h"
#include "engine/effects/effect.h"
#include "engine/math/camera.h"
#include "engine/scenery/shown_model.h"

namespace ff::scenery {

inline constexpr double kTicksPerSecond = 120.0;

struct ScenerySettings {
    double birds_within_m = 600.0;   ///< see Flocks::within_m
    double bodies_within_m = 300.0;  ///< bodies farther from the viewer are held where they are. (0, 100,000]
};

/// Threads: one; a tick uses the workers of jobs.h itself.
class Scenery {
  public:
    /// Makes entities, systems and a physics world for what the world calls for, and only for that.
    /// Errors (bad input): a loose body whose shape is flat, or of too few points.
    /// @param world    must outlive this
    /// @param without  of birds and rigid_bodies: birds are not there then, bodies stay where the world has them
    static Result<std::unique_ptr<Scenery>> make(const scene::World& world, const ScenerySettings& settings = {},
                                                 effects::EffectSet without = 0);
    ~Scenery();
    Scenery(const Scenery&) = delete;
    Scenery& operator=(const Scenery&) = delete;

    /// As make() left it. What ticks have taken from the heap is kept: who goes through the same again takes nothing.
    void reset();
    /// One tick on. Steady ticks allocate nothing.
    void tick(const Camera& viewer);
    [[nodiscard]] std::uint64_t ticks() const;

    /// Adds what is there now to what a frame shows.
    /// @param without  as of make(), for this frame alone
    void show(std::vector<scene::Instance>& instances, std::vector<animation::ModelState>& models,
              effects::EffectSet without = 0) const;

    /// What the ticks since the last call of this did, for FrameSettings::simulations.
    [[nodiscard]] effects::Simulations take_work();

  private:
    struct Impl;
    explicit Scenery(std::unique_ptr<Impl> impl);
    std::unique_ptr<Impl> impl_;
};

}  // namespace ff::scenery
