#pragma once
// The truth that pictures are held against: sixteen samples a pixel, every one cast and shaded in full.

#include <filesystem>
#include <vector>

#include "engine/core/result.h"
#include "tools/accuracy/lab_scene.h"
#include "tools/accuracy/schedule.h"

namespace ff::accuracy {

inline constexpr int kSamplesPerSide = 4;

/// One scheduled frame's truth.
struct ReferenceFrame {
    shading::Image image;                ///< 16 samples a pixel, averaged as light
    shading::Image exact;                ///< one sample a pixel, every one cast
    farfield::VisibilityBuffer visible;  ///< what that one sees
};

/// Averages blocks of kSamplesPerSide x kSamplesPerSide pixels as light. @param samples  sides are multiples of it
void average_samples(const shading::Image& samples, shading::Image& out);

/// Makes the truths of the scheduled frames. Images of many samples are kept in the folder under a hash of the pack,
/// the cameras and the size, and read from there the next time.
/// @param cache  made where it is not there; empty: nothing is kept
/// Errors: what is kept cannot be written.
Result<std::vector<ReferenceFrame>> make_reference(const LabScene& scene, std::span<const ScheduledFrame> frames,
                                                   const std::filesystem::path& cache);

}  // namespace ff::accuracy
