#pragma once
// How much of the sun the last frame's pixels saw, for those who see the same points again: P3's reuse of what is
// already known, of light instead of primitives. What a pixel sees is exact here (the beams have established it), and
// the sun's visibility of a point that stands still does not change while the sun and all around it stand still.
//
// A pixel keeps the light of the four pixels of the last frame round its point if all of them saw that surface, and
// they and the twelve round them agree. Where they do not, the border of a shadow is near, or light that is finer than
// pixels, and a ray decides: what can be missed is smaller than four pixels and new, for at most `refresh_frames`
// frames.
//
// Based on: Havran, Bittner, Seidel, "Exploiting Temporal Coherence in Ray Casted Walkthroughs", 2003 (P3), sections
// 4.3 (regular resampling) and 7.4 (shadow rays).

#include <cstdint>
#include <span>
#include <vector>

#include "engine/core/zero_pages.h"
#include "engine/farfield/moving_shadow.h"
#include "engine/farfield/visibility_buffer.h"
#include "engine/math/camera.h"
#include "engine/math/types.h"

namespace ff::farfield {

struct SunHistoryInput {
    const PinholeView& view;
    const VisibilityBuffer& visibility;
    std::span<const TileRequest> tiles;  ///< pixels that want to know; resolved or sky
    std::uint32_t static_instances = 0;  ///< instances from this id on move: their pixels are never kept
    std::span<const MovingSphere> moving;
    Vec3 to_sun{0.0f, 1.0f, 0.0f};  ///< unit; another one than the last forgets everything
    /// Tiles are looked at anew, all of their pixels at once, in one of so many frames. [0, 255]; 0: never
    int refresh_frames = 32;
};

class SunHistory {
  public:
    /// Answers what the last frame knows, and keeps it for the next one.
    /// @param lit   [stride * rows] as VisibilityBuffer::index; 255 or 0 where answered, else left
    /// @param left  the pixels that are to be cast; sky is among neither
    /// @return pixels answered
    std::uint64_t reuse(const SunHistoryInput& input, std::uint8_t* lit, std::vector<TileRequest>& left);

    /// Keeps what was cast for the pixels that reuse() left.
    void commit(const SunHistoryInput& input, std::span<const TileRequest> cast, const std::uint8_t* lit);

    /// Frames since a ray decided the pixel's light, at most 255; -1: nothing is kept of it. Of the last frame.
    [[nodiscard]] int age(int x, int y) const;

    /// Whether there is a last frame to ask.
    [[nodiscard]] bool knows() const { return last_.width > 0; }

    /// Forgets everything, as where the world has changed; what follows is as if this were new.
    void clear() {
        last_.width = 0;
        last_moving_.clear();
        frame_ = 0;
    }

  private:
    /// One pixel a word, row-major: float32 depth without its 12 lowest bits, then kSettledBit and kLitBit, then
    /// the age. 0: nothing.
    struct Records {
        int width = 0, height = 0, stride = 0;
        ZeroPageVector<std::uint32_t> words;
        PinholeView view;
    };

    void begin_frame(const SunHistoryInput& input);
    /// Notes which pixels of the frame agree with those round them.
    void settle();

    Records last_, current_;
    Vec3 to_sun_{0.0f};
    std::vector<MovingSphere> last_moving_, moving_;  ///< of the last frame; of the last frame and this one
    MovingShadows shadows_;                           ///< scratch: of `moving_`
    std::uint64_t frame_ = 0;
    std::vector<TileRequest> undecided_;  ///< scratch: one for each tile of the input
};

}  // namespace ff::farfield
