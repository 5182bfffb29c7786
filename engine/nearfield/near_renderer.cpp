#include "engine/nearfield/near_renderer.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include "engine/gl/device.h"
#include "engine/gl/program.h"
#include "engine/gl/target.h"
#include "engine/nearfield/blended_indices.h"
#include "engine/nearfield/gpu_scene.h"
#include "engine/nearfield/material_programs.h"
#include "engine/nearfield/occlusion_split.h"
#include "engine/nearfield/vertex_input.h"
#include "engine/nearfield/view_uniforms.h"

namespace ff::nearfield {
namespace {

enum UniformBinding : GLuint { kViewBinding = 0, kShadingBinding = 1, kMaterialBinding = 2 };
constexpr GLuint kTriangleNamesBinding = 0;  // of the storage buffers
enum TextureUnit : GLuint {
    kBaseColorUnit = 0,
    kEmissiveUnit = 1,
    kMetallicRoughnessUnit = 2,
    kBaseColorNearestUnit = 3,
    kSkyUnit = 4,
};

/// A GPU draws more triangles in the time of one reading back than llvmpipe does, in about this proportion.
constexpr std::uint64_t kGpuPrice = 50;

Result<gl::Texture> make_white_texture() {
    FF_ASSIGN(gl::Texture white, gl::Texture::make(GL_RGBA8, 1, 1));
    const std::uint32_t texel = 0xFFFFFFFFu;
    white.write_level(0, GL_RGBA, GL_UNSIGNED_BYTE, std::as_bytes(std::span(&texel, 1)));
    white.set_filter(GL_NEAREST, GL_NEAREST);
    return white;
}

/// The sky's panorama, where the scene has one; otherwise nothing.
Result<gl::Texture> upload_sky(const scene::Environment& environment) {
    if (environment.panorama_width == 0 || environment.panorama.empty()) return gl::Texture();
    FF_ASSIGN(gl::Texture sky,
              gl::Texture::make(GL_RGBA16F, int(environment.panorama_width), int(environment.panorama_height)));
    sky.write_level(0, GL_RGBA, GL_HALF_FLOAT, std::as_bytes(environment.panorama));
    sky.set_wrap(GL_REPEAT, GL_CLAMP_TO_EDGE);
    sky.set_filter(GL_LINEAR, GL_LINEAR);
    return sky;
}

void delete_sampler(GLuint id) {
    glDeleteSamplers(1, &id);
}

}  // namespace

struct NearRenderer::Impl {
    const scene::StaticScene& scene;
    GpuScene gpu;
    MaterialPrograms materials;
    gl::Program opaque_ids, masked_ids, blended_ids, sky_program;
    gl::Texture white, sky;
    std::vector<gl::Object<delete_sampler>> nearest_samplers;  // by wrap_u * 3 + wrap_v
    VertexInput vertex_input;
    gl::StreamBuffer records, commands, blended_indices, view_uniforms, shading_uniforms;
    gl::Target ids_target, color_target;
    gl::Texture presented;
    gl::Object<gl::detail::delete_framebuffer> present_framebuffer;
    DrawList list;
    BlendedIndices blended;
    OcclusionSettings occlusion;
    OcclusionSplit split;
    visibility::OcclusionBuffer occlusion_buffer;
    std::vector<std::uint32_t> id_pixels;  // rows of (instance, GPU triangle) pairs
    std::vector<float> depth_pixels;

    explicit Impl(const scene::StaticScene& drawn) : scene(drawn) {}

    void write_uniforms(gl::StreamBuffer& stream, GLuint binding, const void* data, std::size_t bytes) {
        std::memcpy(stream.begin(bytes).data(), data, bytes);
        glBindBufferRange(GL_UNIFORM_BUFFER, binding, stream.id(), GLintptr(stream.offset()), GLsizeiptr(bytes));
    }

    /// Meshes in poses are new every frame: those of the list are uploaded again.
    void write_poses() {
        const std::size_t first_pose = scene.meshes.size() - scene.posed_mesh_count;
        for (const std::uint32_t id : list.mesh_order) {
            if (id < first_pose) continue;
            const scene::Mesh& mesh = scene.meshes[id];
            const auto write = [&](auto array, gl::Buffer& buffer) {
                buffer.write(mesh.first_vertex * sizeof array[0],
                             std::as_bytes(array.subspan(mesh.first_vertex, mesh.vertex_count)));
            };
            write(scene.positions, gpu.positions);
            write(scene.attributes, gpu.attributes);
        }
    }

