// The GLSL model repeats the constants of the C++ one; this holds them together.

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <span>
#include <string>

#include "engine/core/write_file.h"
#include "engine/shading/shading_model.h"

namespace ff::test {
namespace {

std::string shader_text() {
    auto text = read_text_file(std::filesystem::path(FF_SOURCE_DIR) / "engine/shaders/shading.glsl");
    return text ? *text : std::string();
}

/// Value of `const float NAME = VALUE;`, NaN where it is missing.
float constant_named(const std::string& text, const std::string& name) {
    const std::string start = "const float " + name + " = ";
    const std::size_t at = text.find(start);
    return at == std::string::npos ? std::nanf("") : std::strtof(text.c_str() + at + start.size(), nullptr);
}

TEST(shading_glsl, has_the_constants_of_the_fast_pass) {
    const std::string text = shader_text();
    ASSERT_FALSE(text.empty());
    EXPECT_EQ(constant_named(text, "kSoftClipStart"), shading::kSoftClipStart);
    EXPECT_EQ(constant_named(text, "kFilmColor"), shading::kFilmColor);
    EXPECT_EQ(constant_named(text, "kHazeRate"), shading::kHazeRate);
    EXPECT_EQ(constant_named(text, "kSunGlowWide"), shading::kSunGlowWide);
    EXPECT_EQ(constant_named(text, "kSunGlowNarrow"), shading::kSunGlowNarrow);
    EXPECT_EQ(constant_named(text, "kSunDisc"), shading::kSunDisc);
    EXPECT_EQ(constant_named(text, "kSunDiscEdge"), shading::kSunDiscEdge);
    EXPECT_EQ(constant_named(text, "kSunDiscFull"), shading::kSunDiscFull);
    EXPECT_EQ(constant_named(text, "kHazeSquare"), shading::kHazeSquare);
    EXPECT_EQ(constant_named(text, "kHazeTwice"), shading::kHazeTwice);
    EXPECT_EQ(constant_named(text, "kRayleighHeightM"), shading::kRayleighHeightM);
    EXPECT_EQ(constant_named(text, "kMieHeightM"), shading::kMieHeightM);
    EXPECT_EQ(constant_named(text, "kMaxAirHeights"), shading::kMaxAirHeights);
    EXPECT_NE(text.find("const int kSkyRows = " + std::to_string(scene::SkyTable::kRows) + ";"), std::string::npos);
    EXPECT_NE(text.find("sky_rows[" + std::to_string(4 * scene::SkyTable::kRows) + "]"), std::string::npos);
    EXPECT_EQ(constant_named(text, "kDielectric"), shading::kDielectric);
    EXPECT_EQ(constant_named(text, "kMinRoughness"), shading::kMinRoughness);
}

/// The literals of a GLSL function's polynomial, in order of appearance.
void expect_literals(const std::string& text, const std::string& function, std::span<const float> expected) {
    std::size_t at = text.find("vec3 " + function + "(");
    ASSERT_NE(at, std::string::npos);
    for (const float value : expected) {
        bool found = false;
        for (const std::size_t end = text.find("\n}", at); at < end && !found; ++at) {
            const bool starts = text[at] == '-' || (text[at] >= '0' && text[at] <= '9');
            found = starts && text.find('.', at) < at + 3 && std::strtof(text.c_str() + at, nullptr) == value;
        }
        EXPECT_TRUE(found) << function << " has no " << value;
    }
}

TEST(shading_glsl, has_the_transfer_functions_of_the_fast_pass) {
    const std::string text = shader_text();
    expect_literals(text, "decode_srgb", shading::kDecode);
    expect_literals(text, "encode_srgb", shading::kEncode);
    expect_literals(text, "encode_film", shading::kFilm);
    expect_literals(text, "encode_film", shading::kLuminance);
}

}  // namespace
}  // namespace ff::test
