// P3's Tables 1 to 3 and Figure 6 on our scenes, as Markdown: casting every pixel (ORSA), the reprojection as P3 has it
// and as the engine does, without each of its checks, and ideal ray shooting (IRSA), a lap each. Times are
// of the processor, all workers together, so that others on the machine disturb them little.
// Usage: bench_reproject [--frames N] [--threads N] PACK.ffpack:WALK ...

#include <fmt/core.h>

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <string>
#include <vector>

#include "engine/core/jobs.h"
#include "engine/core/quantile.h"
#include "engine/farfield/known_pixels.h"
#include "engine/farfield/reproject.h"
#include "engine/farfield/reproject_cast.h"
#include "engine/farfield/visibility_difference.h"
#include "engine/shading/shading_pass.h"
#include "tests/bench/cpu_watch.h"
#include "tests/bench/pack_walk.h"
#include "tests/support/tiles.h"

namespace {

using namespace ff;
using farfield::ReprojectSettings;

constexpr int kWidth = 640, kHeight = 480;
constexpr double kPixels = double(kWidth) * kHeight;

struct Options {
    std::size_t frames = SIZE_MAX;
    int threads = 0;
    std::vector<std::string> walks;
};

/// What is known of a method after the walk; times in milliseconds of all frames.
struct Method {
    std::string name;
    std::uint64_t wrong = 0;
    double reproject_ms = 0, verify_ms = 0, cast_ms = 0, shade_ms = 0;
    farfield::CastCost cost;  ///< intersections and traversal steps, where they can be counted
    farfield::ReprojectCounts causes;
    std::vector<double> frame_ms, visibility_ms;
    std::size_t reprojected_frames = 0;

    void end_frame(double reproject, double verify, double cast, double shade) {
        reproject_ms += reproject;
        verify_ms += verify;
        cast_ms += cast;
        shade_ms += shade;
        visibility_ms.push_back(reproject + verify + cast);
        frame_ms.push_back(reproject + verify + cast + shade);
    }
};

/// One way to reproject, with a history of its own.
struct Variant {
    Method method;
    ReprojectSettings settings;
    farfield::RayCaster* caster = nullptr;
    std::unique_ptr<farfield::Reprojection> reprojection;
    farfield::VisibilityBuffer visibility;
    std::vector<farfield::TileRequest> left;
    PinholeView last_view;
};

std::vector<farfield::TileRequest> whole_image() {
    return test::all_tiles(kWidth, kHeight);
}

class Bench {
  public:
    Bench(const scene::StaticScene& scene)
        : scene_(scene), orsa_(farfield::make_embree_caster(scene)), beams_(farfield::make_beam_caster(scene)) {
        const auto add = [&](const char* name, const ReprojectSettings& settings, farfield::RayCaster& caster) {
            Variant variant;
            variant.method.name = name;
            variant.settings = settings;
            variant.caster = &caster;
            variant.reprojection = std::make_unique<farfield::Reprojection>(scene);
            variant.visibility.resize(kWidth, kHeight);
            variants_.push_back(std::move(variant));
        };
        add("reproject", {}, *beams_);
        add("reproject, ORSA alone casts the rest", {.resample_block_px = 4}, *orsa_);
        add("P3's vote, single pixels resampled", {.vote = farfield::Vote::primitive, .resample_block_px = 1}, *orsa_);
        add("without frustum", {.check_view_frustum = false}, *beams_);
        add("without occlusion", {.check_occlusion = false}, *beams_);
        add("without abrupt", {.check_abrupt = false}, *beams_);
        add("without resampling", {.resample_period = 0}, *beams_);
        add("without background", {.use_background = false}, *beams_);
        add("with shifted origins", {.shift_origin = true}, *beams_);
        add("without vote", {.vote = farfield::Vote::any}, *beams_);
        truth_.resize(kWidth, kHeight);
        visibility_.resize(kWidth, kHeight);
        image_.resize(kWidth, kHeight);
    }

    /// Every method's errors, untimed.
    void compare(const std::vector<PinholeView>& views) {
        for (std::size_t f = 0; f < views.size(); ++f) {
            orsa_->cast_tiles(views[f], tiles_, truth_);
            beams_->cast_tiles(views[f], tiles_, visibility_);
            beams_method_.wrong += farfield::count_wrong_pixels(visibility_, truth_);
            visibility_ = truth_;
            farfield::cast_known_pixels(scene_, views[f], tiles_, visibility_);
            irsa_method_.wrong += farfield::count_wrong_pixels(visibility_, truth_);
            for (Variant& variant : variants_) {
                draw(views[f], f, variant);
                variant.method.wrong += farfield::count_wrong_pixels(variant.visibility, truth_);
            }
        }
        for (Variant& variant : variants_) variant.method = {variant.method.name, variant.method.wrong};
    }

