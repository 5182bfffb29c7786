#include "tools/cook/wave_file.h"

#include <fmt/format.h>
#include <sndfile.h>

#include <algorithm>
#include <cmath>
#include <memory>

namespace ff::cook {
namespace {

struct Closer {
    void operator()(SNDFILE* file) const { sf_close(file); }
};

constexpr int kMostSeconds = 600;

}  // namespace

Result<scene::SoundClip> read_sound(const std::filesystem::path& path, std::string name) {
    SF_INFO info{};
    const std::unique_ptr<SNDFILE, Closer> file(sf_open(path.c_str(), SFM_READ, &info));
    if (!file)
        return bad_input(fmt::format("{}: {}; expected a WAV, FLAC or Ogg file", path.string(), sf_strerror(nullptr)));
    if (info.samplerate < 1000 || info.samplerate > 192000)
        return bad_input(
            fmt::format("{}: {} samples a second; expected 1,000 to 192,000", path.string(), info.samplerate));
    if (info.frames <= 0 || info.frames > sf_count_t(kMostSeconds) * info.samplerate)
        return bad_input(
            fmt::format("{}: {} samples; expected some, of at most {} s", path.string(), info.frames, kMostSeconds));
    const auto channels = std::size_t(info.channels), frames = std::size_t(info.frames);
    std::vector<float> read(frames * channels);
    if (sf_readf_float(file.get(), read.data(), info.frames) != info.frames)
        return bad_input(fmt::format("{}: ends before its {} samples do", path.string(), frames));
    scene::SoundClip clip{.name = std::move(name), .rate_hz = std::uint32_t(info.samplerate), .samples = {}};
    clip.samples.reserve(frames);
    for (std::size_t i = 0; i < frames; ++i) {
        double sum = 0.0;
        for (std::size_t c = 0; c < channels; ++c) sum += double(read[i * channels + c]);
        const double mean = sum / double(channels);
        clip.samples.push_back(std::isfinite(mean) ? std::int16_t(std::lround(32767.0 * std::clamp(mean, -1.0, 1.0)))
                                                   : std::int16_t(0));
    }
    return clip;
}

}  // namespace ff::cook
