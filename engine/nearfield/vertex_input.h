#pragma once

#include "engine/gl/buffer.h"
#include "engine/gl/object.h"
#include "engine/nearfield/gpu_scene.h"

namespace ff::nearfield {

namespace detail {
void delete_vertex_array(GLuint id);
}

/// How vertices and instance records reach the shaders (shaders/instance.glsl).
class VertexInput {
  public:
    VertexInput() = default;
    static VertexInput make(const GpuScene& gpu);

    /// Makes it current. @param records  the stream that holds this frame's InstanceRecords
    void bind(GLuint index_buffer, const gl::StreamBuffer& records) const;

  private:
    gl::Object<detail::delete_vertex_array> object_;
};

}  // namespace ff::nearfield