    /// Uploads the list; before its first draw.
    void begin_list() {
        write_poses();
        const std::size_t record_bytes = list.records.size() * sizeof(InstanceRecord);
        if (record_bytes > 0) std::memcpy(records.begin(record_bytes).data(), list.records.data(), record_bytes);
        const std::size_t command_bytes = list.commands.size() * sizeof(DrawCommand);
        if (command_bytes > 0) std::memcpy(commands.begin(command_bytes).data(), list.commands.data(), command_bytes);
        vertex_input.bind(gpu.indices.id(), records);
        glBindBuffer(GL_DRAW_INDIRECT_BUFFER, commands.id());
    }

    /// After the list's last draw.
    void end_list() {
        if (!list.records.empty()) records.end();
        if (!list.commands.empty()) commands.end();
    }

    /// Uploads the view and clears the depths; what both kinds of picture need before their first list.
    void begin(const gl::Target& target, const PinholeView& view) {
        const ViewUniforms uniforms = make_view_uniforms(view);
        write_uniforms(view_uniforms, kViewBinding, &uniforms, sizeof uniforms);

        glBindFramebuffer(GL_FRAMEBUFFER, target.id());
        glViewport(0, 0, view.width, view.height);
        glClipControl(GL_LOWER_LEFT, GL_ZERO_TO_ONE);
        glEnable(GL_DEPTH_TEST);
        glDepthFunc(GL_GREATER);
        glDepthMask(GL_TRUE);
        glDisable(GL_CULL_FACE);  // the casters hit both sides
        glDisable(GL_BLEND);
        glDisable(GL_SCISSOR_TEST);
        glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
        const float far_away = 0.0f;
        glClearNamedFramebufferfv(target.id(), GL_DEPTH, 0, &far_away);
    }

    void draw_batch(const DrawBatch& batch, NearStats& stats) {
        glMultiDrawElementsIndirect(
            GL_TRIANGLES, GL_UNSIGNED_INT,
            reinterpret_cast<const void*>(commands.offset() + batch.first_command * sizeof(DrawCommand)),
            GLsizei(batch.command_count), 0);
        stats.draws += batch.command_count;
        ++stats.calls;
    }

    void bind_texture(GLuint unit, std::uint32_t texture) {
        glBindTextureUnit(unit, texture == scene::kNoTexture ? white.id() : gpu.textures[texture].id());
    }

    void bind_material(std::uint32_t index) {
        const scene::Material& material = scene.materials[index];
        glBindBufferRange(GL_UNIFORM_BUFFER, kMaterialBinding, materials.uniforms.id(),
                          GLintptr(std::uint64_t(index) * materials.stride_bytes), GLsizeiptr(kMaterialUniformBytes));
        bind_texture(kBaseColorUnit, material.base_color_texture);
        bind_texture(kBaseColorNearestUnit, material.base_color_texture);
        bind_texture(kEmissiveUnit, material.emissive_texture);
        bind_texture(kMetallicRoughnessUnit, material.metallic_roughness_texture);
        GLuint sampler = nearest_samplers[0].id();
        if (material.base_color_texture != scene::kNoTexture) {
            const scene::Texture& texture = scene.textures[material.base_color_texture];
            sampler = nearest_samplers[std::size_t(texture.wrap_u) * 3 + std::size_t(texture.wrap_v)].id();
        }
        glBindSampler(kBaseColorNearestUnit, sampler);
    }

    void draw_blended(NearStats& stats) {
        if (list.blended.empty()) return;
        blended.sort(scene, gpu.layout, list);
        const std::size_t bytes = blended.indices.size() * sizeof(std::uint32_t);
        std::memcpy(blended_indices.begin(bytes).data(), blended.indices.data(), bytes);
        vertex_input.bind(blended_indices.id(), records);
        glEnable(GL_BLEND);
        glBlendFunc(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA);
        glDepthMask(GL_FALSE);
        std::uint32_t bound = ~0u;
        for (std::size_t i = 0; i < list.blended.size(); ++i) {
            const BlendedDraw& draw = list.blended[i];
            const MaterialGroup& group = gpu.layout.groups[draw.group];
            if (group.material != bound) {
                bound = group.material;
                glUseProgram(materials.programs[materials.program_of[bound]].id());
                bind_material(bound);
            }
            const std::uint64_t offset =
                blended_indices.offset() + std::uint64_t(blended.first_index[i]) * sizeof(std::uint32_t);
            glDrawElementsInstancedBaseVertexBaseInstance(GL_TRIANGLES, GLsizei(3 * group.triangle_count),
                                                          GL_UNSIGNED_INT, reinterpret_cast<const void*>(offset), 1,
                                                          GLint(scene.meshes[draw.mesh].first_vertex), draw.record);
        }
        blended_indices.end();
        glDepthMask(GL_TRUE);
        glDisable(GL_BLEND);
        stats.draws += list.blended.size();
        stats.calls += list.blended.size();
    }

