#pragma once

#include <filesystem>

#include "engine/core/result.h"
#include "engine/shading/image_difference.h"

namespace ff::test {

/// The written tolerance; README.md says why.
inline constexpr double kGoldenLeastPsnrDb = 36.0;
inline constexpr int kGoldenLevels = 3;           ///< of 255, in any channel
inline constexpr double kGoldenMostWrong = 0.01;  ///< share of pixels off by more

[[nodiscard]] inline bool is_within_tolerance(const shading::ImageDifference& difference) {
    return difference.psnr_db >= kGoldenLeastPsnrDb && difference.wrong_pixels <= kGoldenMostWrong;
}
/// Both of one size.
[[nodiscard]] inline shading::ImageDifference golden_difference(const shading::Image& a, const shading::Image& b) {
    return shading::compare_images(a, b, kGoldenLevels);
}

/// Eight times the difference of each channel, to look at.
[[nodiscard]] shading::Image difference_image(const shading::Image& a, const shading::Image& b);

[[nodiscard]] std::filesystem::path golden_path(const std::string& name);
/// Errors: no such file, not an image, another size than expected.
Result<shading::Image> read_golden(const std::string& name);

}  // namespace ff::test
