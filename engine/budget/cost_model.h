#pragma once
// What work costs on this machine, learned from frames as they run. The controllers read nothing else of time, so
// recorded costs replay the same decisions.

#include <array>

namespace ff::budget {

/// A cost per unit of work, smoothed so that one slow frame of a shared machine does not move it: the median of the
/// last few observations.
class UnitCost {
  public:
    /// @param initial_ns  believed until something was observed; nanoseconds per unit
    explicit UnitCost(double initial_ns) : value_ns_(initial_ns) {}

    /// Takes in one pass: `ms` spent on `units` of work. Ignored when it says little (few units) or is not finite.
    void observe(double ms, double units);
    [[nodiscard]] double ns() const { return value_ns_; }
    [[nodiscard]] double ms_for(double units) const { return 1e-6 * value_ns_ * units; }

  private:
    static constexpr int kWindow = 9;
    static constexpr double kMinUnits = 64.0;
    std::array<double, kWindow> recent_{};
    int count_ = 0;
    int next_ = 0;
    double value_ns_;
};

/// Costs of one frame's work. The initial values are those of a 2-core machine without a GPU; they are also the
/// recorded costs of --deterministic.
struct CostModel {
    UnitCost cast_ray{4.0};           ///< a pixel answered by the caster
    UnitCost shade_pixel{7.0};        ///< a pixel shaded from the visibility buffer
    UnitCost lookup_pixel{2.0};       ///< a pixel looked up in the panorama
    UnitCost store_pixel{4.0};        ///< a pixel entered into the panorama
    UnitCost upscale_pixel{2.0};      ///< a pixel of the image, where the frame was drawn smaller
    UnitCost horizon_azimuth{300.0};  ///< an azimuth traced
    UnitCost near_triangle{65.0};     ///< a triangle through OpenGL
    double near_fixed_ms = 4.0;       ///< OpenGL with nothing to draw: clear, read back; calibrated at load
};

}  // namespace ff::budget
