#include "tools/ff/session.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <optional>

#include "engine/core/hash.h"
#include "engine/core/log.h"
#include "engine/gl/device.h"
#include "engine/nearfield/near_renderer.h"
#include "engine/platform/headless.h"
#include "engine/scene/load_world.h"
#include "tools/accuracy/choose.h"
#include "tools/cook/cook.h"

namespace ff::tool {

std::filesystem::path cache_directory() {
    if (const char* cache = std::getenv("XDG_CACHE_HOME"); cache != nullptr && *cache != '\0')
        return std::filesystem::path(cache) / "farfield";
    if (const char* home = std::getenv("HOME"); home != nullptr && *home != '\0')
        return std::filesystem::path(home) / ".cache" / "farfield";
    return std::filesystem::temp_directory_path() / "farfield";
}

namespace {

bool is_source(const std::filesystem::path& path) {
    const std::string ending = path.extension().string();
    return ending == ".toml" || ending == ".gltf" || ending == ".glb";
}

/// Where a source's pack lies in the cache: named after the source and its place.
std::filesystem::path cached_pack_path(const std::filesystem::path& source) {
    const std::string place = std::filesystem::absolute(source).lexically_normal().string();
    const auto hash = hash_bytes(std::as_bytes(std::span(place.data(), place.size())));
    return cache_directory() / "packs" / fmt::format("{}-{:016x}.ffpack", source.stem().string(), hash);
}

}  // namespace

std::filesystem::path pack_path(const std::string& pack_or_source) {
    return is_source(pack_or_source) ? cached_pack_path(pack_or_source) : std::filesystem::path(pack_or_source);
}

Result<std::filesystem::path> pack_of(const std::string& pack_or_source) {
    FF_ASSIGN(const CookedSource cooked, cooked_source(pack_or_source));
    return cooked.pack;
}

Result<CookedSource> cooked_source(const std::string& pack_or_source) {
    const std::filesystem::path path(pack_or_source);
    if (!std::filesystem::exists(path)) return bad_input(fmt::format("{}: there is no such file", pack_or_source));
    if (!is_source(path)) return CookedSource{path, {}};

    const std::filesystem::path pack = pack_path(pack_or_source);
    std::error_code error;
    std::filesystem::create_directories(pack.parent_path(), error);
    if (error) return failure(fmt::format("{}: cannot create: {}", pack.parent_path().string(), error.message()));
    log_info("{} is a source: cooking it into the cache", pack_or_source);
    FF_ASSIGN(const cook::CookReport report, cook::cook(path, pack, {}));
    log_info("{}", report.to_text());
    return CookedSource{pack, report.inputs};
}

Result<frame::FrameSettings> chosen_settings(const ViewOptions& options, const scene::World& world,
                                             const scene::Walk& walk) {
    frame::FrameSettings settings = options.frame;
    if (!options.max_error_px && !options.min_psnr_db) return settings;
    if (settings.mode != frame::Mode::hybrid)
        return usage_error(
            "--max-error-px and --min-psnr choose settings of mode hybrid: no other --mode goes with them");
    accuracy::Limits limits;
    if (options.max_error_px) limits.max_displacement_px = *options.max_error_px;
    if (options.min_psnr_db) limits.min_psnr_db = *options.min_psnr_db;
    FF_ASSIGN(const std::string why, accuracy::choose_settings(pack_path(options.pack), world.statistics().pack_hash,
                                                               walk.name, limits, settings));
    log_info("settings: {}", why);
    return settings;
}

Vec3 sun_direction(const std::array<double, 2>& azimuth_and_elevation_deg) {
    const double azimuth = radians_of(azimuth_and_elevation_deg[0]);
    const double elevation = radians_of(azimuth_and_elevation_deg[1]);
    return Vec3(std::cos(elevation) * std::sin(azimuth), std::sin(elevation), -std::cos(elevation) * std::cos(azimuth));
}

Result<std::unique_ptr<scene::World>> open_world(const std::string& pack_or_source) {
    FF_ASSIGN(const std::filesystem::path pack, pack_of(pack_or_source));
    return scene::load_world(pack);
}

Result<scene::Walk> find_walk(const scene::World& world, const std::string& name_or_file) {
    if (const scene::Walk* walk = world.find_walk(name_or_file)) return *walk;
    if (std::filesystem::exists(name_or_file)) return scene::load_walk(name_or_file);
    std::string names;
    for (const scene::Walk& walk : world.info().walks) names += (names.empty() ? "" : ", ") + walk.name;
    return bad_input(
        fmt::format("--walk {}: neither a file nor a walk of this pack, which has {}", name_or_file, names));
}

class HeadlessGl {
  public:
    explicit HeadlessGl(platform::HeadlessContext context) : context_(std::move(context)) {}
    /// Uploads the scene.
    Status load(const scene::StaticScene& scene) {
        FF_ASSIGN(nearfield::NearRenderer renderer, nearfield::NearRenderer::make(scene));
        renderer_.emplace(std::move(renderer));
        return {};
    }
    nearfield::NearRenderer* renderer() { return renderer_ ? &*renderer_ : nullptr; }

