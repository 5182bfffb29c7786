#include "tools/accuracy/report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <set>

#include "engine/core/write_file.h"
#include "tools/accuracy/page_assets.h"
#include "tools/picture/picture_file.h"

namespace ff::accuracy {
namespace {

using nlohmann::json;

json settings_of(const Point& point) {
    json settings = json::object();
    for (const auto& [name, value] : point.settings) settings[name] = value;
    return settings;
}

/// The settings as people read them; empty where no knob is turned.
std::string text_of(const KnobSettings& settings) {
    std::string text;
    for (const auto& [name, value] : settings) {
        text += fmt::format("{}{} {}", text.empty() ? "" : ", ", name, frame::find_knob(name)->text(value));
    }
    return text;
}

json json_of(const Point& point) {
    const Errors& e = point.errors;
    return {{"frame_ms_median", point.times.median_ms},
            {"frame_ms_p99", point.times.p99_ms},
            {"exact_frame_ms_median", point.times.exact_median_ms},
            {"psnr_db", e.psnr_db},
            {"psnr_exact_db_min", e.psnr_exact_db_min},
            {"ssim", e.ssim},
            {"flip_mean", e.flip_mean},
            {"wrong_pixels_pct", e.wrong_pixels_pct},
            {"displacement_px", e.displacement_px},
            {"flicker", e.flicker}};
}

json json_with_settings(const Point& point) {
    json result = json_of(point);
    result["settings"] = settings_of(point);
    result["text"] = text_of(point.settings);
    return result;
}

json make_report(const Bench& bench, const Sweep& sweep, const ReportInfo& info) {
    const scene::World& world = bench.scene.world;
    json report{{"scene",
                 {{"name", world.info().name},
                  {"walk", bench.scene.walk.name},
                  {"triangles", world.statistics().triangles},
                  {"instanced_triangles", world.statistics().instanced_triangles},
                  {"cells", world.scene().cells.size()},
                  {"pack_hash", fmt::format("{:016x}", world.statistics().pack_hash)}}},
                {"machine", {{"cpu", info.cpu}, {"threads", info.threads}, {"gl_renderer", info.gl_renderer}}},
                {"reference",
                 {{"samples_per_pixel", kSamplesPerSide * kSamplesPerSide},
                  {"width", bench.scene.width},
                  {"height", bench.scene.height},
                  {"frames", sweep.schedule_frames},
                  {"counted_frames", sweep.counted_frames},
                  {"laps", bench.laps}}},
                {"exact", json_with_settings(sweep.exact)},
                {"knobs", json::array()},
                {"pairs", json::array()},
                {"pareto", json::array()}};
    for (const KnobCurve& curve : sweep.curves) {
        json points = json::array();
        for (const Point& point : curve.points) {
            json entry = json_of(point);
            entry["value"] = point.settings.front().second;
            entry["text"] = curve.knob->text(point.settings.front().second);
            points.push_back(std::move(entry));
        }
        report["knobs"].push_back({{"name", curve.knob->name},
                                   {"unit", curve.knob->unit},
                                   {"about", curve.knob->about},
                                   {"default", curve.knob->default_value},
                                   {"says", curve.says},
                                   {"points", std::move(points)}});
    }
    for (const Point& point : sweep.pairs) report["pairs"].push_back(json_with_settings(point));
    for (const Point& point : sweep.pareto) report["pareto"].push_back(json_with_settings(point));
    return report;
}

/// The map from black over red and yellow to white, as heat.
shading::Image picture_of(const Plane& flip_map) {
    shading::Image image;
    image.resize(flip_map.width, flip_map.height);
    for (int y = 0; y < image.height; ++y)
        for (int x = 0; x < image.width; ++x) {
            const float heat = 3.0f * flip_map.row(y)[x];
            std::uint32_t pixel = 0xFF000000u;
            for (int c = 0; c < 3; ++c)
                pixel |= std::uint32_t(std::lround(255.0f * std::clamp(heat - float(c), 0.0f, 1.0f))) << 8 * c;
            image.pixels[std::size_t(y) * std::size_t(image.stride) + std::size_t(x)] = pixel;
        }
    return image;
}

/// Pictures in a folder and in the page, each once.
class Pictures {
  public:
    explicit Pictures(const std::filesystem::path& folder) : folder_(folder) {}

    Status add(const std::string& name, const shading::Image& image) {
        if (images_.contains(name)) return {};
        const auto path = folder_ / (name + ".jpg");
        FF_TRY(tool::write_image(path, image));
        FF_ASSIGN(const std::string bytes, read_text_file(path));
        images_[name] = page::jpeg_url(bytes);
        return {};
    }
    [[nodiscard]] const json& images() const { return images_; }

  private:
    std::filesystem::path folder_;
    json images_ = json::object();
};

/// Points whose worst frames are shown: each knob's least accurate one, and those on the front.
std::vector<const Point*> shown_points(const Sweep& sweep) {
    constexpr double kNoticeable = 1e-4;  // FLIP; a picture of nothing wrong shows nothing
    std::vector<const Point*> shown{&sweep.exact};
    std::set<std::string> known{text_of(sweep.exact.settings)};
    const auto show = [&](const Point& point) {
        if (known.insert(text_of(point.settings)).second) shown.push_back(&point);
    };
    for (const Point& point : sweep.pareto) show(point);
    for (const KnobCurve& curve : sweep.curves) {
        const auto by_flip = [](const Point& a, const Point& b) { return a.errors.flip_mean < b.errors.flip_mean; };
        const Point& worst = *std::max_element(curve.points.begin(), curve.points.end(), by_flip);
        if (worst.errors.flip_mean > sweep.exact.errors.flip_mean + kNoticeable) show(worst);
    }
    return shown;
}

/// The worst frames of the points, for the page's third part.
Result<json> make_cases(const Bench& bench, const Sweep& sweep, Pictures& pictures) {
    json cases = json::array();
    for (const Point* point : shown_points(sweep)) {
        const WorstFrame& worst = point->worst;
        const std::size_t frame = bench.frames[worst.index].walk_frame;
        const std::string text = text_of(point->settings);
        const std::string name = fmt::format("{:02}", cases.size());
        const std::string reference = fmt::format("reference{:05}", frame);
        FF_TRY(pictures.add(reference, bench.reference[worst.index].image));
        FF_TRY(pictures.add(name, worst.image));
        FF_TRY(pictures.add(name + "-flip", picture_of(worst.flip_map)));
        cases.push_back({{"title", text.empty() ? "exact" : text},
                         {"walk_frame", frame},
                         {"flip", worst.flip},
                         {"reference", reference},
                         {"test", name},
                         {"map", name + "-flip"}});
    }
    return cases;
}

}  // namespace

std::string report_json(const Bench& bench, const Sweep& sweep, const ReportInfo& info) {
    return make_report(bench, sweep, info).dump(1);
}

Status write_report(const Bench& bench, const Sweep& sweep, const ReportInfo& info,
                    const std::filesystem::path& folder) {
    const auto picture_folder = folder / "pictures";
    std::error_code error;
    std::filesystem::create_directories(picture_folder, error);
    if (error) return failure(fmt::format("{}: cannot create: {}", picture_folder.string(), error.message()));
    json report = make_report(bench, sweep, info);
    FF_TRY(write_file_whole(folder / "accuracy.json", report.dump(1)));
    Pictures pictures(picture_folder);
    FF_ASSIGN(report["cases"], make_cases(bench, sweep, pictures));
    report["images"] = pictures.images();
    return write_file_whole(folder / "accuracy.html", page::fill_page(kPage, report.dump()));
}

}  // namespace ff::accuracy
