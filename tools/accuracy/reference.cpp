#include "tools/accuracy/reference.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "engine/core/check.h"
#include "engine/core/hash.h"
#include "engine/core/jobs.h"
#include "engine/core/log.h"
#include "tools/accuracy/planes.h"
#include "tools/picture/picture_file.h"

namespace ff::accuracy {
namespace {

/// Changes whenever pictures of the same pack would: kept ones are then made anew.
constexpr std::uint64_t kReferenceVersion = 1;

std::uint32_t srgb_of_linear(float linear) {
    const double v = std::clamp(double(linear), 0.0, 1.0);
    const double srgb = v <= 0.0031308 ? 12.92 * v : 1.055 * std::pow(v, 1.0 / 2.4) - 0.055;
    return std::uint32_t(std::lround(255.0 * srgb));
}

/// A name for the truth of one camera.
std::string name_of(const LabScene& scene, std::size_t walk_frame) {
    const scene::WalkFrame& frame = scene.walk.frames[walk_frame];
    const double numbers[] = {frame.position.x,   frame.position.y,    frame.position.z,
                              frame.yaw_deg,      frame.pitch_deg,     frame.roll_deg,
                              scene.walk.fov_deg, double(scene.width), double(scene.height)};
    const std::uint64_t seed = scene.world.statistics().pack_hash + kReferenceVersion;
    return fmt::format("{:016x}.png", hash_bytes(std::as_bytes(std::span(numbers)), seed));
}

frame::FrameSettings exact_settings() {
    return {.mode = frame::Mode::raycast, .air_error = 0.0f};
}

}  // namespace

void average_samples(const shading::Image& samples, shading::Image& out) {
    FF_CHECK(samples.width % kSamplesPerSide == 0 && samples.height % kSamplesPerSide == 0, "{}x{} samples",
             samples.width, samples.height);
    out.resize(samples.width / kSamplesPerSide, samples.height / kSamplesPerSide);
    const auto linear = linear_of_srgb();
    parallel_for(std::size_t(out.height), [&](std::size_t y) {
        std::uint32_t* to = out.pixels.data() + y * std::size_t(out.stride);
        for (int x = 0; x < out.width; ++x) {
            float sum[3] = {};
            for (int j = 0; j < kSamplesPerSide; ++j) {
                const std::uint32_t* from = samples.pixels.data() +
                                            (y * kSamplesPerSide + std::size_t(j)) * std::size_t(samples.stride) +
                                            std::size_t(x) * kSamplesPerSide;
                for (int i = 0; i < kSamplesPerSide; ++i)
                    for (int c = 0; c < 3; ++c) sum[c] += linear[from[i] >> 8 * c & 255u];
            }
            std::uint32_t pixel = 255u << 24;
            for (int c = 0; c < 3; ++c)
                pixel |= srgb_of_linear(sum[c] / float(kSamplesPerSide * kSamplesPerSide)) << 8 * c;
            to[x] = pixel;
        }
    });
}

Result<std::vector<ReferenceFrame>> make_reference(const LabScene& scene, std::span<const ScheduledFrame> frames,
                                                   const std::filesystem::path& cache) {
    if (!cache.empty()) {
        std::error_code error;
        std::filesystem::create_directories(cache, error);
        if (error) return failure(fmt::format("{}: cannot create: {}", cache.string(), error.message()));
    }
    const auto once = scene.make_renderer(scene.width, scene.height);
    const auto often = scene.make_renderer(scene.width * kSamplesPerSide, scene.height * kSamplesPerSide);
    std::vector<ReferenceFrame> result(frames.size());
    shading::Image samples;
    Progress progress("reference, 16 samples a pixel", frames.size());
    for (std::size_t f = 0; f < frames.size(); ++f) {
        ReferenceFrame& truth = result[f];
        const Camera camera = scene.walk.camera(frames[f].walk_frame);
        once->draw(camera, scene.dynamic(frames[f].walk_frame), exact_settings(), truth.exact);
        truth.visible = once->history().visibility;
        const auto file = cache / name_of(scene, frames[f].walk_frame);
        if (std::error_code error; !cache.empty() && std::filesystem::exists(file, error)) {
            auto kept = tool::read_image(file);
            if (kept && kept->width == scene.width && kept->height == scene.height) {
                truth.image = std::move(*kept);
                progress.advance();
                continue;
            }
            log_warning("{} is damaged: making it anew", file.string());
        }
        often->draw(camera, scene.dynamic(frames[f].walk_frame), exact_settings(), samples);
        average_samples(samples, truth.image);
        if (!cache.empty()) FF_TRY(tool::write_image(file, truth.image));
        progress.advance();
    }
    return result;
}

}  // namespace ff::accuracy
