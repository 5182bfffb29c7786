#pragma once
// A world opened for drawing, as the drawing subcommands share it.

#include <array>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "engine/core/result.h"
#include "engine/frame/renderer.h"
#include "engine/scene/walk.h"
#include "engine/scene/world.h"
#include "tools/ff/commands.h"
#include "tools/ff/moving_models.h"

namespace ff::tool {

/// Where the tool keeps what it can make again.
std::filesystem::path cache_directory();

/// Where the pack lies that is drawn: the one that is given, or that which a source is cooked into.
[[nodiscard]] std::filesystem::path pack_path(const std::string& pack_or_source);

/// A pack, and where it was cooked from a source just now, the files that it was cooked from.
struct CookedSource {
    std::filesystem::path pack;
    std::vector<std::string> inputs;
};
Result<CookedSource> cooked_source(const std::string& pack_or_source);
/// The pack itself, or for a source (scene.toml, .gltf, .glb) the pack that it is cooked into in the user's cache.
Result<std::filesystem::path> pack_of(const std::string& pack_or_source);

/// The frame settings that the options ask for, those chosen by an allowed error included; says what it chose and why.
/// @param walk  that will be walked. Errors: no accuracy table of this pack.
Result<frame::FrameSettings> chosen_settings(const ViewOptions& options, const scene::World& world,
                                             const scene::Walk& walk);

/// The unit direction to a sun that stands there, as `--sun` says it.
[[nodiscard]] Vec3 sun_direction(const std::array<double, 2>& azimuth_and_elevation_deg);

/// Opens a pack; a source (scene.toml, .gltf, .glb) is cooked into the user's cache first.
Result<std::unique_ptr<scene::World>> open_world(const std::string& pack_or_source);

/// A walk that the pack has, or a .walk.json file. Errors: neither; the message lists the names that there are.
Result<scene::Walk> find_walk(const scene::World& world, const std::string& name_or_file);

/// OpenGL without a window.
class HeadlessGl;

/// A world, a walk, and what draws them headless.
class Session {
  public:
    /// Opens OpenGL too where a mode or a fixed near distance needs it, or where it is hardware: there the hybrid's
    /// controller may choose a near field. A software rasteriser is never cheaper than the caster
    ///, so then the hybrid does without it.
    static Result<std::unique_ptr<Session>> open(const ViewOptions& options, std::span<const frame::Mode> modes);
    ~Session();

    [[nodiscard]] const scene::World& world() const { return *world_; }
    [[nodiscard]] const scene::Walk& walk() const { return walk_; }
    /// What the options ask for, see chosen_settings.
    [[nodiscard]] const frame::FrameSettings& settings() const { return settings_; }
    /// The time of a frame of the walk: its number over the walk's rate.
    [[nodiscard]] double time_s(std::size_t frame) const { return double(frame) / walk_.rate_hz; }
    /// What the options ask for at the time of a frame of the walk.
    [[nodiscard]] frame::FrameSettings settings_at(std::size_t frame);
    /// The same for settings of whatever kind: its time, where the sun stands then, and what has been simulated.
    void set_time(std::size_t frame, frame::FrameSettings& settings);
    /// What moves, at the time of a frame of the walk. Good until the next call.
    /// @param without  effects whose things are not shown
    [[nodiscard]] std::span<const scene::Instance> dynamic(std::size_t frame, const ImageSize& size,
                                                           effects::EffectSet without = 0);
    [[nodiscard]] frame::Casters& casters() { return *casters_; }
    [[nodiscard]] nearfield::NearRenderer* near_renderer();
    [[nodiscard]] const std::string& gl_renderer_name() const { return gl_name_; }
    [[nodiscard]] bool has_software_gl() const { return gl_is_software_; }
    /// A renderer with a history of its own.
    [[nodiscard]] std::unique_ptr<frame::Renderer> make_renderer(const ImageSize& size);

  private:
    Session();
    void simulate(std::size_t frame);

    std::unique_ptr<scene::World> world_;
    scene::Walk walk_;
    frame::FrameSettings settings_;
    std::optional<std::array<double, 2>> sun_deg_, sun_to_deg_;
    std::unique_ptr<MovingModels> moving_;
    std::size_t simulated_frame_ = 0;
    std::string gl_name_ = "none";
    bool gl_is_software_ = false;
    std::unique_ptr<HeadlessGl> gl_;
    std::unique_ptr<frame::Casters> casters_;
};

}  // namespace ff::tool