    void draw_ids(const PinholeView& view, const DrawSet& set, NearStats& stats);
    void read_depths(const PinholeView& view);
    void read_ids(const PinholeView& view, const DrawSet& set, farfield::VisibilityBuffer& out);
};

namespace {

Status check_view(const PinholeView& view) {
    GLint limit = 0;
    glGetIntegerv(GL_MAX_VIEWPORT_DIMS, &limit);
    if (view.width < 1 || view.height < 1 || view.width > limit || view.height > limit)
        return usage_error(fmt::format("image of {}x{} pixels; OpenGL here takes 1x1 to {}x{}", view.width, view.height,
                                       limit, limit));
    return {};
}

Status fit_target(gl::Target& target, GLenum format, const PinholeView& view) {
    FF_TRY(check_view(view));
    if (target.id() != 0 && target.width() == view.width && target.height() == view.height) return {};
    FF_ASSIGN(target, gl::Target::make(format, view.width, view.height));
    return {};
}

/// Metres along the longest ray of the view at a depth of one metre.
double longest_ray(const PinholeView& view) {
    double longest = 0.0;
    for (const int x : {0, view.width})
        for (const int y : {0, view.height}) {
            const double u = double(view.u_first) + x * double(view.u_step);
            const double v = double(view.v_first) + y * double(view.v_step);
            longest = std::max(longest, std::sqrt(1.0 + u * u + v * v));
        }
    return longest;
}

}  // namespace

NearRenderer::NearRenderer(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
NearRenderer::NearRenderer(NearRenderer&&) noexcept = default;
NearRenderer& NearRenderer::operator=(NearRenderer&&) noexcept = default;
NearRenderer::~NearRenderer() = default;

Result<NearRenderer> NearRenderer::make(const scene::StaticScene& scene) {
    auto impl = std::make_unique<Impl>(scene);
    FF_ASSIGN(impl->gpu, upload_scene(scene));
    FF_ASSIGN(impl->materials, make_shaded_programs(scene, impl->gpu.has_vertex_colors));
    FF_ASSIGN(impl->opaque_ids, gl::Program::make("near_ids.vert.glsl", "near_ids.frag.glsl"));
    const bool sways = std::any_of(scene.materials.begin(), scene.materials.end(), [](const scene::Material& material) {
        return (material.flags & scene::kMaterialSways) != 0;
    });
    FF_ASSIGN(impl->masked_ids,
              gl::Program::make("near_ids.vert.glsl", "near_ids.frag.glsl",
                                sways ? "#define SEE_THROUGH\n#define SWAYS\n" : "#define SEE_THROUGH\n"));
    FF_ASSIGN(impl->blended_ids, gl::Program::make("near_ids.vert.glsl", "near_ids.frag.glsl",
                                                   "#define SEE_THROUGH\n#define BLENDED\n", "near_ids.geom.glsl"));
    FF_ASSIGN(impl->sky_program, gl::Program::make("sky.vert.glsl", "sky.frag.glsl"));
    FF_ASSIGN(impl->white, make_white_texture());
    FF_ASSIGN(impl->sky, upload_sky(scene.environment));
    constexpr GLenum kWraps[] = {GL_REPEAT, GL_CLAMP_TO_EDGE, GL_MIRRORED_REPEAT};  // in the order of scene::Wrap
    for (GLenum u : kWraps) {
        for (GLenum v : kWraps) {
            GLuint sampler = 0;
            glCreateSamplers(1, &sampler);
            glSamplerParameteri(sampler, GL_TEXTURE_MIN_FILTER, GL_NEAREST_MIPMAP_NEAREST);
            glSamplerParameteri(sampler, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
            glSamplerParameteri(sampler, GL_TEXTURE_WRAP_S, GLint(u));
            glSamplerParameteri(sampler, GL_TEXTURE_WRAP_T, GLint(v));
            impl->nearest_samplers.emplace_back(sampler);
        }
    }
    impl->vertex_input = VertexInput::make(impl->gpu);
    FF_ASSIGN(const gl::DeviceInfo device, gl::query_device());
    if (!device.is_software) impl->occlusion.price_triangles *= kGpuPrice;
    return NearRenderer(std::move(impl));
}

void NearRenderer::set_occlusion(const OcclusionSettings& settings) {
    impl_->occlusion = settings;
}

Status NearRenderer::render_ids(const PinholeView& view, const DrawSet& set, farfield::VisibilityBuffer& out,
                                NearStats& stats) {
    Impl& r = *impl_;
    FF_TRY(fit_target(r.ids_target, GL_RG32UI, view));
    r.begin(r.ids_target, view);
    const GLuint nothing[4] = {farfield::kUnresolved, 0, 0, 0};
    glClearNamedFramebufferuiv(r.ids_target.id(), GL_COLOR, 0, nothing);
    if (r.split.split(r.scene, set, view.position, r.occlusion)) {
        r.draw_ids(view, {.instances = r.split.first(), .dynamic = set.dynamic}, stats);
        r.read_depths(view);
        r.occlusion_buffer.build(view, r.depth_pixels, kNearPlaneM);
        r.split.test_rest(r.scene, set, r.occlusion_buffer);
        r.draw_ids(view, {.instances = r.split.survivors(), .dynamic = set.dynamic}, stats);
        stats.hidden_instances += r.split.hidden_instances();
        stats.hidden_triangles += r.split.hidden_triangles();
    } else {
        r.draw_ids(view, set, stats);
    }
    r.view_uniforms.end();
    r.read_ids(view, set, out);
    return {};
}

/// Draws a set into the target that begin() named, over what is there.
void NearRenderer::Impl::draw_ids(const PinholeView& view, const DrawSet& set, NearStats& stats) {
    make_id_draw_list(scene, gpu.layout, set, view.position, list);
    begin_list();
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, kTriangleNamesBinding, gpu.triangle_names.id());
    for (const DrawBatch& batch : list.batches) {
        if (batch.material == DrawBatch::kAnyOpaque) {
            glUseProgram(opaque_ids.id());
        } else {
            const bool is_blended = layer_of(scene.materials[batch.material]) == MaterialLayer::blended;
            glUseProgram(is_blended ? blended_ids.id() : masked_ids.id());
            bind_material(batch.material);
        }
        draw_batch(batch, stats);
    }
    end_list();
    stats.triangles += list.triangle_count;
}

void NearRenderer::Impl::read_depths(const PinholeView& view) {
    depth_pixels.resize(std::size_t(view.width) * std::size_t(view.height));
    glBindFramebuffer(GL_READ_FRAMEBUFFER, ids_target.id());
    glPixelStorei(GL_PACK_ALIGNMENT, 4);
    glReadPixels(0, 0, view.width, view.height, GL_DEPTH_COMPONENT, GL_FLOAT, depth_pixels.data());
}

void NearRenderer::Impl::read_ids(const PinholeView& view, const DrawSet& set, farfield::VisibilityBuffer& out) {
    const auto width = std::size_t(view.width), height = std::size_t(view.height);
    if (out.width != view.width || out.height != view.height) out.resize(view.width, view.height);
    id_pixels.resize(2 * width * height);
    read_depths(view);
    glReadPixels(0, 0, view.width, view.height, GL_RG_INTEGER, GL_UNSIGNED_INT, id_pixels.data());

    // Of the image's corners, whose rays are the longest at the same depth.
    const float last_depth = float(set.complete_within_m / longest_ray(view));
    // Neighbours mostly show the same instance: look its mesh up once.
    std::uint32_t known_instance = farfield::kUnresolved, mesh = 0;
    for (std::size_t y = 0; y < height; ++y) {
        const std::uint32_t* ids = &id_pixels[2 * y * width];
        const float* depths = &depth_pixels[y * width];
        const std::size_t row = y * std::size_t(out.stride);
        for (std::size_t x = 0; x < width; ++x) {
            const std::uint32_t instance = ids[2 * x];
            const float depth = kNearPlaneM / depths[x];
            if (instance == farfield::kUnresolved || depth > last_depth) {
                out.instance[row + x] = farfield::kUnresolved;
                out.triangle[row + x] = 0;
                out.depth[row + x] = std::numeric_limits<float>::infinity();
                continue;
            }
            out.instance[row + x] = instance;
            if (instance != known_instance) {
                known_instance = instance;
                mesh = instance < scene.instances.size() ? scene.instances[instance].mesh
                                                         : set.dynamic[instance - scene.instances.size()].mesh;
            }
            out.triangle[row + x] = gpu.layout.triangle_of(mesh, ids[2 * x + 1]);
            out.depth[row + x] = depth;
        }
    }
}

Status NearRenderer::render_shaded(const PinholeView& view, const DrawSet& set, shading::Image& out, NearStats& stats) {
    Impl& r = *impl_;
    FF_TRY(fit_target(r.color_target, GL_RGBA8, view));
    make_shaded_draw_list(r.scene, r.gpu.layout, set, view.position, r.materials.draw_order, r.list);
    r.begin(r.color_target, view);
    r.begin_list();
    const scene::Environment& environment = set.environment != nullptr ? *set.environment : r.scene.environment;
    const shading::ShadingUniforms uniforms = shading::make_uniforms(environment, view);
    r.write_uniforms(r.shading_uniforms, kShadingBinding, &uniforms, sizeof uniforms);
    glBindTextureUnit(kSkyUnit, r.sky.id() != 0 ? r.sky.id() : r.white.id());

    std::uint32_t bound_program = ~0u;
    for (const DrawBatch& batch : r.list.batches) {
        const std::uint32_t program = r.materials.program_of[batch.material];
        if (program != bound_program) glUseProgram(r.materials.programs[program].id());
        bound_program = program;
        r.bind_material(batch.material);
        r.draw_batch(batch, stats);
    }
    // The sky last, only where nothing stands: every pixel is shaded about once.
    glUseProgram(r.sky_program.id());
    glDepthFunc(GL_GEQUAL);
    glDrawArrays(GL_TRIANGLES, 0, 3);
    glDepthFunc(GL_GREATER);
    stats.draws += 1;
    stats.calls += 1;
    r.draw_blended(stats);
    stats.triangles += r.list.triangle_count;
    r.end_list();
    r.view_uniforms.end();
    r.shading_uniforms.end();

    if (out.width != view.width || out.height != view.height) out.resize(view.width, view.height);
    glBindFramebuffer(GL_READ_FRAMEBUFFER, r.color_target.id());
    glPixelStorei(GL_PACK_ROW_LENGTH, out.stride);
    glReadPixels(0, 0, view.width, view.height, GL_RGBA, GL_UNSIGNED_BYTE, out.pixels.data());
    glPixelStorei(GL_PACK_ROW_LENGTH, 0);
    return {};
}

Status NearRenderer::present(const shading::Image& image, int width, int height) {
    Impl& r = *impl_;
    if (image.width < 1 || image.height < 1 || width < 1 || height < 1) return {};  // minimised: nothing to show
    if (r.presented.width() != image.width || r.presented.height() != image.height) {
        FF_ASSIGN(r.presented, gl::Texture::make(GL_RGBA8, image.width, image.height));
        GLuint id = 0;
        glCreateFramebuffers(1, &id);
        r.present_framebuffer = gl::Object<gl::detail::delete_framebuffer>(id);
        glNamedFramebufferTexture(id, GL_COLOR_ATTACHMENT0, r.presented.id(), 0);
    }
    glPixelStorei(GL_UNPACK_ROW_LENGTH, image.stride);
    r.presented.write_level(0, GL_RGBA, GL_UNSIGNED_BYTE, std::as_bytes(std::span(image.pixels)));
    glPixelStorei(GL_UNPACK_ROW_LENGTH, 0);
    // The image has its top row first, a window its bottom row: turned over on the way.
    const bool same_size = width == image.width && height == image.height;
    glBlitNamedFramebuffer(r.present_framebuffer.id(), 0, 0, 0, image.width, image.height, 0, height, width, 0,
                           GL_COLOR_BUFFER_BIT, same_size ? GL_NEAREST : GL_LINEAR);
    return {};
}

std::uint64_t NearRenderer::programs_with(std::string_view define) const {
    const std::string line = fmt::format("#define {}\n", define);
    const std::vector<std::string>& programs = impl_->materials.defines;
    return std::uint64_t(std::count_if(programs.begin(), programs.end(), [&](const std::string& defines) {
        return defines.find(line) != std::string::npos;
    }));
}

std::uint64_t NearRenderer::memory_bytes() const {
    return impl_->gpu.memory_bytes(impl_->scene);
}

}  // namespace ff::nearfield
