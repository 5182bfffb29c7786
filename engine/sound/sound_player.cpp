#include "engine/sound/sound_player.h"

#include <AL/al.h>
#include <AL/alc.h>
#include <AL/alext.h>

#include <algorithm>
#include <array>
#include <limits>
#include <vector>

#include "engine/core/check.h"
#include "engine/sound/audibility.h"

namespace ff::sound {
namespace {

/// Ids of the world's own sources follow upon those of emitters.
constexpr std::uint64_t kFirstWorldId = std::uint64_t(1) << 63;
constexpr std::uint64_t kEventId = std::numeric_limits<std::uint64_t>::max();

struct DeviceCloser {
    void operator()(ALCdevice* device) const { alcCloseDevice(device); }
};
struct ContextCloser {
    void operator()(ALCcontext* context) const {
        alcMakeContextCurrent(nullptr);
        alcDestroyContext(context);
    }
};

/// An OpenAL source, and what plays on it.
struct Voice {
    ALuint source = 0;
    std::uint64_t id = 0;
    bool is_taken = false;
    WorldPos position{0.0};  ///< of an event, which stays where it was
};

}  // namespace

struct SoundPlayer::Impl {
    explicit Impl(const scene::SoundSet& set) : sounds(set) {}
    ~Impl() {
        if (!context) return;
        for (const Voice& voice : voices)
            if (voice.source != 0) alDeleteSources(1, &voice.source);
        if (!buffers.empty()) alDeleteBuffers(ALsizei(buffers.size()), buffers.data());
    }

    Status start(const ALCint* attributes);
    void begin(Voice& voice, std::uint64_t id, const WorldPos& position, const SoundSource& source, bool loops);
    void end(Voice& voice);
    Voice* free_voice();
    void place(const Voice& voice, const WorldPos& position, const WorldPos& ear) const {
        // Relative to the ear in double precision: OpenAL knows floats.
        const Vec3 at(position - ear);
        alSource3f(voice.source, AL_POSITION, at.x, at.y, at.z);
    }