    /// A lap of every method, each with the caches to itself, as in a game.
    void time(const std::vector<PinholeView>& views) {
        for (const PinholeView& view : views) {
            const bench::CpuWatch watch;
            orsa_->cast_tiles(view, tiles_, visibility_);
            const double ms = watch.milliseconds();
            orsa_method_.end_frame(0, 0, ms, shade(view, visibility_));
        }
        for (const PinholeView& view : views) {
            const bench::CpuWatch watch;
            const farfield::CastCost cost = beams_->cast_tiles(view, tiles_, visibility_);
            const double ms = watch.milliseconds();
            beams_method_.end_frame(0, 0, ms, shade(view, visibility_));
            beams_method_.cost.nodes += cost.nodes;
            beams_method_.cost.triangles += cost.triangles;
        }
        for (const PinholeView& view : views) {
            beams_->cast_tiles(view, tiles_, visibility_);
            const bench::CpuWatch watch;
            irsa_method_.cost.triangles += farfield::cast_known_pixels(scene_, view, tiles_, visibility_).rays;
            const double ms = watch.milliseconds();
            irsa_method_.end_frame(0, ms, 0, shade(view, visibility_));
        }
        for (Variant& variant : variants_)
            for (std::size_t f = 0; f < views.size(); ++f) draw(views[f], f, variant);
    }

    void print(const std::string& name, std::size_t triangles) const {
        const auto frames = double(orsa_method_.frame_ms.size());
        fmt::print("\n### {}: {} triangles, {} frames\n\n", name, triangles, orsa_method_.frame_ms.size());
        fmt::print(
            "| method | T_R, s | F_R, 1/s | visibility, ms | shading, ms | c_E, % | c_R, % | c_O, % | wrong, % |\n");
        fmt::print("|---|---|---|---|---|---|---|---|---|\n");
        const auto row = [&](const Method& m) {
            double total = 0;
            for (const double ms : m.frame_ms) total += ms;
            fmt::print("| {} | {:.2f} | {:.1f} | {:.2f} | {:.2f} |", m.name, total / 1e3, 1e3 * frames / total,
                       median_of(m.visibility_ms), m.shade_ms / frames);
            if (m.reprojected_frames == 0)
                fmt::print(" – | – | – |");
            else
                fmt::print(" {:.1f} | {:.1f} | {:.1f} |", share(m, m.causes.failed + m.causes.abrupt),
                           share(m, m.causes.verified + m.causes.background), share(m, m.causes.resampled));
            fmt::print(" {:.4f} |\n", 100.0 * double(m.wrong) / (kPixels * frames));
        };
        row(orsa_method_);
        for (const Variant& variant : variants_) row(variant.method);
        row(beams_method_);
        row(irsa_method_);
        const Method &orsa = orsa_method_, &beam = beams_method_, &irsa = irsa_method_, &ours = variants_[0].method;
        const auto ratio = [&](const Method& a, const Method& b) {
            return fmt::format("{:.2f} ({:.2f})", median_of(a.frame_ms) / median_of(b.frame_ms),
                               median_of(a.visibility_ms) / median_of(b.visibility_ms));
        };
        fmt::print(
            "\nMedians of frames (of visibility alone): ORSA/reproject {}, reproject/IRSA {}; with ORSA alone {}, {}; "
            "ORSA/beams {}, beams/IRSA {}, ORSA/IRSA {}.\n",
            ratio(orsa, ours), ratio(ours, irsa), ratio(orsa, variants_[1].method), ratio(variants_[1].method, irsa),
            ratio(orsa, beam), ratio(beam, irsa), ratio(orsa, irsa));
        fmt::print("Intersections per ray: beams {:.2f}, IRSA {:.2f}; traversal steps: beams {:.2f}.\n",
                   double(beam.cost.triangles) / (kPixels * frames), double(irsa.cost.triangles) / (kPixels * frames),
                   double(beam.cost.nodes) / (kPixels * frames));
        for (const std::size_t which : {std::size_t(0), std::size_t(1)}) {
            const Method& m = variants_[which].method;
            double total = 0;
            for (const double ms : m.frame_ms) total += ms;
            fmt::print(
                "Figure 6, {}: verified {:.1f} %, background {:.1f}, failed {:.2f}, resampled {:.1f}, abrupt {:.2f}; "
                "time: reprojection {:.1f} %, single intersections {:.1f}, casting {:.1f}, shading {:.1f}.\n",
                m.name, share(m, m.causes.verified), share(m, m.causes.background), share(m, m.causes.failed),
                share(m, m.causes.resampled), share(m, m.causes.abrupt), 100 * m.reproject_ms / total,
                100 * m.verify_ms / total, 100 * m.cast_ms / total, 100 * m.shade_ms / total);
        }
    }