  private:
    platform::HeadlessContext context_;
    std::optional<nearfield::NearRenderer> renderer_;  // after the context: destroyed while that is current
};

Session::Session() = default;
Session::~Session() = default;

Result<std::unique_ptr<Session>> Session::open(const ViewOptions& options, std::span<const frame::Mode> modes) {
    auto session = std::unique_ptr<Session>(new Session);
    FF_ASSIGN(session->world_, open_world(options.pack));
    FF_ASSIGN(session->walk_, find_walk(*session->world_, options.walk));
    FF_ASSIGN(session->settings_, chosen_settings(options, *session->world_, session->walk_));
    session->settings_.hearing.is_called_for = !session->world_->info().sounds.clips.empty();
    session->sun_deg_ = options.sun_deg;
    session->sun_to_deg_ = options.sun_to_deg;
    session->casters_ = std::make_unique<frame::Casters>(session->world_->scene());
    FF_ASSIGN(session->moving_,
              MovingModels::make(*session->world_, options.scenery, session->settings_.without_effects));
    session->settings_.to_sun = session->settings_at(0).to_sun;

    bool needs_gl = session->settings_.fixed_near_m.value_or(0.0) > 0.0;
    for (const frame::Mode mode : modes) needs_gl |= mode == frame::Mode::raster || mode == frame::Mode::near;
    auto context = platform::HeadlessContext::open();
    if (!context) {
        if (needs_gl) return context.error();
        return session;
    }
    session->gl_ = std::make_unique<HeadlessGl>(std::move(*context));
    FF_ASSIGN(const gl::DeviceInfo device, gl::query_device());
    session->gl_name_ = device.renderer;
    session->gl_is_software_ = device.is_software;
    if (needs_gl || !device.is_software) {
        FF_TRY(session->gl_->load(session->world_->scene()));
        if (!options.use_occlusion) session->near_renderer()->set_occlusion({.enabled = false});
    }
    return session;
}

/// What is simulated depends on where it is looked at from: the frames that lie between are gone through.
void Session::simulate(std::size_t frame) {
    if (frame < simulated_frame_) simulated_frame_ = 0;
    for (; simulated_frame_ < frame; ++simulated_frame_)
        moving_->advance(time_s(simulated_frame_), walk_.camera(simulated_frame_));
    moving_->advance(time_s(frame), walk_.camera(frame));
}

std::span<const scene::Instance> Session::dynamic(std::size_t frame, const ImageSize& size,
                                                  effects::EffectSet without) {
    simulate(frame);
    return moving_->at(time_s(frame), walk_.camera(frame), size, without);
}

frame::FrameSettings Session::settings_at(std::size_t frame) {
    frame::FrameSettings settings = settings_;
    set_time(frame, settings);
    return settings;
}

void Session::set_time(std::size_t frame, frame::FrameSettings& settings) {
    settings.time_s = time_s(frame);
    simulate(frame);
    settings.simulations = moving_->work();
    if (sun_deg_) {
        const std::array<double, 2>& to = sun_to_deg_.value_or(*sun_deg_);
        const double part = double(frame) / double(std::max<std::size_t>(walk_.frames.size() - 1, 1));
        settings.to_sun =
            sun_direction({std::lerp((*sun_deg_)[0], to[0], part), std::lerp((*sun_deg_)[1], to[1], part)});
    }
}

nearfield::NearRenderer* Session::near_renderer() {
    return gl_ ? gl_->renderer() : nullptr;
}

std::unique_ptr<frame::Renderer> Session::make_renderer(const ImageSize& size) {
    return std::make_unique<frame::Renderer>(world_->scene(), *casters_, near_renderer(), size.width, size.height);
}

}  // namespace ff::tool
