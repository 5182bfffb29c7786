#pragma once
// Draws static cells and dynamic objects through OpenGL: as the near field of a hybrid frame (ids and depths into the
// visibility buffer), or as a whole shaded picture.

#include <cstdint>
#include <memory>

#include "engine/core/result.h"
#include "engine/farfield/visibility_buffer.h"
#include "engine/math/camera.h"
#include "engine/nearfield/draw_list.h"
#include "engine/nearfield/occlusion_split.h"
#include "engine/scene/static_scene.h"
#include "engine/shading/shading_pass.h"

namespace ff::nearfield {

/// Work of one render call, exact and repeatable.
struct NearStats {
    std::uint64_t triangles = 0;         ///< sent to OpenGL, instances counted each time
    std::uint64_t draws = 0;             ///< commands of the multi-draws, and single draws
    std::uint64_t calls = 0;             ///< draw calls made
    std::uint64_t hidden_instances = 0;  ///< of render_ids: not sent, as nearer things cover them
    std::uint64_t hidden_triangles = 0;  ///< theirs
};

/// Threads: all calls on the thread whose OpenGL context was current when it was made.
class NearRenderer {
  public:
    /// Uploads the scene, which must outlive the renderer, and compiles the programs that its materials call for.
    /// Errors: no room on the GPU; a shader that this driver refuses.
    static Result<NearRenderer> make(const scene::StaticScene& scene);

    NearRenderer(NearRenderer&&) noexcept;
    NearRenderer& operator=(NearRenderer&&) noexcept;
    ~NearRenderer();

    /// Draws the set and writes every pixel of `out` (resized to the view): the nearest triangle's id as the ray
    /// casters name it, and its depth; kUnresolved and +inf where there is none within set.complete_within_m. Blended
    /// triangles are there or not in proportion to their alpha, by the casters' own hash, so that the far field goes on
    /// where the near one ends. Where it pays, instances behind what is big and near are left out (set_occlusion); that
    /// changes no pixel.
    Status render_ids(const PinholeView& view, const DrawSet& set, farfield::VisibilityBuffer& out, NearStats& stats);

    /// Draws and shades the set, the sky behind it, blended triangles back to front over both; reads the picture back.
    Status render_shaded(const PinholeView& view, const DrawSet& set, shading::Image& out, NearStats& stats);

    /// How render_ids culls by occlusion from now on. The default price is llvmpipe's, or for a GPU fifty times that.
    void set_occlusion(const OcclusionSettings& settings);

    /// Shows an image on the current context's default framebuffer, scaled to `width` x `height` pixels.
    Status present(const shading::Image& image, int width, int height);

    [[nodiscard]] std::uint64_t memory_bytes() const;
    /// Programs of materials that were compiled with `#define DEFINE`.
    [[nodiscard]] std::uint64_t programs_with(std::string_view define) const;

  private:
    struct Impl;
    explicit NearRenderer(std::unique_ptr<Impl> impl);
    std::unique_ptr<Impl> impl_;
};

}  // namespace ff::nearfield
