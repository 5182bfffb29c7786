#pragma once
// The tool's subcommands, each a function from its options to a Status; the command line is read in command_line.cpp.

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "engine/core/result.h"
#include "engine/frame/settings.h"
#include "engine/host/play_alone.h"
#include "engine/scenery/scenery.h"

namespace ff::tool {

/// Reads the command line, runs the subcommand, prints its error. @return the process's exit code (formats.md).
int run(int argc, const char* const* argv);

struct ImageSize {
    int width = 640, height = 480;
};

/// What the drawing subcommands share.
struct ViewOptions {
    std::string pack;             ///< a pack, or a source that is cooked into the cache first
    std::string walk = "street";  ///< a walk of the pack, or a .walk.json file
    ImageSize size;
    frame::FrameSettings frame;
    bool use_occlusion = true;  ///< the hybrid's near field leaves out what is hidden
    int threads = 0;            ///< 0: all
    scenery::ScenerySettings scenery;
    /// Azimuth and elevation of the sun in degrees: instead of the scene's, and where it has moved by the walk's end.
    std::optional<std::array<double, 2>> sun_deg, sun_to_deg;
    /// Errors that may be made: the fastest settings of the pack's accuracy table that keep them are taken.
    std::optional<double> max_error_px, min_psnr_db;
};

struct CookOptions {
    std::filesystem::path source, output;
    int scale = 1;
    int jobs = 0;
    bool json = false;
    std::filesystem::path cache_dir;  ///< empty: the user's cache
};
Status run_cook(const CookOptions& options);

struct InfoOptions {
    std::string pack;
    bool json = false;
};
Status run_info(const InfoOptions& options);

struct RenderOptions {
    ViewOptions view;
    int frame = 0;
    std::string debug_view;  ///< empty: the picture
    std::filesystem::path output;
};
Status run_render(const RenderOptions& options);

enum class WalkTarget { automatic, window, headless };
struct WalkOptions {
    ViewOptions view;
    std::filesystem::path out = "out";
    bool video = false;
    WalkTarget target = WalkTarget::automatic;
    int every = 0;                ///< PNG of every n-th frame; 0: eight over the walk
    std::filesystem::path trace;  ///< empty: none
};
Status run_walk(const WalkOptions& options);

struct BenchOptions {
    ViewOptions view;
    std::vector<std::string> modes;
    int laps = 3;
    int max_frames = 0;           ///< 0: the whole walk
    bool each_frame = false;      ///< report every frame, and pictures of the slowest, for ff report
    std::filesystem::path trace;  ///< of the last lap; empty: none
};
Status run_bench(const BenchOptions& options);

struct BudgetOptions {
    ViewOptions view;
    std::filesystem::path budget;  ///< to hold; empty: none
    std::filesystem::path write;   ///< to make; empty: none
    double margin_pct = 5.0;       ///< of what is made
    int laps = 6, max_laps = 40;   ///< at least; at most, while a limit is missed
    int max_frames = 0;            ///< 0: the whole walk
    std::filesystem::path junit, trace;
    std::filesystem::path keep;  ///< folder for what a miss leaves; empty: budget-miss, beside junit where there is one
    bool json = false;
};
/// Errors: bad input; limit where the budget is missed.
Status run_budget(const BudgetOptions& options);

struct CompareOptions {
    std::filesystem::path recording;
    std::vector<std::string> packs;      ///< two, or sources
    std::optional<std::uint64_t> until;  ///< ticks
    int laps = 1;
    std::filesystem::path out = "compare";  ///< folder of pictures
    ImageSize size;
    double budget_ms = 0.0;
    int threads = 0;
    bool json = false;
};
Status run_compare(const CompareOptions& options);

struct ReportOptions {
    std::vector<std::filesystem::path> inputs;  ///< JSON of bench, budget, replay or compare
    std::filesystem::path output;
};
Status run_report(const ReportOptions& options);

struct StatsOptions {
    ViewOptions view;
    int max_frames = 0;    ///< 0: the whole walk
    int compare_laps = 0;  ///< laps in which each effect's frames are drawn with and without it; 0: not compared
    std::filesystem::path pictures;  ///< folder for pictures with and without each effect; empty: none
    std::filesystem::path table;     ///< folder for a page of all effects with their pictures; empty: none
    bool json = false;
};
Status run_stats(const StatsOptions& options);

struct HardcasesOptions {
    std::string name;             ///< of a case, or of a group of them: what stands before the dot; empty: all
    std::uint64_t instances = 0;  ///< of each case; 0: those of a full run
    std::uint32_t seed = 1;
    bool json = false;
};
/// Fails where a case exceeds its stated bound.
Status run_hardcases(const HardcasesOptions& options);

struct AccuracyOptions {
    ViewOptions view;
    std::filesystem::path out = "accuracy";
    bool quick = false;
};
Status run_accuracy(const AccuracyOptions& options);

struct PlayOptions {
    std::string pack;              ///< or a source
    std::filesystem::path folder;  ///< of settings, saves and recordings; empty: the player's own
    std::optional<double> budget_ms;
    std::uint64_t seed = 1;
    bool skip_title = false, record = true;
    std::optional<host::AutoPlayerKind> player;  ///< headless, as fast as it goes
    double minutes = 20.0;                       ///< of game time, at most, for an auto player
    std::filesystem::path recording;             ///< that it writes; empty: into the folder
    std::filesystem::path shaders;               ///< folder of GLSL files instead of the built-in ones; watched
};
/// The sample game.
Status run_play(const PlayOptions& options);

struct ReplayOptions {
    std::filesystem::path recording;
    std::string pack;  ///< empty: the one that it was recorded in
    std::optional<std::uint64_t> until;
    bool verify = false, bench = false, json = false;
    std::filesystem::path video, picture;  ///< of all frames, of the last; empty: none
    std::filesystem::path trace;           ///< of the frames that --bench draws; empty: none
    bool each_frame = false;               ///< report every frame that --bench draws, for ff report
    ImageSize size;
    double budget_ms = 0.0;
    int threads = 0;
};
/// Errors: bad input; limit where --verify finds a difference.
Status run_replay(const ReplayOptions& options);

struct NewOptions {
    std::filesystem::path folder;  ///< to make
    std::string name;              ///< of program and package; empty: after the folder
};
/// Errors: the folder holds something; a name that no package can have.
Status run_new(const NewOptions& options);

struct PackageOptions {
    std::filesystem::path game, output;
    int jobs = 0;
};
/// Errors: no game there; what CMake, the compiler or the packer refuses (they say why).
Status run_package(const PackageOptions& options);

}  // namespace ff::tool
