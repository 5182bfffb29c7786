#pragma once
// Every setting that trades accuracy for time, in one table: what it is called, which values are worth trying, and how
// it is set. The accuracy lab sweeps the table and settings that it chose are stored by these names, so a new technique
// adds a row here and nothing elsewhere.

#include <span>
#include <string>
#include <string_view>

#include "engine/core/result.h"
#include "engine/frame/settings.h"

namespace ff::frame {

/// One value that a knob may take. Choices have a name; quantities have none and are shown as their number.
struct KnobValue {
    double value = 0.0;
    std::string_view name = {};
};

/// Where a knob has an effect; setting it brings that about.
enum class KnobScope {
    all,           ///< whatever finds visibility
    hybrid,        ///< mode hybrid
    panorama,      ///< mode hybrid whose panorama serves a moving viewer
    reprojection,  ///< mode reproject
};

struct Knob {
    std::string_view name;  ///< as stored; lower case, underscores
    std::string_view unit;  ///< "" where the values are names or plain numbers
    std::string_view about;
    double default_value = 0.0;         ///< that of FrameSettings; as a value it brings about the scope, no more
    std::span<const KnobValue> values;  ///< worth trying, from the most accurate on; the default among them or beside
    /// Sets it, and whatever else it needs to take effect at all.
    void (*set)(FrameSettings& settings, double value) = nullptr;
    KnobScope scope = KnobScope::hybrid;
    bool needs_gl = false;       ///< only where there is OpenGL to draw with
    bool needs_sun = false;      ///< only where the scene's sun casts shadows
    bool needs_lamps = false;    ///< only where the scene has lamps
    bool needs_mirrors = false;  ///< only where the scene has water or what mirrors
    bool needs_air = false;      ///< only where the scene has an atmosphere or fog
    bool needs_water = false;    ///< only where the scene has open water
    bool needs_weather = false;  ///< only where rain or snow falls in the scene
    bool needs_wind = false;     ///< only where wind blows in foliage

    /// The value as people read it: its name, or its number with the unit.
    [[nodiscard]] std::string text(double value) const;
};

/// All knobs, in the order in which they are best shown.
[[nodiscard]] std::span<const Knob> knobs();

/// The knob of that name, or nullptr.
[[nodiscard]] const Knob* find_knob(std::string_view name);

/// Sets the knob of that name. Errors: no such knob; a value outside of what the knob's values span.
Status set_knob(FrameSettings& settings, std::string_view name, double value);

}  // namespace ff::frame