  private:
    static double share(const Method& m, std::uint64_t pixels) {
        return 100.0 * double(pixels) / (kPixels * double(m.reprojected_frames));
    }

    double shade(const PinholeView& view, const farfield::VisibilityBuffer& visibility) {
        const bench::CpuWatch watch;
        shading::shade_tiles(scene_, {}, view, visibility, tiles_, {}, image_);
        return watch.milliseconds();
    }

    void draw(const PinholeView& view, std::size_t frame, Variant& v) {
        bench::CpuWatch watch;
        double reproject_ms = 0, verify_ms = 0;
        bool has_landed = false;
        if (frame > 0) {
            has_landed = v.reprojection->reproject(v.last_view, v.visibility, view, v.settings);
            reproject_ms = watch.milliseconds();
        }
        watch.restart();
        if (has_landed) {
            const farfield::ReprojectCounts counts =
                v.reprojection->verify(view, v.settings, frame, v.visibility, v.left);
            v.method.causes.verified += counts.verified;
            v.method.causes.background += counts.background;
            v.method.causes.failed += counts.failed;
            v.method.causes.resampled += counts.resampled;
            v.method.causes.abrupt += counts.abrupt;
            ++v.method.reprojected_frames;
            verify_ms = watch.milliseconds();
        } else {
            v.left = tiles_;
        }
        watch.restart();
        farfield::cast_left_over(*orsa_, *v.caster, view, v.left, few_, much_, has_landed && v.settings.shift_origin,
                                 v.visibility);
        const double cast_ms = watch.milliseconds();
        v.last_view = view;
        v.method.end_frame(reproject_ms, verify_ms, cast_ms, shade(view, v.visibility));
    }

    const scene::StaticScene& scene_;
    std::unique_ptr<farfield::RayCaster> orsa_, beams_;
    std::vector<Variant> variants_;
    Method orsa_method_{"ORSA (Embree)"}, beams_method_{"tile beams"}, irsa_method_{"IRSA"};
    farfield::VisibilityBuffer truth_, visibility_;
    shading::Image image_;
    std::vector<farfield::TileRequest> few_, much_;
    const std::vector<farfield::TileRequest> tiles_ = whole_image();
};

Options parse(int argc, char** argv) {
    Options options;
    for (int i = 1; i < argc; ++i) {
        const std::string argument = argv[i];
        if (argument == "--frames" && i + 1 < argc)
            options.frames = std::size_t(std::max(1, std::atoi(argv[++i])));
        else if (argument == "--threads" && i + 1 < argc)
            options.threads = std::atoi(argv[++i]);
        else
            options.walks.push_back(argument);
    }
    return options;
}

}  // namespace

int main(int argc, char** argv) {
    const Options options = parse(argc, argv);
    const WorkerLimit limit(options.threads);
    for (const std::string& name : options.walks) {
        const std::size_t colon = name.rfind(':');
        if (colon == std::string::npos) {
            fmt::print(stderr, "{}: expected PACK.ffpack:WALK\n", name);
            return 2;
        }
        const auto opened = bench::open_pack_walk(name.substr(0, colon), name.substr(colon + 1));
        if (!opened) {
            fmt::print(stderr, "{}\n", opened.error().message);
            return 3;
        }
        const scene::World& world = *opened->world;
        Bench bench(world.scene());
        const std::size_t frames = std::min(options.frames, opened->walk->frames.size());
        std::vector<PinholeView> views;
        for (std::size_t f = 0; f < frames; ++f) views.push_back(make_view(opened->walk->camera(f), kWidth, kHeight));
        bench.compare(views);
        bench.time(views);
        bench.print(fmt::format("{}, `{}`", world.info().name, opened->walk->name), world.statistics().triangles);
    }
}
