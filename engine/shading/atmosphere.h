#pragma once
// Sunlight, sky and aerial perspective of a clear or hazy day, from where the sun stands; clouds where rain or snow
// falls.

#include "engine/scene/environment.h"
#include "engine/scene/sky_table.h"

namespace ff::shading {

/// Height in which the air thins to 1/e, metres.
inline constexpr float kRayleighHeightM = 8000.0f;
inline constexpr float kMieHeightM = 1200.0f;
/// How much haze scatters ahead (Henyey and Greenstein's g).
inline constexpr float kMieG = 0.76f;

/// Lights an environment that has an atmosphere by its sun: fills the table, and from it sunlight, sky gradient and
/// light from below; points the environment at the table. Takes about three quarters of a millisecond.
///
/// The air is that of a sphere with exponential Rayleigh and Mie layers and ozone; light is scattered once on its way
/// from the sun to the eye, with its phase functions, or more often (multiple_scattering.h), evenly. Clouds close the
/// sky where the weather has rain or snow, and let no sunlight through. The picture is exposed as the eye adapts: by
/// illuminance to the power -0.8, so that night has a fourteenth of the day's brightness and dusk lies between. Below
/// the horizon the sun gives none; moon and stars always give a little. Sources: Nishita et al., "Display of The Earth
/// Taking into Account Atmospheric Scattering", SIGGRAPH 1993; constants of Bruneton, Neyret, "Precomputed Atmospheric
/// Scattering", EGSR 2008, and of Hillaire, "A Scalable and Production Ready Sky and Atmosphere Rendering Technique",
/// EGSR 2020. Ours differs: in a plane through the zenith and the sun both ways are integrated, and the sky between
/// them is taken to change evenly with the part of the direction that points towards the sun. What is left is a table
/// over the height alone, with the phase functions exact in every pixel.
/// @param environment  to_sun unit; atmosphere.turbidity in [1, 10]
void light_atmosphere(scene::Environment& environment, scene::SkyTable& table);

}  // namespace ff::shading