    const scene::SoundSet& sounds;
    std::unique_ptr<ALCdevice, DeviceCloser> device;
    std::unique_ptr<ALCcontext, ContextCloser> context;
    std::vector<ALuint> buffers;  ///< by clip
    std::array<Voice, kMostVoices> voices;
    std::vector<Emitter> emitters;      ///< scratch: all that sounds
    std::vector<std::uint32_t> chosen;  ///< scratch
    double last_s = -std::numeric_limits<double>::infinity();
    bool is_first = true;
    LPALCRENDERSAMPLESSOFT render_samples = nullptr;
};

Status SoundPlayer::Impl::start(const ALCint* attributes) {
    context.reset(alcCreateContext(device.get(), attributes));
    if (!context || alcMakeContextCurrent(context.get()) != ALC_TRUE) {
        context.reset();
        return failure("the sound device gives no context");
    }
    alDistanceModel(AL_INVERSE_DISTANCE_CLAMPED);
    buffers.resize(sounds.clips.size());
    if (!buffers.empty()) alGenBuffers(ALsizei(buffers.size()), buffers.data());
    for (std::size_t i = 0; i < buffers.size(); ++i) {
        const scene::SoundClip& clip = sounds.clips[i];
        alBufferData(buffers[i], AL_FORMAT_MONO16, clip.samples.data(), ALsizei(2 * clip.samples.size()),
                     ALsizei(clip.rate_hz));
    }
    for (Voice& voice : voices) alGenSources(1, &voice.source);
    if (alGetError() != AL_NO_ERROR) return failure("the sound device has no room for the world's recordings");
    emitters.reserve(sounds.sources.size() + 64);
    chosen.reserve(emitters.capacity());
    return {};
}

void SoundPlayer::Impl::begin(Voice& voice, std::uint64_t id, const WorldPos& position, const SoundSource& source,
                              bool loops) {
    FF_CHECK(source.clip < buffers.size(), "sound clip {} of {}", source.clip, buffers.size());
    voice.id = id;
    voice.is_taken = true;
    voice.position = position;
    alSourcei(voice.source, AL_BUFFER, ALint(buffers[source.clip]));
    alSourcei(voice.source, AL_LOOPING, loops ? AL_TRUE : AL_FALSE);
    alSourcef(voice.source, AL_GAIN, source.gain);
    alSourcef(voice.source, AL_REFERENCE_DISTANCE, source.reference_m);
}

void SoundPlayer::Impl::end(Voice& voice) {
    if (!voice.is_taken) return;
    alSourceStop(voice.source);
    alSourcei(voice.source, AL_BUFFER, 0);
    voice.is_taken = false;
}

Voice* SoundPlayer::Impl::free_voice() {
    const auto at = std::find_if(voices.begin(), voices.end(), [](const Voice& v) { return !v.is_taken; });
    return at == voices.end() ? nullptr : &*at;
}

Result<SoundPlayer> SoundPlayer::open(const scene::SoundSet& sounds) {
    auto impl = std::make_unique<Impl>(sounds);
    impl->device.reset(alcOpenDevice(nullptr));
    if (!impl->device) return failure("no sound device");
    FF_TRY(impl->start(nullptr));
    return SoundPlayer(std::move(impl));
}

Result<SoundPlayer> SoundPlayer::open_loopback(const scene::SoundSet& sounds, int rate_hz) {
    if (alcIsExtensionPresent(nullptr, "ALC_SOFT_loopback") != ALC_TRUE)
        return failure("this OpenAL has no loopback device");
    // Extension functions have no other way to their types.
    const auto open_device =
        reinterpret_cast<LPALCLOOPBACKOPENDEVICESOFT>(alcGetProcAddress(nullptr, "alcLoopbackOpenDeviceSOFT"));
    auto impl = std::make_unique<Impl>(sounds);
    impl->render_samples = reinterpret_cast<LPALCRENDERSAMPLESSOFT>(alcGetProcAddress(nullptr, "alcRenderSamplesSOFT"));
    impl->device.reset(open_device(nullptr));
    if (!impl->device) return failure("no loopback sound device");
    const ALCint attributes[] = {
        ALC_FORMAT_CHANNELS_SOFT, ALC_STEREO_SOFT, ALC_FORMAT_TYPE_SOFT, ALC_SHORT_SOFT, ALC_FREQUENCY, rate_hz, 0};
    FF_TRY(impl->start(attributes));
    return SoundPlayer(std::move(impl));
}

SoundPlayer::SoundPlayer(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
SoundPlayer::SoundPlayer(SoundPlayer&&) noexcept = default;
SoundPlayer& SoundPlayer::operator=(SoundPlayer&&) noexcept = default;
SoundPlayer::~SoundPlayer() = default;

void SoundPlayer::update(const Camera& ear, std::span<const Emitter> emitters, std::span<const SoundEvent> events,
                         double time_s, float volume) {
    Impl& s = *impl_;
    const DMat3 axes = world_from_camera(ear);
    const Vec3 ahead(-axes[2]), up(axes[1]);
    const ALfloat facing[] = {ahead.x, ahead.y, ahead.z, up.x, up.y, up.z};
    alListenerfv(AL_ORIENTATION, facing);
    alListenerf(AL_GAIN, volume);

    // Events first: what happens once is not drowned by what goes on and on.
    for (Voice& voice : s.voices) {
        if (!voice.is_taken || voice.id != kEventId) continue;
        ALint state = AL_STOPPED;
        alGetSourcei(voice.source, AL_SOURCE_STATE, &state);
        if (state == AL_STOPPED)
            s.end(voice);
        else
            s.place(voice, voice.position, ear.position);
    }
    for (const SoundEvent& event : events) {
        if (s.is_first || !(event.at_s > s.last_s && event.at_s <= time_s)) continue;
        if (heard_gain(event.source, glm::length(event.position - ear.position)) < kLeastGain) continue;
        Voice* voice = s.free_voice();
        if (voice == nullptr) {
            const auto other =
                std::find_if(s.voices.begin(), s.voices.end(), [](const Voice& v) { return v.id != kEventId; });
            if (other == s.voices.end()) break;
            s.end(*other);
            voice = &*other;
        }
        s.begin(*voice, kEventId, event.position, event.source, false);
        s.place(*voice, event.position, ear.position);
        alSourcePlay(voice->source);
    }
    s.last_s = time_s;
    s.is_first = false;

    s.emitters.assign(emitters.begin(), emitters.end());
    for (std::size_t i = 0; i < s.sounds.sources.size(); ++i) {
        const scene::SoundSource& source = s.sounds.sources[i];
        s.emitters.push_back({.id = kFirstWorldId + i,
                              .position = source.position,
                              .source = {source.clip, source.reference_m, source.gain}});
    }
    const auto by_events = std::size_t(
        std::count_if(s.voices.begin(), s.voices.end(), [](const Voice& v) { return v.is_taken && v.id == kEventId; }));
    choose_voices(s.emitters, ear.position, kMostVoices - by_events, s.chosen);
    const auto is_chosen = [&](const Voice& voice) {
        return std::any_of(s.chosen.begin(), s.chosen.end(),
                           [&](std::uint32_t i) { return s.emitters[i].id == voice.id; });
    };
    for (Voice& voice : s.voices)
        if (voice.is_taken && voice.id != kEventId && !is_chosen(voice)) s.end(voice);
    for (const std::uint32_t i : s.chosen) {
        const Emitter& emitter = s.emitters[i];
        const auto playing = std::find_if(s.voices.begin(), s.voices.end(),
                                          [&](const Voice& v) { return v.is_taken && v.id == emitter.id; });
        if (playing != s.voices.end()) {
            alSourcef(playing->source, AL_GAIN, emitter.source.gain);
            s.place(*playing, emitter.position, ear.position);
            continue;
        }
        Voice* const voice = s.free_voice();
        s.begin(*voice, emitter.id, emitter.position, emitter.source, true);
        s.place(*voice, emitter.position, ear.position);
        alSourcePlay(voice->source);
    }
}

void SoundPlayer::silence() {
    for (Voice& voice : impl_->voices) impl_->end(voice);
    impl_->is_first = true;
}

std::uint32_t SoundPlayer::voices() const {
    return std::uint32_t(
        std::count_if(impl_->voices.begin(), impl_->voices.end(), [](const Voice& v) { return v.is_taken; }));
}

void SoundPlayer::render(std::span<std::int16_t> samples) {
    FF_CHECK(impl_->render_samples != nullptr, "only a loopback device renders");
    impl_->render_samples(impl_->device.get(), samples.data(), ALCsizei(samples.size() / 2));
}

}  // namespace ff::sound
